"""lib/ as DESIGN.md describes it: every file in the list, none includes what stands below it."""

from __future__ import annotations

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
    assert violations(fit, '#include "model/sway_stm.h"\n')
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
