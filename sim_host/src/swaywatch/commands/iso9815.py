"""``swaywatch iso9815``: damping against speed over several runs, zero-damping speed."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
from rich.console import Console
from rich.table import Table

from swaywatch import __version__, output
from swaywatch.analysis import DriveResult, analyze
from swaywatch.iso9815 import Evaluation, Speed, evaluate
from swaywatch.progress import LateProgress
from swaywatch.recording.guard import whole_file
from swaywatch.report.shell import document, plot, table

HAS_JSON = True
KMH = 3.6
_COLOURS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#6b7280")


def add_parser(subparsers: Any) -> None:
    """Add the ``iso9815`` command."""
    parser = subparsers.add_parser(
        "iso9815",
        help="damping against speed over several runs; zero-damping speed",
        description="Evaluate the free oscillations of several runs after ISO 9815: damping "
        "ratio against speed, straight line (Eq. 3.43 of the reference), zero-damping speed and "
        "the speed of damping ratio 0.05, with 95 % confidence intervals.",
    )
    parser.add_argument("run_files", type=Path, nargs="+", metavar="RUN")
    parser.add_argument("--vehicle", type=Path, required=True, metavar="TOML")
    parser.add_argument("--signals", type=Path, required=True, metavar="TOML")
    parser.add_argument(
        "--out", type=Path, default=Path("swaywatch-iso9815"), metavar="DIR",
        help="folder for iso9815.html and iso9815.json (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--ignore-quality", action="store_true",
        help="evaluate even if a sign, a unit or a clock is wrong",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Evaluate, write the files, print the summary."""
    console = Console(highlight=False)
    with LateProgress() as progress:
        results = analyze(
            args.run_files, args.vehicle, args.signals,
            join=False, strict=not args.ignore_quality, progress=progress.tell,
        )  # fmt: skip
    evaluation = evaluate(results)
    sources = {
        "recording": args.run_files, "vehicle": [args.vehicle], "signals": [args.signals]
    }  # fmt: skip
    written = []
    for name, text in (
        ("iso9815.json", json.dumps(as_json(evaluation, results), indent=1, allow_nan=False)),
        ("iso9815.html", make_page(evaluation, results, sources)),
    ):
        path = args.out / name
        with whole_file(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
        written.append(path)
    output.result(args, as_json(evaluation, results))
    console.print(_table(evaluation))
    console.print(
        f"ratio = {evaluation.c0:.4f} {evaluation.c1 / KMH:+.6f} per km/h, "
        f"{len(evaluation.points)} windows of free oscillation"
    )
    for path in written:
        console.print(str(path), soft_wrap=True)
    return 0


def _kmh(speed: Speed) -> tuple[str, str]:
    """Value and interval in km/h."""
    value = "none" if speed.value_m_s is None else f"{speed.value_m_s * KMH:.1f}"
    if speed.low_m_s is None or speed.high_m_s is None:
        return value, "not bounded"
    return value, f"{speed.low_m_s * KMH:.1f} to {speed.high_m_s * KMH:.1f}"


def _table(evaluation: Evaluation) -> Table:
    table = Table(box=None, pad_edge=False)
    table.add_column("")
    table.add_column("km/h", justify="right")
    table.add_column("95 % interval", justify="right")
    table.add_column("")
    for name, speed in (
        ("zero-damping speed", evaluation.zero),
        (f"speed of damping ratio {evaluation.limit.damping_ratio:g}", evaluation.limit),
    ):
        value, interval = _kmh(speed)
        note = "outside the speeds that were driven" if speed.extrapolated else ""
        table.add_row(name, value, interval, note)
    return table


def as_json(evaluation: Evaluation, results: list[DriveResult]) -> dict[str, Any]:
    """Everything, SI units."""
    return {
        "swaywatch": __version__,
        "runs": [str(path) for result in results for path in result.drive.files],
        "regression": {
            "equation": "damping_ratio = c0 + c1 * speed_m_s",
            "c0": evaluation.c0,
            "c1_s_per_m": evaluation.c1,
            "covariance": evaluation.covariance.tolist(),
            "disturbance_rad_s": evaluation.disturbance_rad_s,
        },
        "zero_damping_speed": asdict(evaluation.zero),
        "limit_damping_speed": asdict(evaluation.limit),
        "points": [asdict(point) for point in evaluation.points],
    }


def make_figure(evaluation: Evaluation) -> go.Figure:
    """Points of each run with their errors, the line and its 95 % band."""
    figure = go.Figure()
    speeds = np.array([p.speed_m_s for p in evaluation.points])
    ends = [speeds.min(), speeds.max()]
    for crossing in (evaluation.zero, evaluation.limit):
        if crossing.value_m_s is not None and crossing.value_m_s < 2 * ends[1]:
            ends += [crossing.value_m_s]
    axis = np.linspace(min(ends) - 1.5, max(ends) + 1.5, 200)
    line, half = evaluation.ratio(axis)
    figure.add_trace(
        go.Scatter(
            x=np.concatenate([axis, axis[::-1]]) * KMH,
            y=np.concatenate([line + half, (line - half)[::-1]]),
            fill="toself", fillcolor="rgba(107,114,128,0.2)", line={"width": 0},
            name="95 % band of the line", hoverinfo="skip",
        )
    )  # fmt: skip
    figure.add_trace(
        go.Scatter(x=axis * KMH, y=line, mode="lines", line={"color": "#1f2937"}, name="line")
    )
    names = list(dict.fromkeys(point.run for point in evaluation.points))
    for index, name in enumerate(names):
        chosen = [point for point in evaluation.points if point.run == name]
        error = [
            float(np.hypot(p.standard_error, evaluation.disturbance_rad_s / p.amplitude_rad_s))
            for p in chosen
        ]
        figure.add_trace(
            go.Scatter(
                x=[p.speed_m_s * KMH for p in chosen],
                y=[p.damping_ratio for p in chosen],
                error_y={"array": error, "thickness": 1},
                mode="markers",
                marker={"color": _COLOURS[index % len(_COLOURS)], "size": 7},
                name=name,
            )
        )
    figure.add_hline(y=0.0, line={"color": "#D55E00", "width": 1})
    figure.add_hline(
        y=evaluation.limit.damping_ratio, line={"color": "#E69F00", "width": 1, "dash": "dash"}
    )
    figure.update_layout(
        height=560,
        xaxis_title="speed [km/h]", yaxis_title="damping ratio of the free oscillation [-]",
        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom"},
    )  # fmt: skip
    return figure


def make_page(
    evaluation: Evaluation,
    results: list[DriveResult],
    sources: Mapping[str, Sequence[Path]] | None = None,
) -> str:
    """One HTML file that needs nothing else."""
    runs = ", ".join(path.name for r in results for path in r.drive.files)
    rows = []
    for name, speed in (
        ("zero-damping speed", evaluation.zero),
        (f"speed of damping ratio {evaluation.limit.damping_ratio:g}", evaluation.limit),
    ):
        note = "outside the speeds that were driven" if speed.extrapolated else ""
        rows.append([name, *_kmh(speed), note])
    parts = [
        table(["", "km/h", "95 % interval", ""], rows),
        plot(make_figure(evaluation), name="damping_against_speed"),
        "<p class='note'>Each point is one window of free oscillation that overlaps no other; bars "
        "are one standard error, from the fit and from what disturbs the swing (an amplitude of "
        f"{np.degrees(evaluation.disturbance_rad_s):.2f} deg/s, found from the scatter). Line: "
        f"ratio = {evaluation.c0:.4f} {evaluation.c1 / KMH:+.6f} per km/h, weighted; intervals of "
        "the speeds after Fieller.</p>",
    ]
    return document("Damping against speed (ISO 9815)", parts, meta=runs, sources=sources)
