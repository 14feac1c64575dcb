"""``swaywatch reproduce``: chapters 1 and 3 to 6 of the reference as one report."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

from swaywatch.errors import SwaywatchError


def add_parser(subparsers: Any) -> None:
    """Add the ``reproduce`` command."""
    parser = subparsers.add_parser(
        "reproduce",
        help="reproduce figures and tables of the reference dissertation as a report",
        description="Simulate the drives of chapters 1 and 3 to 6 of the reference, identify them "
        "with the C core, and write their figures and tables to DIR/reproduce.html, each number "
        "beside the reference's, met or missed; a miss names the computed experiment that "
        "explains it. Exit code 1 if one has no explanation.",
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder to write to")
    parser.add_argument(
        "--workers",
        type=int,
        metavar="N",
        help="number of processes (default: one for each processor core)",
    )


def run(args: argparse.Namespace) -> int:
    """Make the report; exit code 1 if a figure misses its reference and nothing says why."""
    from swaywatch.reproduce import chapter3, chapter5, chapter6, courses, leads
    from swaywatch.reproduce.page import make_page

    start = time.monotonic()
    chapters = []
    for module in (chapter3, chapter5, chapter6, courses, leads):
        chapter = module.make(args.workers)
        chapters.append(chapter)
        print(chapter.title)
        for check in chapter.checks:
            print(
                f"  {'met   ' if check.met else 'MISSED'} {check.what}: {check.value:.4g} "
                f"(reference: {check.words()})"
            )
            if not check.met and check.cause:
                print(f"         {check.cause}")
    page = make_page(chapters, time.monotonic() - start)
    try:
        args.out.mkdir(parents=True, exist_ok=True)
        (args.out / "reproduce.html").write_text(page, encoding="utf-8")
    except OSError as error:
        raise SwaywatchError(f"{args.out}: cannot be written: {error.strerror}") from None
    checks = [check for chapter in chapters for check in chapter.checks]
    missed = [check for check in checks if not check.met]
    unsaid = sum(not check.cause for check in missed)
    print(
        f"{args.out / 'reproduce.html'}: {len(checks) - len(missed)} of {len(checks)} figures meet "
        f"the reference, {len(missed)} miss it"
        + (f", {unsaid} of them without a cause" if unsaid else ", each with its cause")
    )
    return 1 if unsaid else 0
