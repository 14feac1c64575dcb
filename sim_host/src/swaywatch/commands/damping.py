"""``swaywatch damping``: free oscillations of any recording; frequency, damping, course, zero."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from swaywatch.damping.data import Choice
from swaywatch.damping.model import load_model
from swaywatch.damping.page import make_page
from swaywatch.damping.sentences import interval, sentences, verdict
from swaywatch.damping.study import Study, StudyPlan, as_json, evaluate
from swaywatch.errors import SignalError
from swaywatch.recording.guard import whole_file
from swaywatch.terminal import output
from swaywatch.terminal.progress import LateProgress

HAS_JSON = True


def add_parser(subparsers: Any) -> None:
    """Add the ``damping`` command."""
    parser = subparsers.add_parser(
        "damping",
        help="free oscillations of any recording: frequency, damping ratio, course over speed",
        description="Find the free oscillations of recordings (any vehicle, any channels, 0.2 to "
        "10 Hz) and estimate frequency, damping ratio and growth of each with its interval; the "
        "damping against speed and where it is zero; two groups of runs, or a linear model, "
        "compared.",
    )
    parser.add_argument("recording", type=Path, nargs="+", help="files of any supported format")
    parser.add_argument(
        "--channel", action="append", default=[], metavar="NAME",
        help="a signal that oscillates; repeat the option for several, which share one frequency "
        "and damping ratio. Default: the "
        "signals named yaw rate, roll rate, lateral acceleration, articulation ...",
    )  # fmt: skip
    parser.add_argument(
        "--input", action="append", default=[], metavar="NAME",
        help="input of the driver or pilot (not output of a damper or controller): oscillations "
        "that it drives are reported as forced. Default: signals named hand wheel, stick, rudder, "
        "aileron ...; none: no input",
    )  # fmt: skip
    parser.add_argument(
        "--along", action="append", default=[], metavar="NAME",
        help="angle between two bodies (articulation, fork) that oscillates with the signal: a "
        "swing in which its amplitude and phase relative to the signal differ from the other "
        "swings', because a hand or a gust still acts, is reported as another motion; needs six "
        "swings at a speed. Default: signals named fork angle, articulation or hitch angle; none: "
        "no such angle",
    )  # fmt: skip
    parser.add_argument(
        "--against", metavar="NAME",
        help="signal on the horizontal axis of the damping plot (default: the speed, if a "
        "signal has that name)",
    )  # fmt: skip
    parser.add_argument(
        "--against-values", type=float, nargs="+", default=[], metavar="X",
        help="instead of --against: one number for each recording",
    )  # fmt: skip
    parser.add_argument(
        "--signals",
        type=Path,
        metavar="TOML",
        help="signals.toml of the recordings; the names above are then its roles",
    )
    parser.add_argument(
        "--dbc",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="DBC file that decodes CAN frames; may be repeated",
    )
    parser.add_argument(
        "--band", type=float, nargs=2, default=(0.2, 10.0), metavar=("LOW", "HIGH"),
        help="range of frequencies to search, Hz (default: 0.2 10)",
    )  # fmt: skip
    parser.add_argument(
        "--compare", type=Path, nargs="+", default=[], metavar="RECORDING",
        help="a second group of recordings to compare",
    )  # fmt: skip
    parser.add_argument(
        "--names",
        nargs=2,
        default=("first", "second"),
        metavar="NAME",
        help="names of the two groups",
    )
    parser.add_argument(
        "--model", metavar="LINEAR",
        help="a linear model to compare with: .csv (FILE.csv:VARIANT), .mat, .npz or .py",
    )  # fmt: skip
    parser.add_argument(
        "--out", type=Path, default=Path("swaywatch-damping"), metavar="DIR",
        help="folder for damping.html and damping.json (default: %(default)s)",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Evaluate, write the files, print the summary."""
    low, high = args.band
    if not 0.05 <= low < high <= 50.0:
        raise SignalError(f"--band {low:g} {high:g}: expected 0.05 <= LOW < HIGH <= 50 Hz")
    choice = Choice(
        tuple(args.channel), tuple(args.input), args.against, args.signals, tuple(args.dbc),
        tuple(args.along),
    )  # fmt: skip
    plan = StudyPlan(choice, (low, high), tuple(args.against_values))
    model = load_model(args.model) if args.model else None
    with LateProgress(Console(stderr=True)) as progress:
        study = evaluate(
            args.recording, plan, compare=args.compare, names=tuple(args.names), model=model,
            progress=progress.tell,
        )  # fmt: skip
        progress.tell("writing the report", 0.0, 1.0)
        written = write(study, _sources(args), args.out, "damping")
    say(args, study, written)
    return 0


def say(args: argparse.Namespace, study: Study, written: list[Path]) -> None:
    """The summary, and where the files are."""
    output.result(args, as_json(study))
    console = Console(highlight=False)
    _print(console, study)
    for path in written:
        console.print(str(path), style="bold" if path.suffix == ".html" else "", soft_wrap=True)


def _sources(args: argparse.Namespace) -> dict[str, list[Path]]:
    sources = {"recording": [*args.recording, *args.compare]}
    if args.signals is not None:
        sources["signals"] = [args.signals]
    if args.model:
        file = Path(args.model)
        sources["model"] = [file if file.is_file() else Path(args.model.rpartition(":")[0])]
    return sources


def write(study: Study, sources: dict[str, list[Path]], out: Path, stem: str) -> list[Path]:
    """Page and figures of an evaluation."""
    written = []
    for name, text in (
        (f"{stem}.json", json.dumps(as_json(study), indent=1, allow_nan=False)),
        (f"{stem}.html", make_page(study, sources)),
    ):
        path = out / name
        with whole_file(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
        written.append(path)
    return written


def _print(console: Console, study: Study) -> None:
    colour = {"good": "green", "near": "yellow", "bad": "red"}
    kind, sentence = verdict(study)
    console.print(sentence, style=f"bold {colour[kind]}", markup=False)
    for text in sentences(study):
        console.print(f"- {text}", markup=False)
    names: tuple[str | None, str | None] = (None, None) if study.compared is None else study.names
    for name, one in zip(names, (study, study.compared), strict=True):
        if one is not None and one.places:
            console.print(_table(one, name))


def _table(study: Study, name: str | None) -> Table:
    table = Table(box=None, pad_edge=False, title=name, title_justify="left")
    unit = f" [{study.against_unit}]" if study.against_unit else ""
    heads = (f"{study.against_name}{unit}", "windows", "frequency [Hz]", "damping ratio",
             "growth [1/s]")  # fmt: skip
    for head in heads:
        table.add_column(head.replace("[", r"\["), justify="right")
    for place in study.places:
        table.add_row(
            "" if math.isnan(place.against) else f"{place.against:.4g}",
            str(place.count),
            interval(place.frequency_hz),
            interval(place.damping_ratio) if place.determinable else "not determinable",
            interval(place.growth_1_s, 2),
        )
    return table
