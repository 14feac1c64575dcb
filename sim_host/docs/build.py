"""The documentation, built from the repository: tutorials, theory, reference. ``make docs``.

Pages beside this file are copied; the reference is made from the sources: commands from the
parser, frames from the DBC, ranges from the core, C from the comments of the headers, Python from
docstrings. Then mkdocs builds the site in strict mode, every link of it is followed, and every
swaywatch command in the pages is parsed. Nothing is fetched; the site asks no host for anything.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import html
import io
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PACKAGE = ROOT / "sim_host" / "src" / "swaywatch"


def cell(text: object) -> str:
    """Text for a cell of a table."""
    plain = " ".join(str(text).split())
    return re.sub(r"([|<>*_\[\]`])", r"\\\1", plain)


def table(head: list[str], rows: list[list[object]]) -> str:
    """A Markdown table; cells that are Markdown already are given as :class:`Raw`."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for row in rows:
        cells = [str(item) if isinstance(item, Raw) else cell(item) for item in row]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


class Raw(str):
    """Markdown that stays as it is."""

    __slots__ = ()


def code(text: object) -> Raw:
    """Text as code."""
    return Raw(f"`{text}`") if str(text) else Raw("")


# --- reference, from the sources ------------------------------------------------------------------
def commands() -> str:
    """Every command with its options, from the parser."""
    from swaywatch.cli import __doc__ as codes
    from swaywatch.cli import build_parser

    parser = build_parser()
    action = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    exits = " ".join((codes or "").partition("Exit code ")[2].split())
    parts = ["# Command line\n", f"Exit code {cell(exits)}\n"]
    for name, inner in action.choices.items():
        parts += [f"## {name}\n", cell(inner.description or "") + "\n"]
        parts.append(f"```text\n{inner.format_usage().strip()}\n```\n")
        rows: list[list[object]] = []
        for option in inner._actions:
            formatter = inner._get_formatter()
            words = formatter._format_action_invocation(option)
            rows.append([code(words), formatter._expand_help(option) if option.help else ""])
        parts.append(table(["option", "what it does"], rows))
    return "\n".join(parts)


def frames() -> str:
    """Every frame of the DBC with its signals."""
    import cantools

    database: Any = cantools.database.load_file(ROOT / "dbc" / "swaywatch.dbc", strict=True)
    parts = ["# CAN frames\n", "From `dbc/swaywatch.dbc`.\n"]
    for message in sorted(database.messages, key=lambda m: m.frame_id):
        cycle = f", every {message.cycle_time} ms" if message.cycle_time else ""
        parts.append(f"## {message.name}\n")
        parts.append(f"`0x{message.frame_id:X}`, {message.length} bytes{cycle}. "
                     f"{cell(message.comment or '')}\n")  # fmt: skip
        rows: list[list[object]] = []
        for signal in message.signals:
            choices = ", ".join(f"{k} {v}" for k, v in (signal.choices or {}).items())
            rows.append([
                code(signal.name), f"{signal.start}|{signal.length}", signal.scale,
                signal.unit or "", _range(signal.minimum, signal.maximum),
                ". ".join(filter(None, [signal.comment, choices])),
            ])  # fmt: skip
        head = ["signal", "bits", "step", "unit", "range", "meaning"]
        parts.append(table(head, rows))
    return "\n".join(parts)


def _range(low: object, high: object) -> str:
    return "" if low is None and high is None else f"{low} .. {high}"


def parameters() -> str:
    """Roles of signals, and the ranges of vehicle.toml as the core has them."""
    from swaywatch.ecu.core import vehicle_ranges
    from swaywatch.roles import CHANNELS
    from swaywatch.vehicle_file import _UNITS

    roles: list[list[object]] = [
        [code(name), kind.unit, kind.meaning] for name, kind in CHANNELS.items()
    ]
    ranges: list[list[object]] = [
        [code(name), f"{low:g}", f"{high:g}", _UNITS.get(name.partition(".")[2], "")]
        for name, (low, high) in vehicle_ranges().items()
    ]
    return "\n".join([
        "# Roles and parameters\n", "## Roles\n", "For `signals.toml`.\n",
        table(["role", "unit", "what it is"], roles),
        "## vehicle.toml\n", "Lowest and highest value that the core takes, SI units.\n",
        table(["key", "from", "to", "unit"], ranges),
    ])  # fmt: skip


def effects() -> str:
    """What a diagnosis can name and a scenario can switch on, with equation and source."""
    from swaywatch.commands.physics import known

    parts = ["# Effects and laws\n", "What `diagnose` can name and `simulate` can switch on.\n"]
    for name, row in known().items():
        who = [word for key, word in (("reported", "diagnose"), ("simulated", "simulate"))
               if row[key]]  # fmt: skip
        sizes = ", ".join(f"{p['name']} [{p['unit']}]" for p in row["parameters"])
        rows: list[list[object]] = [
            ["equation", row["equation"]], ["source", row["source"]],
            ["parameters", sizes], ["known to", ", ".join(who)],
        ]  # fmt: skip
        parts += [f"## {name}\n", table(["", cell(row["title"])], rows)]
    return "\n".join(parts)


def c_page(title: str, headers: list[Path]) -> str:
    """Headers with their comments, in the order given."""
    return "\n".join([f"# {title}\n", *(c_header(path) for path in headers)])


def c_header(path: Path) -> str:
    """One header: what it says of itself, then each declaration with the comment above it."""
    lines = path.read_text(encoding="utf-8").splitlines()
    while lines and not lines[0].startswith("///"):
        lines.pop(0)
    head: list[str] = []
    while lines and lines[0].startswith("///"):
        head.append(lines.pop(0)[3:].removeprefix(" "))
    parts = [f"## {path.name}\n", f"`{path.relative_to(ROOT)}`\n", "```text", *head, "```\n"]
    for comment, declaration in _declarations(lines):
        if comment:
            parts += ["```text", *comment, "```\n"]
        parts += ["```c", *declaration, "```\n"]
    return "\n".join(parts)


def _declarations(lines: list[str]) -> Iterator[tuple[list[str], list[str]]]:
    """Comments and the declarations below them; includes and guards are left out."""
    comment: list[str] = []
    declaration: list[str] = []
    depth = 0
    for line in lines:
        if not declaration and line.startswith("///"):
            comment.append(line[3:].removeprefix(" "))
        elif not declaration and re.match(
            r"\s*($|//|#(?!define)|SWAY_C_|#define SWAY_\w+_H$)", line
        ):
            comment = []
        else:
            declaration.append(line)
            bare = re.sub(r"//.*", "", line)
            depth += bare.count("{") - bare.count("}")
            macro = declaration[0].startswith("#define")
            if (not bare.rstrip().endswith("\\")) if macro else _ends(bare, depth):
                yield comment, declaration
                comment, declaration, depth = [], [], 0


def _ends(line: str, depth: int) -> bool:
    return depth <= 0 and line.rstrip().endswith((";", "}"))


def python() -> str:
    """Public functions and classes of the package, from their docstrings."""
    parts = [
        "# Python\n",
        "Public functions and classes; shapes, units and errors in their words.\n",
    ]
    for path in sorted(PACKAGE.rglob("*.py")):
        inside = path.relative_to(PACKAGE.parent).with_suffix("")
        if "commands" in inside.parts or any(p.startswith("_") and p != "__init__"
                                             for p in inside.parts):  # fmt: skip
            continue
        tree = ast.parse(path.read_text(encoding="utf-8"))
        found = list(_documented(tree))
        name = ".".join(inside.parts).removesuffix(".__init__")
        about = ast.get_docstring(tree)
        if about and (found or inside.name == "__init__"):
            parts += [f"## {name}\n", f"```text\n{about}\n```\n", *found]
    return "\n".join(parts)


def _documented(tree: ast.Module | ast.ClassDef, inside: str = "") -> Iterator[str]:
    for node in tree.body:
        if not isinstance(node, ast.FunctionDef | ast.ClassDef) or node.name.startswith("_"):
            continue
        text = ast.get_docstring(node)
        if text is None:
            continue
        if isinstance(node, ast.FunctionDef):
            gives = f" -> {ast.unparse(node.returns)}" if node.returns else ""
            yield f"```python\n{inside}{node.name}({ast.unparse(node.args)}){gives}\n```\n"
        else:
            yield f"```python\nclass {node.name}\n```\n"
        yield f"```text\n{text}\n```\n"
        if isinstance(node, ast.ClassDef):
            yield from _documented(node, f"{node.name}.")


def core_headers() -> list[Path]:
    """Headers of lib/: the users' first, then the rooms."""
    lib = ROOT / "lib"
    first = ["sway_node.h", "sway_core.h", "sway_status.h", "sway_vehicle.h", "sway_config.h"]
    public = [lib / name for name in first] + sorted(
        path for path in lib.glob("*.h") if path.name not in first
    )
    rooms = ("arithmetic", "signal", "model", "judge", "bus")
    return public + [path for room in rooms for path in sorted((lib / room).glob("*.h"))]


def port_headers() -> list[Path]:
    """Headers of port/ that every port shares, and of XCP."""
    port = ROOT / "port"
    rest = [path for path in sorted(port.glob("*.h")) if path.name != "sway_port.h"]
    return [port / "sway_port.h", *rest, *sorted((port / "xcp").glob("*.h"))]


MADE: dict[str, Callable[[], str]] = {
    "commands.md": commands,
    "frames.md": frames,
    "parameters.md": parameters,
    "effects.md": effects,
    "c-core.md": lambda: c_page("C, core", core_headers()),
    "c-ports.md": lambda: c_page("C, ports", port_headers()),
    "python.md": python,
}


# --- checks ---------------------------------------------------------------------------------------
class _Page(HTMLParser):
    """Links, anchors and things that a page loads."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.anchors = {""}
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take note of what a tag refers to."""
        found = {name: value or "" for name, value in attrs}
        self.anchors |= {found[name] for name in ("id", "name") if name in found}
        if tag == "a" and "href" in found:
            self.links.append(found["href"])
        elif tag == "link" and "href" in found and found.get("rel") != "canonical":
            self.loaded.append(found["href"])
        elif "src" in found:
            self.loaded.append(found["src"])


def broken_links(site: Path) -> list[str]:
    """Links of a site that lead nowhere, and what it would load from another host."""
    pages = {path: _Page(path.read_text(encoding="utf-8")) for path in sorted(site.rglob("*.html"))}
    wrong = []
    for path, page in pages.items():
        name = path.relative_to(site)
        for link in page.links + page.loaded:
            to = urlsplit(link)
            if to.scheme or to.netloc:
                if link in page.loaded and to.scheme != "data":
                    wrong.append(f"{name}: loads {link}, which is not of this site")
                continue
            target = (path.parent / unquote(to.path)).resolve() if to.path else path
            if not target.is_file():
                wrong.append(f"{name}: {link}: no such page")
            elif (
                to.fragment
                and target in pages
                and unquote(to.fragment) not in (pages[target].anchors)
            ):
                wrong.append(f"{name}: {link}: no such heading")
    return wrong


def wrong_commands(text: str) -> list[str]:
    """Commands of swaywatch in a page's shell blocks that its parser does not take."""
    from swaywatch.cli import build_parser

    wrong = []
    for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL):
        for line in block.splitlines():
            words = shlex.split(line, comments=True)
            if words[:1] != ["swaywatch"]:
                continue
            said = io.StringIO()
            try:
                with contextlib.redirect_stderr(said):
                    build_parser(words[1]).parse_args(words[1:])
            except (SystemExit, ModuleNotFoundError):
                wrong.append(f"{line}: {said.getvalue().strip().splitlines()[-1:]}")
    return wrong


def build(out: Path) -> list[str]:
    """Build the site below `out`; what is wrong with it."""
    source, site = out / "source", out / "site"
    for folder in (source, site):
        shutil.rmtree(folder, ignore_errors=True)
    source.mkdir(parents=True)
    wrong = []
    for path in sorted(HERE.glob("*.md")):
        text = path.read_text(encoding="utf-8")
        wrong += [f"{path.name}: {what}" for what in wrong_commands(text)]
        (source / path.name).write_text(text, encoding="utf-8")
    for name, make in MADE.items():
        (source / name).write_text(make(), encoding="utf-8")
    shutil.copy(HERE / "site.css", source)
    shutil.copy(HERE / "picture.svg", source)
    shutil.copy(HERE / "mkdocs.yml", out)
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "-f",
         str(out / "mkdocs.yml")],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode:
        return [*wrong, html.unescape(done.stdout + done.stderr).strip()]
    (site / "404.html").unlink()  # for a server; its links begin at the root
    return wrong + broken_links(site)


def main() -> int:
    """Build; 1 where something is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    args = parser.parse_args()
    wrong = build(args.out.resolve())
    for line in wrong:
        print(line, file=sys.stderr)
    if not wrong:
        print(args.out / "site" / "index.html")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
