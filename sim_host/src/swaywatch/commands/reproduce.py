"""``swaywatch reproduce``: chapters 3, 5 and 6 of the reference as one report."""

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
        help="reproduce chapters 3, 5 and 6 of the reference dissertation as a report",
        description="Simulate the drives of chapters 3, 5 and 6 of the reference, identify them "
        "with the C core, and write DIR/reproduce.html: root locus, critical speed, Fig. 3-4 to "
        "3-7, Tables 5-1 and 5-2, Fig. 6-5, the second-phase validation with Table 6-3.",
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder to write to")
    parser.add_argument("--workers", type=int, metavar="N", help="processes (default: one a core)")


def run(args: argparse.Namespace) -> int:
    """Make the report; exit code 1 if a figure misses its reference."""
    from swaywatch.reproduce import chapter3, chapter5, chapter6
    from swaywatch.reproduce.page import make_page

    start = time.monotonic()
    chapters = []
    for module in (chapter3, chapter5, chapter6):
        chapter = module.make(args.workers)
        chapters.append(chapter)
        print(chapter.title)
        for check in chapter.checks:
            print(
                f"  {'met   ' if check.met else 'MISSED'} {check.what}: {check.value:.4g} "
                f"(reference: {check.words()})"
            )
    page = make_page(chapters, time.monotonic() - start)
    try:
        args.out.mkdir(parents=True, exist_ok=True)
        (args.out / "reproduce.html").write_text(page, encoding="utf-8")
    except OSError as error:
        raise SwaywatchError(f"{args.out}: cannot be written: {error.strerror}") from None
    missed = sum(not check.met for chapter in chapters for check in chapter.checks)
    total = sum(len(chapter.checks) for chapter in chapters)
    print(f"{args.out / 'reproduce.html'}: {total - missed} of {total} figures meet the reference")
    return 0 if missed == 0 else 1
