"""``swaywatch init``: the two files that a first analysis needs, from a foreign recording."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from swaywatch.errors import SwaywatchError
from swaywatch.nearest import with_known
from swaywatch.terminal import output

HAS_JSON = True


def add_parser(subparsers: Any) -> None:
    """Add the ``init`` command."""
    parser = subparsers.add_parser(
        "init",
        help="start here: list a recording's signals, write signals.toml and vehicle.toml",
        description="List the signals of recordings with rate, range and unit; propose their "
        "roles, from name, unit and the physics between them; ask for what no recording contains; "
        "write signals.toml and vehicle.toml with comments and tolerances; and list which results "
        "they allow. Existing files are kept.",
    )
    parser.add_argument("recording", type=Path, nargs="+", help="recordings of one vehicle")
    parser.add_argument(
        "--dbc", type=Path, nargs="*", default=[], metavar="FILE",
        help="for CAN frames (default: the one beside the recording that decodes most of them)",
    )  # fmt: skip
    parser.add_argument(
        "--out", type=Path, default=Path(), metavar="DIR",
        help="folder for the two files (default: the current one)",
    )  # fmt: skip
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", dest="answers",
        help="answer a question beforehand (their names are shown beside them)",
    )  # fmt: skip
    parser.add_argument(
        "--no-questions", action="store_true",
        help="ask nothing: questions not answered by --set stay open in the files",
    )  # fmt: skip
    parser.add_argument(
        "--typical", action="store_true",
        help="unknown values of the vehicle are those of a typical one, marked as guesses",
    )  # fmt: skip
    parser.add_argument("--force", action="store_true", help="overwrite existing files")


def run(args: argparse.Namespace) -> int:
    """List, propose, ask, write, tell."""
    from rich.console import Console

    from swaywatch.first_files import write
    from swaywatch.first_files.inventory import inventory
    from swaywatch.first_files.propose import LIKELY, propose

    console = Console(highlight=False)
    signals, dbcs = inventory(args.recording, args.dbc)
    console.print(write.signal_table(signals))
    proposals = propose(signals)
    console.print(write.proposal_table(proposals))
    ask = _asker(args)
    chosen, perhaps = {}, []
    for channel, proposal in proposals.items():
        kept = write.confirm(proposal, signals, ask)
        if kept is not None and kept.confidence >= LIKELY:
            chosen[channel] = kept
        else:
            perhaps.append(kept or proposal)
    output.folder(args.out)
    answers = write.vehicle_answers(chosen, ask, typical=args.typical)
    written = []
    for name, text in (
        ("signals.toml", write.signals_toml(chosen, perhaps, dbcs, args.out, answers)),
        ("vehicle.toml", write.vehicle_toml(answers)),
    ):
        path = args.out / name
        if path.exists() and not args.force:
            console.print(
                f"{path}: kept as it is (--force overwrites it)", markup=False, soft_wrap=True
            )
            continue
        try:
            path.write_text(text, encoding="utf-8")
        except OSError as error:
            raise SwaywatchError(f"{path}: cannot be written: {error.strerror}") from None
        written.append(str(path))
        console.print(f"{path}: written", markup=False, soft_wrap=True)
    answerable = [
        *write.what_can_be_answered(chosen, answers), *write.missing_units(perhaps, signals)
    ]  # fmt: skip
    checked = write.check(args.recording, args.out)
    for line in [*answerable, *checked]:
        console.print(line, markup=False, soft_wrap=True)
    output.result(
        args,
        {
            "signals": [
                {"name": s.name, "unit": s.unit, "rate_hz": s.rate_hz,
                 "low": float(s.value.min()), "high": float(s.value.max())} for s in signals
            ],
            "roles": {c: p.__dict__ for c, p in chosen.items()},
            "perhaps": {p.channel: p.__dict__ for p in perhaps},
            "written": written,
            "answers": answerable,
            "checks": checked,
        },
    )  # fmt: skip
    return 0


def _asker(args: argparse.Namespace) -> Callable[[str, str, str], str]:
    """A function that asks a question, by name, with the answer that Enter gives."""
    given: dict[str, str] = {}
    for pair in args.answers:
        name, equals, value = pair.partition("=")
        if not equals or not name:
            raise SwaywatchError(f"--set {pair}: expected NAME=VALUE, such as car.mass=1650")
        given[name.strip()] = value.strip()
    from swaywatch.first_files.write import QUESTIONS

    unknown = [n for n in given if n not in QUESTIONS and not n.startswith("role.")]
    if unknown:
        raise SwaywatchError(
            f"--set {unknown[0]}=...: there is no such question"
            + with_known(unknown[0], (*QUESTIONS, "role.ROLE", "role.ROLE.unit"))
        )
    quiet = args.no_questions or args.quiet or args.json or not sys.stdin.isatty()

    def ask(name: str, question: str, default: str) -> str:
        if name in given:
            return given[name]
        if quiet or not question:
            return default
        shown = f" [{default}]" if default else ""
        try:
            return input(f"{question} ({name}){shown}: ").strip() or default
        except EOFError:
            return default

    return ask
