"""What a command says, and where: text on standard output, or JSON alone, or nothing."""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TextIO

from swaywatch.errors import SwaywatchError

_stream: TextIO | None = None
verbose = False
"""Tell each step and its time on standard error."""


def add_common(parser: argparse.ArgumentParser, *, as_json: bool) -> None:
    """``-q``, ``-v`` and, where the command has a result, ``--json``."""
    group = parser.add_mutually_exclusive_group()
    group.add_argument("-q", "--quiet", action="store_true", help="print errors only")
    group.add_argument("-v", "--verbose", action="store_true", help="print each step and its time")
    if as_json:
        parser.add_argument(
            "--json", action="store_true",
            help="the result as JSON on standard output, and nothing else there",
        )  # fmt: skip


@contextlib.contextmanager
def text_output(args: argparse.Namespace) -> Iterator[None]:
    """Run a command with its text shown or silenced, as `args` says."""
    global _stream, verbose
    _stream, verbose = sys.stdout, bool(getattr(args, "verbose", False))
    if not (getattr(args, "quiet", False) or getattr(args, "json", False)):
        yield
        return
    with (
        Path(os.devnull).open("w", encoding="utf-8") as nothing,
        contextlib.redirect_stdout(nothing),
    ):
        yield


def result(args: argparse.Namespace, content: Any) -> None:
    """The result of a command, where ``--json`` asks for it."""
    if getattr(args, "json", False):
        stream = _stream or sys.stdout
        json.dump(content, stream, indent=1, allow_nan=False)
        stream.write("\n")
        stream.flush()


def folder(path: Path) -> None:
    """Make the folder for results, or say why not."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SwaywatchError(f"{path}: cannot be made: {error.strerror or error}") from None
