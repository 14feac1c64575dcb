"""The part of the diagnosis page about a law outside the library."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import plotly.graph_objects as go

from swaywatch.report.shell import PackedPlot, plot

ESTIMATE, LAW = "#9ca3af", "#2563eb"
NINETY = 1.645
#: Places of `law.PLACES` as short as a diagram needs them.
PLACES = {
    "hitch": "yaw moment at the hitch",
    "ball": "place of the ball across its coupling",
    "force_car": "side force on the car",
    "force_trailer": "side force on the trailer",
    "at_car": "side force at a place of the car",
    "at_trailer": "side force at a place of the trailer",
    "moment_car": "yaw moment on the car",
    "moment_trailer": "yaw moment on the trailer",
    "drag_trailer": "yaw moment on the trailer",
    "slip_car_front": "steering angle of the front axle",
    "slip_car_rear": "steering angle of the car's rear axle",
    "slip_trailer": "steering angle of the trailer's axles",
    "axles": "steering angle of every axle",
}


def lines(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Lines of the box with the verdict, each with its remark."""
    found = []
    for law in result.get("discovered", []):
        hint = f" ({law['perhaps']}?)" if law["perhaps"] else ""
        text = f"{law['text'][:1].upper() + law['text'][1:]}{hint}"
        found.append((text, "a law outside the library, identified from these runs"))
    return found


def section(result: Mapping[str, Any]) -> list[dict[str, Any]]:
    """What was found outside the library, its evidence, and the missing force itself."""
    return [
        {"words": _words(law), "law": law["law"], "numbers": _numbers(law), "plots": _plots(law)}
        for law in result.get("discovered", [])
    ]


def _plots(law: Mapping[str, Any]) -> list[PackedPlot]:
    runs = law["input"]["runs"]
    plots = [plot(_course(law["input"], run), run=run["run"], name="missing_input") for run in runs]
    if runs[0]["motion"] is not None:
        plots.append(plot(_curve(law), name="law"))
    return plots


def _words(law: Mapping[str, Any]) -> str:
    each = (name.replace("_", " ").partition(":") for name in law["library_would_say"])
    named = (f"{effect} ({place})" if place else effect for effect, _, place in each)
    best = " + ".join(named) or "no effect"
    text = (
        f"{law['text'][:1].upper()}{law['text'][1:]}. It {law['energy']}. "
        f"Compared with the best explanation from the library, {best}, the "
        f"logarithm of the Bayes factor is {law['log_bayes_factor_to_library']:.0f}; "
        f"{100.0 * law['share_explained']:.0f} % of the mismatch beyond noise is explained."
    )
    if law["perhaps"]:
        text += f" Possible cause: {law['perhaps']}."
    kept = law["kept_out"]
    if kept:
        times = " and ".join(f"{x:.0f}" for x in kept["log_times_likelier_than_library"])
        text += (
            " Given the other runs, the logarithm of how many times likelier a run is with the law "
            f"than with the library is {times}. When each run is simulated with what the others "
            "taught, the error is "
            f"{100.0 * kept['calibrated_nrmse']:.1f} % (NRMSE) with the calibrated vehicle, "
            f"{100.0 * kept['library_nrmse']:.1f} % with the library and "
            f"{100.0 * kept['with_law_nrmse']:.1f} % with the law."
        )
    else:
        text += " With only one run the law could not be tested on another one."
    for other in law["equivalent"]:
        text += f" A law at {other['place']} in {other['depends_on']} fits equally well."
    return text.replace("_", " ")


def _numbers(law: Mapping[str, Any]) -> list[list[str]]:
    return [
        [
            _without_unit(name, row["unit"]),
            f"{row['value']:.4g} {row['unit']}".removesuffix(" 1"),
            f"{row['low']:.4g} to {row['high']:.4g}",
        ]
        for name, row in law["parameters"].items()
    ]


def _without_unit(name: str, unit: str) -> str:
    """The name of a number in words; its unit stands beside the value."""
    suffix = unit.lower().replace(" ", "").replace("1/", "per_").replace("/", "_")
    return name.removesuffix(f"_{suffix}").replace("_", " ")


def _at(found: Mapping[str, Any]) -> str:
    """The place of a missing force, for a diagram."""
    return PLACES[str(found["place"])]


def _course(found: Mapping[str, Any], run: Mapping[str, Any]) -> go.Figure:
    """The missing force against time, as estimated from the runs and according to the law."""
    figure = go.Figure(
        go.Scatter(
            x=run["time_s"], y=run["value"], mode="markers", name="estimated from the run",
            marker={"color": ESTIMATE, "size": 5},
            error_y={
                "array": [NINETY * e for e in run["standard_error"]], "color": ESTIMATE,
                "thickness": 0.7, "width": 0,
            },
        )
    )  # fmt: skip
    if run["law"] is not None:
        figure.add_scatter(x=run["time_s"], y=run["law"], name="law", line={"color": LAW})
    figure.update_layout(
        title=f"{run['run']}: missing {_at(found)}",
        xaxis_title="time, s", yaxis_title=f"{_at(found)}, {found['unit']}",
    )  # fmt: skip
    return figure


def _curve(law: Mapping[str, Any]) -> go.Figure:
    """The missing force against its variable."""
    found = law["input"]
    figure = go.Figure()
    for run in found["runs"]:
        figure.add_scatter(
            x=run["motion"], y=run["value"], mode="markers", name=run["run"], marker={"size": 4}
        )
        pairs = sorted(zip(run["motion"], run["law"], strict=True))
        figure.add_scatter(
            x=[p[0] for p in pairs], y=[p[1] for p in pairs], mode="markers",
            name=f"law, {run['run']}", marker={"color": LAW, "size": 3},
        )  # fmt: skip
    figure.update_layout(
        title="the missing input against its variable",
        xaxis_title=f"{law['variables'][0]}, {found['motion_unit']}",
        yaxis_title=f"{_at(found)}, {found['unit']}",
    )
    return figure
