"""The report of a diagnosis of a car alone: one self-contained HTML page."""

from __future__ import annotations

from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from swaywatch.diagnose.car_alone.effects import ACC, YAW
from swaywatch.diagnose.car_alone.fit import START_S, CarFitter, CarModel
from swaywatch.diagnose.report.labels import named
from swaywatch.diagnose.report.page import (
    AFTER,
    BEFORE,
    MEASURED,
    WIDTHS,
    amounts,
    effect_rows,
    headline,
    packed,
    sources,
)
from swaywatch.effects.runs import RATE_HZ, low_pass
from swaywatch.report.shell import document

LABELS = {YAW: "yaw rate, deg/s", ACC: "lateral acceleration, m/s²"}
FACTORS = {YAW: float(np.degrees(1.0)), ACC: 1.0}


def before_after(
    fitter: CarFitter, baseline: CarModel, model: CarModel, run: int
) -> go.Figure | None:
    """Measured channels of a run with both models, its parts one after another."""
    data = fitter.data
    parts = [p for p in data.parts if p.run == run]
    if not parts:
        return None
    figure = make_subplots(
        len(data.channels), 1, shared_xaxes=True, vertical_spacing=0.06,
    )  # fmt: skip
    for row, channel in enumerate(data.channels, start=1):
        figure.update_yaxes(title_text=LABELS[channel].replace(", ", "<br>[") + "]", row=row, col=1)
        for number, part in enumerate(parts):
            measured = data.runs[run].channels[channel][part.where]
            time = data.runs[run].time[part.where]
            lines = [("measured", measured, MEASURED)]
            for label, used, colour in (
                ("single-track model alone", baseline, BEFORE),
                ("with the findings", model, AFTER),
            ):
                values = fitter.outputs(used, part)[channel]
                lines.append((label, values + float(np.mean(measured - values)), colour))
            for label, values, colour in lines:
                figure.add_scatter(
                    x=time[::2], y=FACTORS[channel] * values[::2], name=label, row=row, col=1,
                    line={"color": colour, "width": WIDTHS[colour]}, legendgroup=label,
                    showlegend=row == 1 and number == 0,
                )  # fmt: skip
    figure.update_layout(title=data.runs[run].name, height=260 * len(data.channels))
    figure.update_xaxes(title_text="time, s", row=len(data.channels), col=1)
    return figure


def turns(fitter: CarFitter, model: CarModel) -> go.Figure | None:
    """Acceleration against speed times yaw rate plus the model's side-slip rate."""
    data = fitter.data
    if not all(c in data.channels for c in (YAW, ACC)):
        return None
    figure = go.Figure()
    widest = 0.0
    for number, run in enumerate(data.runs):
        xs, ys = [], []
        for part in (p for p in data.parts if p.run == number):
            outputs = fitter.outputs(model, part)
            rate = np.gradient(outputs["lateral_velocity"]) * RATE_HZ
            true = run.channels["speed"][part.where] * run.channels[YAW][part.where] + rate
            settled = slice(int(START_S * RATE_HZ), None, 10)
            xs.append(low_pass(true, 1.5)[settled])
            ys.append(low_pass(run.channels[ACC][part.where], 1.5)[settled])
        if xs:
            x, y = np.concatenate(xs), np.concatenate(ys)
            widest = max(widest, float(np.max(np.abs(x))))
            figure.add_scatter(x=x, y=y, mode="markers", name=run.name, marker={"size": 4})
    figure.add_scatter(
        x=[-widest, widest], y=[-widest, widest], mode="lines", name="1 : 1",
        line={"color": "#000", "dash": "dash", "width": 1},
    )  # fmt: skip
    figure.update_layout(
        title="Lateral acceleration: measured against model",
        xaxis_title="speed × yaw rate + dv<sub>y</sub>/dt of the model, m/s²",
        yaxis_title="measured, m/s²", height=460,
    )  # fmt: skip
    return figure


def _dropped(text: str) -> str:
    name, _, reason = text.partition(": ")
    return f"{named(name)}: {reason}"


def _quantities(result: dict[str, Any]) -> list[list[str]]:
    return [
        [
            name.replace("_deg_per_m_s2", ", deg per m/s²").replace("_", " "),
            f"{q['value']:.3g}",
            f"{q['low']:.3g} to {q['high']:.3g}",
            q["how"],
        ]
        for name, q in result["quantities"].items()
    ]


def _relations(result: dict[str, Any]) -> list[list[str]]:
    rows = []
    for entry in result["relations"]:
        runs = "; ".join(f"{name}: {value:.3g}" for name, value in entry["per_run"].items())
        rows.append(
            [
                entry["name"], f"{entry['value']:.3f} {entry['unit'].strip('-')}", runs,
                f"{entry['residual']:.0%}", entry["meaning"],
            ]
        )  # fmt: skip
    return rows


def _fits(result: dict[str, Any], fitter: CarFitter, *models: CarModel) -> list[list[str]]:
    scores = [fitter.nrmse(m, fitter.data.parts) for m in models]
    rows = [
        [f"NRMSE, {LABELS.get(c, c).split(',')[0]}", *(f"{s[c]:.3f}" for s in scores)]
        for c in fitter.data.channels
    ]
    left_out = result["evidence"]["held_out_nrmse"]
    rows.append(["NRMSE, parts left out of the fit, all channels", *(f"{v:.3f}" for v in left_out)])
    return rows


def car_page(result: dict[str, Any], fitter: CarFitter, baseline: CarModel, model: CarModel) -> str:
    """HTML of the page."""
    evidence = result["evidence"]
    cloud = turns(fitter, model)
    drawn = [
        (run.name, before_after(fitter, baseline, model, number))
        for number, run in enumerate(fitter.data.runs)
    ]
    return document(
        "diagnose/car_alone/page.html",
        "Diagnosis of a car",
        sources=sources(result),
        verdict=headline(result),
        evidence=evidence,
        relations=_relations(result),
        cloud=None if cloud is None else packed(cloud, name="acceleration_against_turning"),
        effects=effect_rows(result),
        laws=[],
        alone=[(named(x["name"]), f"{x['level']:.2f}") for x in evidence["ranking"]],
        dropped=[_dropped(text) for text in evidence["dropped"]],
        quantities=_quantities(result),
        amounts=amounts(result),
        fits=_fits(result, fitter, baseline, model),
        signals=[packed(figure, name, "signals") for name, figure in drawn if figure is not None],
        unexplained=[note["reason"] for note in result["unexplained"]],
        checks=result["checks"],
    )
