"""The report as one HTML file that needs nothing else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import plotly.graph_objects as go

from swaywatch.analysis import AXLE_NAMES, DriveResult, Value
from swaywatch.ecu.core import AXLES
from swaywatch.report import figures
from swaywatch.report.sentences import (
    REASON_WORDS,
    critical_words,
    plus_minus,
    sentences,
    speed_used_m_s,
    verdict,
)
from swaywatch.report.shell import PackedPlot, document, plot
from swaywatch.roles import CHANNELS

KMH = 3.6
MOST_ALARMS = 40
"""In the table of a drive."""


def make_report(results: list[DriveResult], signals: Path | None = None) -> str:
    """HTML of the report on one or several drives of one combination.

    Parameters
    ----------
    results
        At least one.
    signals
        The ``signals.toml`` they were read with, for the list of sources.
    """
    vehicle = results[0].vehicle.path
    return document(
        "report/page.html",
        "Stability margin of the combination",
        meta=", ".join(path.name for result in results for path in result.drive.files),
        sources={
            "recording": [path for result in results for path in result.drive.files],
            "vehicle": [] if vehicle is None else [vehicle],
            "signals": [] if signals is None else [signals],
        },
        verdicts=[verdict_box(result, several=len(results) > 1) for result in results],
        numbers=key_figures(results),
        margin=_packed(figures.margin_against_speed(results), "", "margin_against_speed"),
        drives=[_drive(result) for result in results],
        colours=figures.ALARM_COLOUR,
        window=results[0].window_oscillations,
    )


def verdict_box(result: DriveResult, *, several: bool = False) -> dict[str, Any]:
    """The conclusion of a drive for ``ui.verdict``, with its name where there are `several`."""
    kind, sentence = verdict(result)
    above = result.drive.name if several else ""
    return {"kind": kind, "sentence": sentence, "reasons": sentences(result), "above": above}


def key_figures(results: list[DriveResult]) -> dict[str, Any]:
    """The key figures of all drives side by side, for ``key_figures.html``."""
    rows: list[tuple[str, str, list[str]]] = [
        ("speed at the estimates", "km/h", [f"{speed_used_m_s(r) * KMH:.1f}" for r in results]),
        ("critical speed", "km/h", [critical_words(r) for r in results]),
        _row(results, "sway frequency", "Hz", "frequency_hz", 1.0, 4),
        _row(results, "damping ratio, measured in free oscillation", "–", "damping_ratio", 1.0, 4),
        _row(results, "damping ratio, model", "–", "model_damping_ratio", 1.0, 4),
    ]
    for axle in AXLES:
        key = f"{axle}.cornering_stiffness_n_per_rad"
        rows.append(
            _row(results, f"cornering stiffness, {AXLE_NAMES[axle]}", "kN/rad", key, 1e-3, 1)
        )
    rows.append(_row(results, "yaw inertia, car", "kg m²", "car_yaw_inertia_kgm2", 1.0, 0))
    rows.append(_row(results, "yaw inertia, trailer", "kg m²", "trailer_yaw_inertia_kgm2", 1.0, 0))
    return {
        "names": [result.drive.name for result in results],
        "rows": [(name, _believed(results[0], name), cells, unit) for name, unit, cells in rows],
    }


def _row(
    results: list[DriveResult], name: str, unit: str, key: str, factor: float, digits: int
) -> tuple[str, str, list[str]]:
    def cell(value: Value | None) -> str:
        return "–" if value is None else plus_minus(value, factor, digits)

    return name, unit, [cell(result.values.get(key)) for result in results]


def _believed(result: DriveResult, name: str) -> str:
    """What the vehicle.toml says of a row."""
    car, trailer = result.vehicle.car, result.vehicle.trailer
    known: dict[str, float | None] = {"yaw inertia, car": car.yaw_inertia}
    if trailer is not None:
        known["yaw inertia, trailer"] = trailer.yaw_inertia
    for axle in AXLES:
        body, _, which = axle.partition("_")
        value = getattr(getattr(result.vehicle, body), f"{which}_cornering_stiffness", None)
        known[f"cornering stiffness, {AXLE_NAMES[axle]}"] = value and value * 1e-3
    value = known.get(name)
    return "" if value is None else f"{value:.1f}" if value < 1000 else f"{value:.0f}"


def _drive(result: DriveResult) -> dict[str, Any]:
    """What the page shows of one drive."""
    name = result.drive.name
    drawn = {
        "margin": figures.margin(result),
        "oscillation": figures.oscillation(result),
        "time_frequency": figures.time_frequency(result),
        "stiffness": figures.stiffness(result),
        "loads": figures.loads(result),
        "signals": figures.signals(result),
    }
    loud = [alarm for alarm in result.alarms if alarm.state in ("notice", "warning", "critical")]
    return {
        "drive": result.drive,
        "estimates": len(result.estimates),
        "plots": {which: _packed(figure, name, which) for which, figure in drawn.items()},
        "alarms": [
            (alarm, [REASON_WORDS.get(reason, reason) for reason in alarm.reasons])
            for alarm in loud[:MOST_ALARMS]
        ],
        "more_alarms": len(loud) - MOST_ALARMS,
        "findings": result.findings,
        "balances": result.balances,
        "faults": [f"{n} {count}" for n, count in result.estimates.fault_count.items() if count],
        "switched_off": result.switched_off,
        "indirect": result.indirect,
        "channels": [
            (which, channel, f"{_rate(channel):.0f}", _position(channel))
            for which, channel in result.drive.channels.items()
        ],
    }


def _packed(figure: go.Figure | None, run: str, name: str) -> PackedPlot | None:
    """A plot; those of a `run` have one time axis."""
    return None if figure is None else plot(figure, run=run, name=f"{run}_{name}" if run else name)


def _rate(channel: Any) -> float:
    span = float(channel.time_s[-1] - channel.time_s[0])
    return (len(channel.time_s) - 1) / span if span > 0.0 else 0.0


def _position(channel: Any) -> str:
    return f"{channel.position_m:.3f}" if CHANNELS[channel.name].unit == "m/s2" else ""
