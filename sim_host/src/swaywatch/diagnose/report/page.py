"""The report of a diagnosis: one self-contained HTML page, in the order an engineer asks.

Where measurement and model disagree, what is missing, how large it is, what it does to stability,
how well the corrected simulation fits, and what is still unexplained.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray
from plotly.subplots import make_subplots

from swaywatch.diagnose.evidence.evidence import UNEXPLAINED_ABOVE
from swaywatch.diagnose.evidence.verdict import Verdict
from swaywatch.diagnose.fit.agreement import FIVE_PERCENT, errors
from swaywatch.diagnose.fit.fit import Problem, predict_run
from swaywatch.diagnose.report.costs_page import costs_part
from swaywatch.diagnose.report.labels import (
    VERDICTS,
    named,
    part,
    quantity,
    rounded,
    value,
    what_is_left,
    when,
)
from swaywatch.diagnose.report.residual_map import LINES, line_map, relations
from swaywatch.diagnose.report.sentences import sentence as sentence_of
from swaywatch.discover.page import lines as law_lines
from swaywatch.discover.page import section as law_section
from swaywatch.drive import Channel, Drive
from swaywatch.ecu.core import analyze_drive
from swaywatch.effects.runs import Run, low_pass
from swaywatch.report.shell import PackedPlot, document, plot
from swaywatch.vehicle import Vehicle

Array = NDArray[np.float64]

MEASURED, BEFORE, AFTER = "#9ca3af", "#d64545", "#2563eb"
WIDTHS = {MEASURED: 3.0, BEFORE: 1.2, AFTER: 1.2}  # the measured line shows behind the others
#: A balance of linear terms is this far off on clean recordings (noise, small-angle remainders).
CLEAN_PERCENT = 3.0
LARGEST_PERCENT = 25.0
SHORTEST_FRAME_S = 0.05
ALL_ALONG = 0.95  # of a run: a window that long is none
_SHOWN = {
    "car_yaw_rate": "yaw rate car, deg/s",
    "trailer_yaw_rate": "yaw rate trailer, deg/s",
    "car_lateral_acceleration": "lat. acc. car, m/s²",
    "hitch_lateral_force": "hitch lateral force, kN",
}
_FACTOR = {"car_yaw_rate": 57.2958, "trailer_yaw_rate": 57.2958, "hitch_lateral_force": 1e-3}
#: Estimate to its title and the bit by which the core vouches for it.
_ESTIMATES = {
    "frequency_hz": ("f, Hz", "line"),
    "damping_ratio": ("damping ratio", "line"),
    "car_front.cornering_stiffness_n_per_rad": ("C car front, kN/rad", "car_front"),
    "car_rear.cornering_stiffness_n_per_rad": ("C car rear, kN/rad", "car_rear"),
}
_AXLES = (("car front axle load, kN", ("fl", "fr")), ("car rear axle load, kN", ("rl", "rr")))


def packed(figure: go.Figure, run: str = "", name: str = "", least_width: int = 0) -> PackedPlot:
    """A figure in the page's look; those of a run are zoomed together."""
    figure.update_annotations(font_size=12)
    figure.update_layout(
        hovermode="x unified",
        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 1.0, "xanchor": "right"},
    )
    return plot(figure, run=run, name=f"{run}_{name}", least_width=least_width)


def headline(result: Mapping[str, Any]) -> dict[str, Any]:
    """The verdict for ``ui.verdict``: the sentence and one line for each effect."""
    kind, sentence = VERDICTS[result["verdict"]]
    lines: list[tuple[str, str]] = []
    for effect in result["effects"]:
        same = _names(effect["equivalent_details"], 3)
        remark = f"{effect['id']}, confidence {effect['confidence']:.0%}"
        remark += f"; cannot be distinguished from {same}" if same else ""
        lines.append((sentence_of(effect, result.get("stability")), remark))
    lines += law_lines(result)
    notes = [note["reason"] for note in result["unexplained"] if note.get("reason")]
    lines += [(str(note), "") for note in notes[:2]]
    return {"kind": kind, "sentence": sentence, "reasons": lines}


def _names(names: Sequence[str], most: int) -> str:
    """The first of them in words, and how many more there are."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(named(name) for name in names[:most]) + more


def effect_rows(result: Mapping[str, Any]) -> list[list[str]]:
    """Ranked explanations with times, confidence, equivalents."""
    rows = []
    for rank, effect in enumerate(result["effects"], start=1):
        windows = when(effect["window_details"])
        same = _names(effect["equivalent_details"], 9) or "–"
        if effect["distinguished_by"]:
            same += f" (decided by: {effect['distinguished_by']})"
        rows.append(
            [
                str(rank), effect["id"].replace("_", " "), part(effect["component"]),
                windows or "always",
                ", ".join(effect["lines"]), f"{effect['confidence']:.0%}", same,
                f"{effect['equation']} [{effect['source']}]",
            ]
        )  # fmt: skip
    return rows


def amounts(result: Mapping[str, Any]) -> list[list[str]]:
    """Every claimed number with unit and interval; of effects in windows, window by window."""
    rows = []
    for effect in result["effects"]:
        what = named(f"{effect['id']}:{effect['component']}")
        names = effect["parameters"]
        each = [d for d in effect["window_details"] if any(name in d for name in names)]
        for d in each:
            values = ", ".join(value(name, d[name]) for name in names if name in d)
            own = d.get("intervals", {})
            sizes = [name for name in names if name in own and not _follows(name)]
            ranges = ", ".join(_range(name, *own[name]) for name in sizes)
            rows.append([what, when([d]), values, ranges])
        if len(each) > 1:
            what, moment = "", "median of the windows"
        else:
            moment = "" if each else when(effect["window_details"]) or "always"
        if len(each) != 1:
            rows += [
                [what, moment, value(name, v["value"]), _interval(name, v)]
                for name, v in names.items()
                if not (each and _follows(name))
            ]  # fmt: skip
        else:
            rows[-1][-1] = ", ".join(_interval(name, v) for name, v in names.items())
    return rows


def _follows(name: str) -> bool:
    """Tell whether a value follows from the motion in its window, rather than being a size."""
    return name.startswith(("phase", "frequency"))


def _interval(name: str, parameter: Mapping[str, Any]) -> str:
    if parameter["low"] == parameter["high"]:
        return ""
    text = _range(name, parameter["low"], parameter["high"])
    return text + (", at the end of the range searched" if parameter.get("at_bound") else "")


def _range(name: str, low: float, high: float) -> str:
    unit = quantity(name)[1]
    text = f"{rounded(low)} to {rounded(high)}"
    return f"{text} {unit}" if unit else text


def where(problem: Problem, index: int, result: Mapping[str, Any]) -> go.Figure:
    """Map of relation over time for each line, mismatch in colour; claimed windows framed."""
    run = problem.runs[index]
    maps = [(r.name, *line_map(run, r)) for r in relations(run, problem.body)]
    names = [name for name, _, _ in maps]
    figure = make_subplots(
        1, len(LINES), shared_yaxes=True, horizontal_spacing=0.012,
        subplot_titles=[_LINE_WORDS[line] for line in LINES],
    )  # fmt: skip
    for column, _ in enumerate(LINES):
        figure.add_heatmap(
            z=np.array([values[:, column] for _, _, values in maps]),
            x=maps[0][1] if maps else np.zeros(0), y=names, zmin=0.0, zmax=LARGEST_PERCENT,
            colorscale="YlOrRd", showscale=column == len(LINES) - 1, row=1, col=column + 1,
            colorbar={"title": "% of the<br>largest<br>term", "thickness": 12},
            hovertemplate="%{y}<br>%{x:.1f} s: %{z:.1f} %<extra></extra>",
        )  # fmt: skip
    for start, stop in _claimed(result, run):
        for column in range(1, len(LINES) + 1):
            figure.add_vrect(
                x0=start, x1=stop, row=1, col=column, line={"color": "#10131a", "width": 1},
                fillcolor="rgba(0,0,0,0)",
            )  # fmt: skip
    figure.update_layout(
        title=f"{run.name}, {np.mean(run.speed) * 3.6:.0f} km/h: mismatch of each relation, from "
        "measured signals alone",
        height=150 + 30 * len(names), margin={"l": 170, "r": 20, "t": 80, "b": 50},
    )  # fmt: skip
    figure.update_yaxes(autorange="reversed")
    figure.update_xaxes(title_text="time, s")
    return figure


_LINE_WORDS = {
    "mean": "mean", "f": "f (yaw frequency)", "2f": "2 f", "3f": "3 f", "broadband": "broadband",
}  # fmt: skip


def _claimed(result: Mapping[str, Any], run: Run) -> list[tuple[float, float]]:
    return [
        (float(w["start"]), float(w["stop"]))
        for effect in result["effects"]
        for w in effect["window_details"]
        if w["run"] == run.name
        and SHORTEST_FRAME_S < w["stop"] - w["start"] < ALL_ALONG * run.time[-1]
    ]


def measured_before_after(verdict: Verdict, index: int) -> list[tuple[str, dict[str, Array], str]]:
    """Measured, before, after: channels by name."""
    problem, fit = verdict.problem, verdict.fit
    run = problem.runs[index]
    found: list[tuple[str, dict[str, Array], str]] = [("measured", run.channels, MEASURED)]
    first = "as written" if verdict.before is verdict.written else "calibrated"
    models = [(first, verdict.before, BEFORE)]
    if fit.terms or first == "as written":
        models.append(("with the findings" if fit.terms else "calibrated", fit, AFTER))
    for label, model, colour in models:
        outputs = predict_run(problem, index, model.terms, model.nuisance[index], model.shift)
        found.append((label, outputs, colour))
    return found


def before_after(run: Run, three: Sequence[tuple[str, dict[str, Array], str]]) -> go.Figure:
    """Measured signals with the simulation before and after, and below each the difference."""
    shown = [name for name in _SHOWN if name in run.channels]
    figure = make_subplots(
        2 * len(shown), 1, shared_xaxes=True, vertical_spacing=0.018,
        row_heights=[w for _ in shown for w in (0.66, 0.34)],
    )  # fmt: skip
    for row, name in enumerate(shown):
        factor = _FACTOR.get(name, 1.0)
        measured = run.channels[name] * factor
        for label, channels, colour in three:
            values = channels[name] * factor
            values = values - float(np.mean(values - measured))
            figure.add_scatter(
                x=run.time[::2], y=values[::2], name=label, row=2 * row + 1, col=1,
                line={"color": colour, "width": WIDTHS[colour]}, legendgroup=label,
                showlegend=row == 0,
            )  # fmt: skip
            if label != "measured":
                figure.add_scatter(
                    x=run.time[::2], y=low_pass(measured - values, 5.0)[::2], row=2 * row + 2,
                    col=1, line={"color": colour, "width": 1.0}, legendgroup=label,
                    showlegend=False, name=f"measured - {label}",
                )  # fmt: skip
        unit = _SHOWN[name].partition(", ")[2]
        figure.update_yaxes(title_text=_in_two_lines(_SHOWN[name]), row=2 * row + 1, col=1)
        figure.update_yaxes(title_text=f"error<br>[{unit}]", row=2 * row + 2, col=1)
    figure.update_yaxes(title_font_size=10)
    figure.update_layout(
        title=f"{run.name}: signals and, below each, measured minus simulated",
        height=70 + 190 * len(shown), margin={"l": 84, "r": 20, "t": 70, "b": 40},
    )  # fmt: skip
    figure.update_xaxes(title_text="time, s", row=2 * len(shown), col=1)
    return figure


def axle_loads(run: Run, three: Sequence[tuple[str, dict[str, Array], str]]) -> go.Figure | None:
    """Sum of the wheel loads of each axle of the car, measured, before, after."""
    names = [f"wheel_vertical_load_{w}" for w in ("fl", "fr", "rl", "rr")]
    if not all(name in run.channels for name in names):
        return None
    figure = make_subplots(2, 1, shared_xaxes=True, vertical_spacing=0.1)
    for row, (title, wheels) in enumerate(_AXLES, start=1):
        figure.update_yaxes(title_text=_in_two_lines(title), row=row, col=1)
        for label, channels, colour in three:
            total = sum(
                (channels[f"wheel_vertical_load_{w}"] for w in wheels), np.zeros(run.time.size)
            )
            figure.add_scatter(
                x=run.time[::2], y=low_pass(total, 4.0)[::2] * 1e-3, name=label, row=row, col=1,
                line={"color": colour, "width": WIDTHS[colour]}, legendgroup=label,
                showlegend=row == 1,
            )  # fmt: skip
    figure.update_layout(
        title=f"{run.name}: axle loads", height=380, margin={"l": 84, "r": 20, "t": 70, "b": 40}
    )
    figure.update_xaxes(title_text="time, s", row=2, col=1)
    return figure


def _as_drive(run: Run, channels: Mapping[str, Array]) -> Drive:
    """A simulated run as the estimator of the core takes it: with the run's steering and speed."""
    names = [name for name in run.channels if name in channels]
    values = {name: channels[name] for name in names}
    values |= {name: run.channels[name] for name in ("steering_wheel_angle", "speed")}
    found = {
        name: Channel(name, run.time, value, name, "", run.positions.get(name, 0.0))
        for name, value in values.items()
    }
    return Drive(run.name, (), found, 0)


def estimates(
    run: Run, vehicle: Vehicle, three: Sequence[tuple[str, dict[str, Array], str]]
) -> go.Figure:
    """f(t), damping and C(t) that the core estimates from the recording and both simulations."""
    figure = make_subplots(len(_ESTIMATES), 1, shared_xaxes=True, vertical_spacing=0.05)
    for row, (title, _) in enumerate(_ESTIMATES.values(), start=1):
        figure.update_yaxes(title_text=_in_two_lines(title), row=row, col=1)
    for label, channels, colour in three:
        found = analyze_drive(_as_drive(run, channels), vehicle)
        for row, (name, (_, bit)) in enumerate(_ESTIMATES.items(), start=1):
            value = found[name] * (1e-3 if "stiffness" in name else 1.0)
            value = np.where(found.has(bit), value, np.nan)
            figure.add_scatter(
                x=found.time_s, y=value, name=label, row=row, col=1, mode="lines+markers",
                line={"color": colour, "width": 1.2}, marker={"size": 3}, legendgroup=label,
                showlegend=row == 1,
            )  # fmt: skip
    for row in range(1, len(_ESTIMATES) + 1):
        figure.update_yaxes(range=_usual(figure, row), row=row, col=1)
    figure.update_layout(
        title=f"{run.name}: frequency, damping, stiffness from recording and simulation",
        height=640, margin={"l": 84, "r": 20, "t": 70, "b": 40},
    )  # fmt: skip
    figure.update_xaxes(title_text="time, s", row=len(_ESTIMATES), col=1)
    return figure


def _in_two_lines(title: str) -> str:
    """``load, kN`` as a title of an axis."""
    words, comma, unit = title.partition(", ")
    return f"{words}<br>[{unit}]" if comma else words


def _usual(figure: go.Figure, row: int) -> list[float] | None:
    """Range of nine tenths of the estimates, so that a few at a start do not hide the rest."""
    axis = "y" if row == 1 else f"y{row}"
    values = np.concatenate([np.asarray(t.y, float) for t in figure.data if t.yaxis == axis])
    values = values[np.isfinite(values)]
    if values.size < 10:
        return None
    low, high = np.quantile(values, [0.05, 0.95])
    return [float(low - 0.4 * (high - low)), float(high + 0.4 * (high - low))]


def _scores(result: Mapping[str, Any]) -> dict[str, Any] | None:
    """How well all runs are reproduced, before and after, and how runs were left out."""
    fit = next((effect["fit"] for effect in result["effects"] if effect["fit"]), None)
    if fit is None:
        return None
    rows = []
    for label, keys in (
        ("NRMSE, fitted runs", ("as_written_nrmse", "baseline_nrmse", "diagnosed_nrmse")),
        ("NRMSE, left-out runs", ("", "held_out_baseline_nrmse", "held_out_diagnosed_nrmse")),
        ("ISO/TS 18571, fitted runs",
         ("iso18571_as_written", "iso18571_before", "iso18571_after")),
        ("ISO/TS 18571, left-out runs",
         ("", "held_out_iso18571_before", "held_out_iso18571_after")),
    ):  # fmt: skip
        rows.append([label, *(_number(fit.get(key)) for key in keys)])
    return {"rows": rows, "held_out": fit["held_out_how"]}


def _five_percent(
    problem: Problem, threes: Sequence[Sequence[tuple[str, dict[str, Array], str]]]
) -> tuple[list[str], list[list[str]]]:
    """The reference's criterion: each signal within 5 %; head and rows."""
    rows = []
    scores = [
        [errors(problem, i, channels) for _, channels, _ in three[1:]]
        for i, three in enumerate(threes)
    ]
    for name in scores[0][0]:
        row = [name.replace("_", " ")]
        for run in scores:
            for score in run:
                value = score.get(name)
                mark = "" if value is None else (" ✓" if value <= FIVE_PERCENT else "")
                row.append("–" if value is None else f"{value:.1%}{mark}")
        rows.append(row)
    head = ["channel: RMS error / RMS of the signal"]
    for run_, three in zip(problem.runs, threes, strict=True):
        labels = [label for label, _, _ in three[1:]]
        head += [f"{run_.name}, {labels[0]}", *labels[1:]]
    return head, rows


def _best_forms(ranking: Sequence[dict[str, Any]]) -> dict[str, float]:
    """Evidence of each explanation in its best form, in the order of the ranking."""
    best: dict[str, float] = {}
    for entry in ranking:
        best.setdefault(entry["name"], entry["log_bayes_factor"])
    return best


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.3f}"


def page(result: Mapping[str, Any], verdict: Verdict, vehicle: Vehicle) -> str:
    """HTML of the page."""
    evidence = result["evidence"]
    problem = verdict.problem
    runs = range(len(problem.runs))
    threes = [measured_before_after(verdict, index) for index in runs]
    return document(
        "diagnose/report/page.html",
        "Diagnosis: where simulation and recording differ",
        sources=sources(result),
        verdict=headline(result),
        run_files=_runs(result, problem),
        evidence=evidence,
        above_clean=_above_clean(evidence),
        repaired=_repaired(result),
        calibrated=_calibrated(result),
        clean_percent=CLEAN_PERCENT,
        maps=[
            packed(where(problem, index, result), problem.runs[index].name, "relations", 900)
            for index in runs
        ],
        effects=effect_rows(result),
        best=[
            (" + ".join(named(n) for n in name.split(" + ")), f"{round(reached):+d}")
            for name, reached in _best_forms(evidence["ranking"]).items()
        ],
        laws=law_section(result),
        amounts=amounts(result),
        costs=costs_part(result),
        own=problem.free_start,
        by_calibration=bool(verdict.fit.terms) and verdict.before is verdict.written,
        stretched=verdict.stretched,
        claimed=bool(verdict.fit.terms),
        scores=_scores(result),
        five_percent=_five_percent(problem, threes),
        signals=[
            figure
            for index, three in zip(runs, threes, strict=True)
            for figure in _signals(problem.runs[index], vehicle, three)
        ],
        unexplained=rest_of_it(result["unexplained"], evidence),
        checks=[str(check) for check in result["checks"]],
    )


def _signals(
    run: Run, vehicle: Vehicle, three: Sequence[tuple[str, dict[str, Array], str]]
) -> list[PackedPlot]:
    """A run before and after."""
    loads = axle_loads(run, three)
    return [
        packed(before_after(run, three), run.name, "signals"),
        *([] if loads is None else [packed(loads, run.name, "axle_loads")]),
        packed(estimates(run, vehicle, three), run.name, "estimates"),
    ]


def rest_of_it(unexplained: Sequence[Mapping[str, Any]], evidence: Mapping[str, Any]) -> list[str]:
    """The mismatch that no explanation covers, a sentence each."""
    notes = [what_is_left(note) for note in unexplained]
    return notes or [_above_clean(evidence) or "Nothing above the noise."]


def _above_clean(evidence: Mapping[str, Any]) -> str:
    """Meaning of a mismatch above that of clean recordings, with the findings applied."""
    left = evidence["reduced_chi_square_diagnosed"]
    if left <= UNEXPLAINED_ABOVE:
        return ""
    return (
        f" {left:.2f} is above {UNEXPLAINED_ABOVE:.2f}: part of the mismatch is explained by no "
        "effect of the library, and it cannot be assigned to a single place."
    )


def _calibrated(result: Mapping[str, Any]) -> list[list[str]]:
    """Each value in vehicle.toml and calibrated by the recording, with its tolerance."""
    return [
        [
            row["name"], f"{row['believed']:.6g}", *_to_error(row), _unit_of(row["name"]),
            f"{row['tolerances']:+.1f}", row["source"],
        ]
        for row in result["calibrated"]
    ]  # fmt: skip


def _to_error(row: Mapping[str, Any]) -> tuple[str, str]:
    """A calibrated value with the digits that its standard error leaves, and that error."""
    value, error = row["calibrated"], row["standard_error"]
    if not 0.0 < error < np.inf:
        return f"{value:.6g}", "-"
    digits = max(0, 1 - int(np.floor(np.log10(error))))
    return f"{value:.{digits}f}", f"{error:.{digits}f}"


def _unit_of(name: str) -> str:
    """Unit of a value of vehicle.toml."""
    ends = (
        ("mass", "kg"), ("inertia", "kg\u00a0m²"), ("stiffness", "N/rad"), ("cog", "m"),
        ("axle", "m"),
    )  # fmt: skip
    return next((unit for end, unit in ends if name.endswith(end)), "-")


def sources(result: Mapping[str, Any]) -> dict[str, list[str]]:
    """The files that the diagnosis was made from, by what they are."""
    inputs = result["inputs"]
    return {
        "recording": list(inputs["recordings"]),
        "simulation": list(inputs.get("simulations") or []),
        "vehicle": [inputs["vehicle"]],
        "signals": [inputs["signals"]],
    }


def _runs(result: Mapping[str, Any], problem: Problem) -> str:
    """Which file is which run."""
    files = [Path(name).name for name in result["inputs"]["recordings"]]
    names = sorted(run.name for run in problem.runs)
    if len(files) != len(names):
        return ""
    words = [
        f"{name}: {files[int(name.split()[-1]) - 1]}"
        for name in names if int(name.split()[-1]) <= len(files)
    ]  # fmt: skip
    return ", ".join(words)


def _repaired(result: Mapping[str, Any]) -> bool:
    return any(effect.get("text") for effect in result["effects"])


def write_page(text: str, path: Path) -> None:
    """Write the complete file or none."""
    part = path.with_suffix(".part")
    part.write_text(text)
    part.replace(path)
