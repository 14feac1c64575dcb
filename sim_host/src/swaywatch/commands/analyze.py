"""``swaywatch analyze``: recordings in; summary, report, JSON and estimates out."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from swaywatch import __version__
from swaywatch.analysis import AXLE_NAMES, DriveResult, analyze, as_json
from swaywatch.commands._options import add_files
from swaywatch.ecu.core import AXLES, USUAL_WINDOW, WINDOW, unit_of
from swaywatch.merge import write_merged
from swaywatch.recording import Series, write_recording
from swaywatch.recording.guard import whole_file
from swaywatch.report.page import make_report
from swaywatch.report.sentences import critical_words, plus_minus, sentences, verdict
from swaywatch.terminal import output
from swaywatch.terminal.progress import LateProgress

HAS_JSON = True


def add_parser(subparsers: Any) -> None:
    """Add the ``analyze`` command."""
    parser = subparsers.add_parser(
        "analyze",
        help="analyse recordings: stability margin, alarms, report",
        description="Analyse recordings (.blf .asc .log .trc .mf4 .csv .parquet .mat .mcap .db3). "
        "Files that overlap in time with the same signals are separate drives, others are joined.",
    )
    add_files(parser, recording="files of any supported format")
    parser.add_argument(
        "--out", type=Path, default=Path("swaywatch-report"), metavar="DIR",
        help="folder for report.html, summary.json and the estimates (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--estimates", choices=("parquet", "mf4", "csv"), default="parquet",
        help="format of the estimates (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--merge", type=Path, metavar="FILE",
        help="also write measured and estimated channels on one clock, for asammdf, PlotJuggler, "
        "Foxglove or MATLAB: .mf4, .mcap, .mat, .parquet or .csv",
    )  # fmt: skip
    parser.add_argument(
        "--window", type=_window, metavar="OSCILLATIONS",
        help=f"length of the window, {WINDOW[0]:g} to {WINDOW[1]:g} oscillations (default: "
        f"{USUAL_WINDOW:g}; the reference dissertation: 2). In an undisturbed swing a window of "
        "twice the length has about a third of the error; it responds half a window later and "
        "is affected more by changes within it",
    )  # fmt: skip
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--one-drive", action="store_true", help="all files are one drive")
    group.add_argument("--separate", action="store_true", help="each file is a drive of its own")
    parser.add_argument(
        "--ignore-quality", action="store_true",
        help="analyse even if a sign, a unit or a clock is wrong",
    )  # fmt: skip
    parser.add_argument(
        "--accept-losses", action="store_true",
        help="exit code 0 even if the logger reports lost frames",
    )  # fmt: skip
    parser.add_argument("--no-report", action="store_true", help="no HTML report")


def _window(text: str) -> float:
    """A window that the core takes."""
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not WINDOW[0] <= value <= WINDOW[1]:
        raise argparse.ArgumentTypeError(
            f"{text!r}: expected {WINDOW[0]:g} to {WINDOW[1]:g} oscillations"
        )
    return value


def run(args: argparse.Namespace) -> int:
    """Analyse, write the files, print the summary."""
    console = Console(highlight=False)
    join = True if args.one_drive else False if args.separate else None
    with LateProgress() as progress:
        results = analyze(
            args.recording,
            args.vehicle,
            args.signals,
            join=join,
            strict=not args.ignore_quality,
            window=args.window,
            progress=progress.tell,
        )
        for result in results:
            result.sentences[:] = [verdict(result)[1], *sentences(result)]
        progress.tell("writing the report", 0.0, 1.0)
        written = write_outputs(
            results, args.out, args.estimates, report=not args.no_report, signals=args.signals
        )
        if args.merge:
            written += write_merged(args.merge, _unique_names(results), results)
    for result in results:
        print_summary(console, result)
    lost = sum(result.drive.lost_frames for result in results)
    output.result(args, json_of(results))
    for path in written:
        console.print(str(path), style="bold" if path.suffix == ".html" else "", soft_wrap=True)
    if lost and not args.accept_losses:
        print(
            f"swaywatch analyze: the logger lost {lost} frames, so the results cover only part of "
            "the drive (exit code 3; --accept-losses makes it 0)",
            file=sys.stderr,
        )
        return 3
    return 0


def write_outputs(
    results: list[DriveResult],
    folder: Path,
    estimates_format: str,
    *,
    report: bool,
    signals: Path | None = None,
) -> list[Path]:
    """Write estimates, JSON and report; each whole or not at all."""
    written = []
    names = _unique_names(results)
    for name, result in zip(names, results, strict=True):
        if not len(result.estimates):
            continue
        path = folder / f"estimates_{name}.{estimates_format}"
        time_ns = result.drive.start_ns + np.rint(result.estimates.time_s * 1e9).astype(np.int64)
        keep = np.concatenate([[True], np.diff(time_ns) > 0])
        series = {
            column: Series(time_ns[keep], value[keep], unit_of(column))
            for column, value in result.estimates.columns.items()
        }
        write_recording(path, series)
        written.append(path)
    path = folder / "summary.json"
    with whole_file(path) as temporary:
        text = json.dumps(json_of(results), indent=1, allow_nan=False)
        temporary.write_text(text, encoding="utf-8")
    written.append(path)
    if report:
        path = folder / "report.html"
        with whole_file(path) as temporary:
            temporary.write_text(make_report(results, signals), encoding="utf-8")
        written.append(path)
    return written


def json_of(results: list[DriveResult]) -> dict[str, Any]:
    """Content of ``summary.json``."""
    return {"swaywatch": __version__, "drives": [as_json(result) for result in results]}


def _unique_names(results: list[DriveResult]) -> list[str]:
    names: list[str] = []
    for result in results:
        name = result.drive.name
        names.append(name if name not in names else f"{name}_{len(names) + 1}")
    return names


def print_summary(console: Console, result: DriveResult) -> None:
    """Verdict, reasons and key figures on the terminal."""
    colour = {"good": "green", "near": "yellow", "bad": "red", "unknown": "cyan"}
    kind, sentence = verdict(result)
    console.rule(f"{result.drive.name}  ({result.drive.duration_s:.1f} s)", align="left")
    console.print(sentence, style=f"bold {colour[kind]}", markup=False)
    for text in result.sentences[1:]:
        console.print(f"- {text}", markup=False)
    table = Table(box=None, pad_edge=False, show_header=True)
    for heading in ("", "measured", "vehicle.toml", "unit"):
        table.add_column(heading, justify="left" if heading in ("", "unit") else "right")
    for row in _rows(result):
        table.add_row(*row)
    if table.row_count:
        console.print(table)
    for finding in result.findings:
        if finding.severity != "info":
            style = "red" if finding.severity == "error" else "yellow"
            console.print(f"{finding.severity}: {finding.text}", style=style, markup=False)
    for kind, entries in (("switched off", result.switched_off), ("indirect", result.indirect)):
        for name, channels in entries:
            lacking = _short(channels)
            console.print(f"{kind}: {name} (no {lacking})", style="dim", markup=False)


def _short(channels: tuple[str, ...]) -> str:
    """Channel names with the wheels of a role taken together."""
    wheels = ("_fl", "_fr", "_rl", "_rr")
    return ", ".join(
        dict.fromkeys(name[:-3] if name.endswith(wheels) else name for name in channels)
    )


def _rows(result: DriveResult) -> list[tuple[str, str, str, str]]:
    rows = []
    if result.critical_kind != "none":
        rows.append(("critical speed", critical_words(result), "", "km/h"))
    for key, label, factor, digits, unit in (
        ("frequency_hz", "sway frequency", 1.0, 4, "Hz"),
        ("damping_ratio", "damping ratio, free", 1.0, 4, "-"),
    ):
        if key in result.values:
            rows.append((label, plus_minus(result.values[key], factor, digits), "", unit))
    for axle in AXLES:
        value = result.values.get(f"{axle}.cornering_stiffness_n_per_rad")
        body, _, which = axle.partition("_")
        believed = getattr(getattr(result.vehicle, body), f"{which}_cornering_stiffness", None)
        if value is not None:
            shown = "" if believed is None else f"{believed * 1e-3:.1f}"
            rows.append(
                (f"stiffness, {AXLE_NAMES[axle]}", plus_minus(value, 1e-3), shown, "kN/rad")
            )
    return rows
