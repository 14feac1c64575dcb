"""lib/ and the package as DESIGN.md lists them: no file missing, none uses what stands below it."""

from __future__ import annotations

import ast
import re
import subprocess
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LIB = ROOT / "lib"
ROOMS = ["arithmetic", "signal", "model", "judge", "core", "bus"]
BELOW_ALL = {"sway_version", "sway_config", "sway_types", "sway_vehicle", "sway_status"}
"""Public headers that every room may use."""
PLACE_OF_PUBLIC = {"sway_core": ("core", "sway_publish"), "sway_node": ("bus", "sway_frames")}
"""Public headers that stand where their source is: the room, and the file just above it."""


def listed() -> list[str]:
    """Files of lib/ in the order of DESIGN.md, without the endings."""
    rows = re.findall(
        r"^\| [^|]*\| (`sway_\w+`(?: `sway_\w+`)*) \|", (ROOT / "DESIGN.md").read_text(), re.M
    )
    return [name for row in rows for name in re.findall(r"sway_\w+", row)]


def files() -> list[Path]:
    """All sources and headers of lib/."""
    return sorted([*LIB.glob("*.h"), *LIB.glob("*/*.[ch]")])


def rank(header: str) -> float:
    """Place of an included file in the order: rooms, and the list inside a room."""
    name = Path(header).stem
    if name in BELOW_ALL:
        return listed().index(name) - 1000
    if name in PLACE_OF_PUBLIC:
        room, above = PLACE_OF_PUBLIC[name]
        return 100 * ROOMS.index(room) + listed().index(above) + 0.5
    return 100 * ROOMS.index(Path(header).parent.name) + listed().index(name)


def violations(path: Path, text: str) -> list[str]:
    """Includes of `text` that stand at or below its own place, apart from its own header."""
    relative = path.relative_to(LIB)
    own = relative.stem.removesuffix("_read")
    place = rank(str(relative.with_name(f"{own}.h")))
    if relative.suffix == ".c" and own in BELOW_ALL:
        place = 100 * ROOMS.index(relative.parent.name)
    included = re.findall(r'#include "((?:\w+/)?sway_\w+\.h)"', text)
    return [f"{relative}: {h}" for h in included if Path(h).stem != own and rank(h) >= place]


def test_the_list_of_design_is_the_folder() -> None:
    """No file without its line, no line without its file, each in its room."""
    assert {p.stem for p in files() if p.suffix == ".h"} == set(listed())
    assert {p.parent.name for p in LIB.glob("*/*")} == set(ROOMS)


def test_nothing_is_included_upwards() -> None:
    """A file uses only what stands above it in DESIGN.md's list."""
    assert [v for path in files() for v in violations(path, path.read_text())] == []


def test_an_include_upwards_is_found() -> None:
    """The check sees a wrong include, to another room and inside one."""
    fit = LIB / "signal" / "sway_fit.c"
    assert violations(fit, '#include "model/sway_single_track.h"\n')
    assert violations(fit, '#include "signal/sway_line.h"\n')
    assert violations(LIB / "sway_status.h", '#include "sway_core.h"\n')
    assert violations(LIB / "bus" / "sway_frames.h", '#include "sway_node.h"\n')
    assert not violations(fit, '#include "arithmetic/sway_real.h"\n')


def test_every_file_names_its_licence() -> None:
    """First line: SPDX."""
    assert [
        p.name for p in files() if not p.read_text().startswith("// SPDX-License-Identifier: MIT\n")
    ] == []


def test_the_version_is_that_of_the_package() -> None:
    """SWAY_VERSION_* and pyproject.toml."""
    text = (LIB / "sway_version.h").read_text()
    numbers = re.findall(r"define SWAY_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)", text)
    project = tomllib.loads((ROOT / "sim_host" / "pyproject.toml").read_text())
    assert ".".join(numbers) == project["project"]["version"]


def test_the_public_headers_are_for_cpp_too(tmp_path: Path) -> None:
    """A C++ program links the core."""
    source = tmp_path / "user.cpp"
    source.write_text(
        '#include "sway_node.h"\n'
        "static sway_node_t node;\n"
        "int main() {\n"
        "    sway_core_config_t config;\n"
        "    sway_core_defaults(&config);\n"
        "    return sway_node_init(&node, &config) == SWAY_ERROR_VEHICLE ? 0 : 1;\n"
        "}\n"
    )
    program = tmp_path / "user"
    archive = ROOT / "build" / "gcc" / "libsway.a"
    subprocess.run(["make", "-s", "-C", str(ROOT), str(archive.relative_to(ROOT))], check=True)
    subprocess.run(
        ["g++", "-std=c++11", "-Wall", "-Wextra", "-pedantic", "-Werror", f"-I{LIB}",
         str(source), str(archive), "-o", str(program)],
        check=True,
    )  # fmt: skip
    assert subprocess.run([str(program)], check=False).returncode == 0


PACKAGE = ROOT / "sim_host" / "src" / "swaywatch"
COMPILED = {"swaywatch.ecu._core", "swaywatch.plant._plant"}
TO_THE_COMMAND_LINE = {"commands/completion", "commands/manual", "survey/warm"}
"""They describe the whole command line or run it, so they import `cli`, which is below them."""


def modules() -> dict[str, str]:
    """Path without the ending -> text, of every module."""
    found = sorted(PACKAGE.rglob("*.py"))
    return {str(p.relative_to(PACKAGE).with_suffix("")): p.read_text() for p in found}


def places() -> dict[str, int]:
    """Path of a module without the ending -> its place in the list of DESIGN.md.

    `*` is all files of its room that have no place of their own; they share one. A room's
    `__init__` follows its last file.
    """
    rows = re.findall(
        r"^\|([^|]*)\| ((?:`[\w*]+` ?)+)\|[^|]+\|$", (ROOT / "DESIGN.md").read_text(), re.M
    )
    start = next(index for index, (head, _) in enumerate(rows) if head == " top, for all ")
    room, found = "", ["__init__"]
    for head, names in rows[start:]:
        if head.strip():
            room = head.strip(" `") if "`" in head else ""
        found += [f"{room}{name}" for name in names.replace("`", "").split()]
    last = {name.rpartition("/")[0]: name for name in found}
    for folder, name in last.items():
        if folder:
            found.insert(found.index(name) + 1, f"{folder}/__init__")
    assert len(found) == len(set(found)), "a file has two lines"
    place = {name: index for index, name in enumerate(found)}
    for name in modules():
        rest = f"{name.rpartition('/')[0]}/*"
        if name not in place and rest in place:
            place[name] = place[rest]
    return {name: index for name, index in place.items() if not name.endswith("*")}


def imports(module: str, text: str) -> set[str]:
    """What a module of the package imports of it, inside functions and for types too."""
    dotted = {"swaywatch." + name.replace("/", "."): name for name in modules()}
    known = {name.removesuffix(".__init__"): path for name, path in dotted.items()}
    found: set[str] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names = [(alias.name, "") for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module}: a relative import"
            names = [(node.module or "", alias.name) for alias in node.names]
        else:
            continue
        for base, name in names:
            target = f"{base}.{name}" if f"{base}.{name}" in known else base
            if target.split(".")[0] == "swaywatch" and not {target, f"{base}.{name}"} & COMPILED:
                found.add(known[target])
    return found


def upwards(module: str, text: str) -> list[str]:
    """Imports of a module that stand at or below its own place."""
    place = places()
    allowed = {"cli"} if module in TO_THE_COMMAND_LINE else set()
    return [
        f"{module} -> {other}"
        for other in sorted(imports(module, text) - allowed)
        if place[other] >= place[module]
    ]


def test_the_list_of_design_is_the_package() -> None:
    """No module without its line, no line without its module."""
    assert sorted(places()) == sorted(modules())


def test_a_module_imports_only_what_stands_above_it() -> None:
    """So there is no cycle, neither between rooms nor inside one."""
    assert [line for name, text in modules().items() for line in upwards(name, text)] == []


def test_an_import_from_below_is_found() -> None:
    """To another room, inside one, inside a function, of a room itself and of a whole module."""
    below = "from swaywatch.diagnose.engine import diagnose\n"
    assert upwards("plant/lanes", below)
    assert upwards("plant/lanes", f"def late():\n    {below}")
    assert upwards("plant/lanes", "from swaywatch.plant import sprung\n")
    assert upwards("checks/samples", "import swaywatch.checks.quality\n")
    assert upwards("ecu/core", "from swaywatch import cli\n")
    assert upwards("recording/frames", "from swaywatch.recording import read_recording\n")
    assert upwards("effects/library/hitch_damping", "import swaywatch.effects.library.road_bank\n")
    assert not upwards("plant/sprung", "from swaywatch.plant.lanes import BODY\n")
    assert not upwards("cli", below)


def test_the_exceptions_are_used() -> None:
    """An exception that nobody needs any more is taken out."""
    texts = modules()
    assert {n for n in TO_THE_COMMAND_LINE if "cli" in imports(n, texts[n])} == TO_THE_COMMAND_LINE


def test_a_class_has_a_name_of_its_own() -> None:
    """One class of a name in the whole package."""
    names = [
        name for text in modules().values() for name in re.findall(r"^class (\w+)", text, re.M)
    ]
    assert sorted({name for name in names if names.count(name) > 1}) == []
