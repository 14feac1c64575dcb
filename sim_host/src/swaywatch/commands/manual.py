"""``swaywatch manual``: manual pages, made from the commands themselves."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from swaywatch import __version__
from swaywatch.terminal import output


def add_parser(subparsers: Any) -> None:
    """Add the ``manual`` command."""
    parser = subparsers.add_parser(
        "manual",
        help="write the manual pages (man swaywatch-analyze)",
        description="Write a manual page for swaywatch and for each command, for `man -l` or a "
        "folder of MANPATH.",
    )
    parser.add_argument("--out", type=Path, default=Path("man1"), metavar="DIR",
                        help="folder to write to (default: %(default)s)")  # fmt: skip


def pages() -> dict[str, str]:
    """File name -> roff text."""
    from swaywatch.cli import __doc__ as codes
    from swaywatch.cli import build_parser

    parser = build_parser()
    action = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    helps = {choice.dest: choice.help or "" for choice in action._choices_actions}
    exits = (codes or "").partition("Exit code ")[2]
    found = {}
    for name, inner in action.choices.items():
        text = _head(f"swaywatch-{name}", helps.get(name, ""))
        text += ".SH SYNOPSIS\n.nf\n" + _roff(inner.format_usage().partition(": ")[2]) + ".fi\n"
        text += ".SH DESCRIPTION\n" + _roff(inner.description or "") + "\n.SH OPTIONS\n"
        for option in inner._actions:
            text += f".TP\n.B {_roff(_names(option))}\n{_roff(_help(option))}\n"
        text += ".SH EXIT STATUS\n" + _roff(exits) + ".SH SEE ALSO\nswaywatch(1)\n"
        found[f"swaywatch-{name}.1"] = text
    text = _head("swaywatch", parser.description or "")
    text += ".SH SYNOPSIS\n.B swaywatch COMMAND ...\n.SH COMMANDS\n"
    for name in action.choices:
        text += f".TP\n.B {name}\n{_roff(helps.get(name, ''))}\n"
    found["swaywatch.1"] = text + ".SH EXIT STATUS\n" + _roff(exits)
    return found


def _head(name: str, what: str) -> str:
    title = f'.TH "{name.upper()}" 1 "" "swaywatch {__version__}"\n'
    return f"{title}.SH NAME\n{name} \\- {_roff(what)}\n"


def _names(option: argparse.Action) -> str:
    value = option.metavar or (option.dest.upper() if option.nargs != 0 else "")
    if not option.option_strings:
        return str(value)
    return ", ".join(option.option_strings) + (f" {value}" if value else "")


def _help(option: argparse.Action) -> str:
    text = option.help or ""
    return text.replace("%(default)s", str(option.default)).replace("%%", "%")


def _roff(text: str) -> str:
    lines = text.replace("\\", "\\\\").replace("-", "\\-").splitlines()
    return "\n".join("\\&" + line if line[:1] in (".", "'") else line for line in lines) + (
        "\n" if text.endswith("\n") else ""
    )


def run(args: argparse.Namespace) -> int:
    """Write the pages."""
    output.folder(args.out)
    for name, text in pages().items():
        (args.out / name).write_text(text, encoding="utf-8")
    print(f"{args.out}: {len(pages())} pages; man -l {args.out / 'swaywatch.1'}")
    return 0
