"""The report as one HTML file that needs nothing else."""

from __future__ import annotations

import html
from pathlib import Path
from typing import Any

import plotly.graph_objects as go

from swaywatch.analysis import AXLE_NAMES, DriveResult, Value
from swaywatch.ecu.core import AXLES, USUAL_WINDOW
from swaywatch.report import figures
from swaywatch.report.sentences import (
    REASON_WORDS,
    critical_words,
    plus_minus,
    sentences,
    speed_used_m_s,
    verdict,
)
from swaywatch.report.shell import document, plot, wide
from swaywatch.roles import CHANNELS

KMH = 3.6


def make_report(results: list[DriveResult], signals: Path | None = None) -> str:
    """HTML of the report on one or several drives of one combination.

    Parameters
    ----------
    results
        At least one.
    signals
        The ``signals.toml`` they were read with, for the list of sources.
    """
    parts = [verdict_box(result, several=len(results) > 1) for result in results]
    parts += ["<h2>In figures</h2>", key_figures(results)]
    parts.append("<h2>Margin against speed</h2>")
    parts.append(
        _figure(
            figures.margin_against_speed(results),
            "Below a damping ratio of 0 a disturbance grows instead of dying out; the speed where "
            "the curve crosses 0 is the critical speed. The curve takes the stiffnesses alone; the "
            "critical speed also takes how late the tyres' forces come (their argument). Points "
            "are measured in free oscillation, bars are one standard error, shaded bands two.",
            "no model and no measured damping to draw",
            name="margin_against_speed",
        )
    )
    for result in results:
        parts.append(_drive(result))
    parts.append(_conventions(results[0].window_oscillations if results else USUAL_WINDOW))
    vehicle = results[0].vehicle.path
    return document(
        "How far from instability, and why do we think so",
        parts,
        meta=_title(results),
        sources={
            "recording": [path for result in results for path in result.drive.files],
            "vehicle": [] if vehicle is None else [vehicle],
            "signals": [] if signals is None else [signals],
        },
    )


def _title(results: list[DriveResult]) -> str:
    return ", ".join(path.name for result in results for path in result.drive.files)


def verdict_box(result: DriveResult, *, several: bool = False) -> str:
    """The conclusion of a drive, with its name where there are `several`."""
    kind, sentence = verdict(result)
    lead = f"<div class='note'>{html.escape(result.drive.name)}</div>" if several else ""
    items = "".join(f"<li>{html.escape(text)}</li>" for text in sentences(result))
    return f"<div class='verdict {kind}'>{lead}<p>{html.escape(sentence)}</p><ul>{items}</ul></div>"


def key_figures(results: list[DriveResult]) -> str:
    """The key figures of all drives side by side."""
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
    head = "".join(f"<th>{html.escape(result.drive.name)}</th>" for result in results)
    body = "".join(
        f"<tr><td>{name}</td>{_believed(results[0], name)}"
        + "".join(f"<td class='number'>{cell}</td>" for cell in cells)
        + f"<td>{unit}</td></tr>"
        for name, unit, cells in rows
    )
    return (
        wide(f"<table><tr><th></th><th>vehicle.toml</th>{head}<th>unit</th></tr>{body}</table>")
        + "<div class='note'>Value ± standard error over the usable estimates of the drive.</div>"
    )


def _row(
    results: list[DriveResult], name: str, unit: str, key: str, factor: float, digits: int
) -> tuple[str, str, list[str]]:
    def cell(value: Value | None) -> str:
        return "–" if value is None else plus_minus(value, factor, digits)

    return name, unit, [cell(result.values.get(key)) for result in results]


def _believed(result: DriveResult, name: str) -> str:
    """Cell with what the vehicle.toml says of a row."""
    car, trailer = result.vehicle.car, result.vehicle.trailer
    known: dict[str, float | None] = {"yaw inertia, car": car.yaw_inertia}
    if trailer is not None:
        known["yaw inertia, trailer"] = trailer.yaw_inertia
    for axle in AXLES:
        body, _, which = axle.partition("_")
        value = getattr(getattr(result.vehicle, body), f"{which}_cornering_stiffness", None)
        known[f"cornering stiffness, {AXLE_NAMES[axle]}"] = value and value * 1e-3
    value = known.get(name)
    text = "" if value is None else f"{value:.1f}" if value < 1000 else f"{value:.0f}"
    return f"<td class='number'>{text}</td>"


def _drive(result: DriveResult) -> str:
    drive = result.drive
    parts = [
        f"<h2>{html.escape(drive.name)}</h2>",
        f"<div class='meta'>{drive.duration_s:.1f} s, {len(drive.channels)} channels, "
        f"{drive.frames} {'frames' if drive.formats else 'samples'}, "
        f"{html.escape(', '.join(drive.formats))}, {len(result.estimates)} estimates</div>",
        "<h3>Speed margin and alarm</h3>",
        _figure(figures.margin(result), _alarm_legend(), run=drive.name, name="margin"),
        _alarm_table(result),
        "<h3>Oscillation: frequency, amplitude, damping</h3>",
        _figure(
            figures.oscillation(result),
            "Of the trailer's yaw rate (the car's without a trailer). Bands are two standard "
            "errors. While the driver steers with the oscillation its growth says nothing about "
            "stability; those points are grey.",
            "no usable estimate of an oscillation",
            run=drive.name,
            name="oscillation",
        ),
        "<h3>Where in time and frequency the motion is</h3>",
        _figure(
            figures.time_frequency(result),
            "White dots: the line that is tracked.",
            run=drive.name,
            name="time_frequency",
        ),
        "<h3>Cornering stiffness of each axle</h3>",
        _figure(
            figures.stiffness(result),
            "Lateral force over slip angle at the sway frequency. A negative argument means that "
            "the force follows the slip late.",
            "no axle could be identified; see below which signals are missing",
            run=drive.name,
            name="stiffness",
        ),
        "<h3>Axle loads</h3>",
        _figure(
            figures.loads(result),
            "The effective load is the constant load that would give the same lateral force at "
            "the sway frequency: a load that oscillates at twice that frequency adds to it or "
            "takes from it, by its phase.",
            "no axle loads were measured",
            run=drive.name,
            name="loads",
        ),
        "<h3>Signals as measured</h3>",
        _figure(
            figures.signals(result),
            "Left and right wheels of an axle are added.",
            run=drive.name,
            name="signals",
        ),
        "<h3>Data quality</h3>",
        _findings(result),
        "<h3>Results switched off, or based on fewer signals</h3>",
        _switched_off(result),
        "<h3>Which signal plays which role</h3>",
        _channels(result),
    ]
    return "\n".join(parts)


def _figure(
    figure: go.Figure | None,
    note: str,
    instead: str = "nothing to show",
    *,
    run: str = "",
    name: str = "plot",
) -> str:
    """A plot and what it shows; those of a `run` have one time axis."""
    if figure is None:
        return f"<p class='note'>Not shown: {html.escape(instead)}.</p>"
    body = plot(figure, run=run, name=f"{run}_{name}" if run else name)
    return f"{body}<div class='note'>{note}</div>"


def _alarm_legend() -> str:
    return "Alarm: " + " ".join(_badge(state) for state in figures.ALARM_COLOUR)


def _badge(state: str) -> str:
    colour = figures.ALARM_COLOUR[state]
    return f"<span class='state state-{state}' style='background:{colour}'>{state}</span>"


def _alarm_table(result: DriveResult) -> str:
    loud = [alarm for alarm in result.alarms if alarm.state in ("notice", "warning", "critical")]
    if not loud:
        return "<p>No alarm was raised.</p>"
    rows = "".join(
        f"<tr><td class='number'>{alarm.start_s:.2f}</td><td class='number'>{alarm.end_s:.2f}</td>"
        f"<td>{_badge(alarm.state)}</td>"
        f"<td>{', '.join(REASON_WORDS.get(reason, reason) for reason in alarm.reasons)}</td></tr>"
        for alarm in loud[:40]
    )
    more = f"<p class='note'>and {len(loud) - 40} more</p>" if len(loud) > 40 else ""
    head = "<tr><th>from [s]</th><th>to [s]</th><th>state</th><th>reasons</th></tr>"
    return wide(f"<table>{head}{rows}</table>") + more


def _findings(result: DriveResult) -> str:
    faults = [f"{name} {count}" for name, count in result.estimates.fault_count.items() if count]
    note = f"<p class='note'>Fault counters of the core: {', '.join(faults) or 'all 0'}.</p>"
    note = _balances(result) + note
    if not result.findings:
        return "<p>No fault found: no gaps, nothing stuck or clipped.</p>" + note
    rows = "".join(
        f"<tr><td class='{f.severity}'>{f.severity}</td><td>{f.kind.replace('_', ' ')}</td>"
        f"<td>{html.escape(f.text)}</td></tr>"
        for f in result.findings
    )
    return wide(f"<table><tr><th></th><th>kind</th><th>finding</th></tr>{rows}</table>") + note


def _balances(result: DriveResult) -> str:
    """Which relations between the signals were checked, and how well they hold."""
    if not result.balances:
        return (
            "<p>Signs, units and delays could not be checked against each other: too few signals "
            "for a balance.</p>"
        )
    rows = "".join(
        f"<tr><td>{html.escape(name)}</td><td class='number'>{100 * rest:.0f} %</td></tr>"
        for name, rest in result.balances.items()
    )
    return (
        wide(
            "<table><tr><th>relation that signs, units and delays were checked by</th>"
            f"<th>residual, part of its largest term</th></tr>{rows}</table>"
        )
        + "<div class='note'>A few percent are noise; more is physics that the relation leaves out "
        "or a fault of a signal (band 0.15 to 3 Hz).</div>"
    )


def _switched_off(result: DriveResult) -> str:
    if not result.switched_off and not result.indirect:
        return "<p>None: every signal that a result needs is there.</p>"
    kinds = (
        ("switched off", result.switched_off),
        ("from the balances of the bodies, with the vehicle.toml's masses", result.indirect),
    )
    rows = "".join(
        f"<tr><td>{html.escape(name)}</td><td>{kind}</td>"
        f"<td>{html.escape(', '.join(channels))}</td></tr>"
        for kind, entries in kinds
        for name, channels in entries
    )
    return wide(f"<table><tr><th>result</th><th></th><th>for lack of</th></tr>{rows}</table>")


def _channels(result: DriveResult) -> str:
    rows = "".join(
        f"<tr><td>{name}</td><td>{html.escape(channel.signal)}</td>"
        f"<td>{html.escape(channel.unit_in_file)}</td><td class='number'>{_rate(channel):.0f}</td>"
        f"<td class='number'>{_position(channel)}</td>"
        f"<td>{html.escape(', '.join(channel.files))}</td></tr>"
        for name, channel in result.drive.channels.items()
    )
    return wide(
        "<table><tr><th>role</th><th>signal</th><th>unit in file</th><th>rate [Hz]</th>"
        f"<th>ahead of COG [m]</th><th>file</th></tr>{rows}</table>"
    )


def _rate(channel: Any) -> float:
    span = float(channel.time_s[-1] - channel.time_s[0])
    return (len(channel.time_s) - 1) / span if span > 0.0 else 0.0


def _position(channel: Any) -> str:
    return f"{channel.position_m:.3f}" if CHANNELS[channel.name].unit == "m/s2" else ""


def _conventions(window: float) -> str:
    return (
        "<h2>Conventions</h2><p class='note'>Axes are ISO 8855 (x forward, y left, z up; yaw, "
        "steering and lateral force positive left); articulation is trailer heading minus car "
        "heading; hitch forces are those of the trailer on the car. Estimates come from a sliding "
        f"window over {window:g} oscillations ({window / 0.67:.1f} s at 0.67 Hz); time is that of "
        "its middle. The dissertation takes 2 (<code>--window 2</code>): in an undisturbed swing a "
        "window of twice the length has about a third of the error, but it is half a window later, "
        "and what changes within it makes it err more. Errors are standard errors. "
        "Method: sliding spectrum, joint damped-line fit over all channels, axle slip and "
        "stiffness, single-track model (N. Zhang, TU Darmstadt 2015, chapters 3 and 4).</p>"
    )
