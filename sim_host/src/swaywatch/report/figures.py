"""The figures of the report, with plotly: units on every axis, colours for every eye."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import plotly.graph_objects as go
import scipy.signal
from plotly.subplots import make_subplots

from swaywatch.analysis import AXLE_NAMES, DriveResult, damping_gap, found_critical, usable
from swaywatch.drive import Channel
from swaywatch.ecu.core import AXLES, model_damping

FloatArray = npt.NDArray[np.float64]

KMH = 3.6
DEG = 180 / np.pi
COLOUR = {
    "car_front": "#0072B2", "car_rear": "#E69F00",
    "trailer_front": "#009E73", "trailer_rear": "#D55E00",
}  # fmt: skip
BLUE, ORANGE, GREEN, RED, PINK, GREY = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#6b7280"
)  # fmt: skip
ALARM_COLOUR = {
    "off": "#d1d5db", "normal": "#86c99a", "notice": "#f5d565", "warning": "#f19a3e",
    "critical": "#d64545",
}  # fmt: skip
MAX_POINTS = 3000
MAX_ESTIMATES = 1200


def _faint(colour: str, alpha: float = 0.18) -> str:
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return f"rgba({red},{green},{blue},{alpha})"


def thinned(time: FloatArray, value: FloatArray) -> tuple[FloatArray, FloatArray]:
    """At most MAX_POINTS points that keep the lowest and highest sample of every stretch."""
    if len(time) <= MAX_POINTS:
        return time, value
    length = -(-len(value) // (MAX_POINTS // 2))
    stretches = -(-len(value) // length)
    used = np.pad(value, (0, stretches * length - len(value)), mode="edge")
    used = used.reshape(stretches, length)
    first = np.arange(stretches) * length
    rows = np.sort(np.stack([first + used.argmin(1), first + used.argmax(1)]), axis=0).T.ravel()
    rows = np.minimum(rows, len(value) - 1)
    return time[rows], value[rows]


def _layout(figure: go.Figure, height: int, legend: bool = True) -> go.Figure:
    figure.update_layout(
        height=height,
        margin={"l": 92, "r": 24, "t": 34, "b": 52},
        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 0.0},
        showlegend=legend,
        hovermode="x unified",
    )
    figure.update_xaxes(showline=True, linecolor="#9ca3af", ticks="outside", zeroline=False)
    figure.update_yaxes(
        showline=True, linecolor="#9ca3af", ticks="outside", zeroline=False, automargin=False
    )
    return figure


def _over_time(figure: go.Figure, result: DriveResult) -> go.Figure:
    """The whole drive on the time axis, so that all figures line up."""
    figure.update_xaxes(range=[0.0, result.drive.duration_s])
    figure.update_layout({_last_axis(figure): {"title": {"text": "time [s]"}}})
    return figure


def _last_axis(figure: go.Figure) -> str:
    """Name of the lowest time axis."""
    names = [name for name in figure.layout.to_plotly_json() if name.startswith("xaxis")]
    return str(max(names, key=lambda name: int(name.removeprefix("xaxis") or 1)))


def _every(*columns: FloatArray) -> tuple[FloatArray, ...]:
    """At most MAX_ESTIMATES rows, evenly taken."""
    step = -(-len(columns[0]) // MAX_ESTIMATES)
    return tuple(column[::step] for column in columns)


def _thin_mask(mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """At most MAX_ESTIMATES of the marked rows, evenly taken."""
    rows = np.flatnonzero(mask)
    kept = np.zeros_like(mask)
    kept[rows[:: max(1, -(-len(rows) // MAX_ESTIMATES))]] = True
    return kept


def _band(
    figure: go.Figure,
    time: FloatArray,
    value: FloatArray,
    error: FloatArray,
    colour: str,
    name: str,
    row: int | None = None,
) -> None:
    """A line with its band of two standard errors; not joined over gaps."""
    if not len(time):
        return
    step = 3.0 * float(np.median(np.diff(time))) if len(time) > 2 else 1.0
    part = np.concatenate([[0], np.cumsum(np.diff(time) > step)])
    t, y, e, p = _every(time, value, 2.0 * error, part)
    line_x, line_y, band_x, band_y = [], [], [], []
    gap = np.array([np.nan])
    for number in np.unique(p):
        here = p == number
        line_x += [t[here], gap]
        line_y += [y[here], gap]
        band_x += [t[here], t[here][::-1], gap]
        band_y += [(y + e)[here], (y - e)[here][::-1], gap]
    place: dict[str, Any] = {"row": row, "col": 1} if row else {}
    figure.add_trace(
        go.Scatter(
            x=np.concatenate(band_x), y=np.concatenate(band_y), mode="lines", fill="toself",
            fillcolor=_faint(colour), line={"width": 0}, hoverinfo="skip", showlegend=False,
            legendgroup=name,
        ),
        **place,
    )  # fmt: skip
    figure.add_trace(
        go.Scatter(
            x=np.concatenate(line_x), y=np.concatenate(line_y), mode="lines+markers",
            line={"color": colour, "width": 2}, marker={"size": 2.5}, name=name, legendgroup=name,
        ),
        **place,
    )  # fmt: skip


def _inner_range(value: FloatArray, error: FloatArray, spread: float = 0.1) -> list[float]:
    """Axis range that a few wild estimates cannot blow up."""
    good = np.isfinite(value)
    if not good.any():
        return [-1.0, 1.0]
    low, high = np.percentile(value[good], [2, 98])
    wide = 2.5 * float(np.median(error)) if len(error) else 0.0
    margin = max(spread * (high - low), wide, 0.02 * abs(float(np.median(value[good]))), 1e-9)
    return [float(low - margin), float(high + margin)]


# --- what was measured ----------------------------------------------------------------------------

_PANELS: tuple[tuple[str, float, tuple[tuple[str, str, str], ...]], ...] = (
    ("steering<br>wheel angle [°]", DEG, (("steering_wheel_angle", "steering wheel", BLUE),)),
    ("speed<br>[km/h]", KMH, (("speed", "speed", BLUE),)),
    (
        "yaw rate<br>[°/s]",
        DEG,
        (("car_yaw_rate", "car", BLUE), ("trailer_yaw_rate", "trailer", ORANGE)),
    ),
    (
        "lateral acc.<br>[m/s²]",
        1.0,
        (
            ("car_lateral_acceleration", "car", BLUE),
            ("trailer_lateral_acceleration", "trailer", ORANGE),
        ),
    ),
    ("articulation<br>[°]", DEG, (("articulation", "articulation", BLUE),)),
    (
        "hitch force<br>[kN]",
        1e-3,
        (
            ("hitch_longitudinal_force", "longitudinal", BLUE),
            ("hitch_lateral_force", "lateral", ORANGE),
            ("hitch_vertical_force", "vertical", GREEN),
        ),
    ),
)


def _axle_sum(result: DriveResult, prefix: str, quantity: str, axle: str) -> Channel | None:
    names = [f"{prefix}{quantity}_{axle}{side}" for side in "lr"]
    channels = [result.drive.channels.get(name) for name in names]
    left, right = channels
    if left is None or right is None:
        return None
    total = left.value + np.interp(left.time_s, right.time_s, right.value)
    return Channel(left.name, left.time_s, total, f"{left.signal} + {right.signal}", "N")


_Line = tuple[str, str, FloatArray, FloatArray]  # label, colour, time, value


def _panels(result: DriveResult) -> list[tuple[str, list[_Line]]]:
    """Titles and lines of the panels that have any signal."""
    panels: list[tuple[str, list[_Line]]] = []
    for title, factor, entries in _PANELS:
        there = [
            (label, colour, result.drive.channels[name])
            for name, label, colour in entries
            if name in result.drive.channels
        ]
        panels.append((title, [(k, c, s.time_s, s.value * factor) for k, c, s in there]))
    for quantity, title in (
        ("wheel_lateral_force", "axle lateral<br>force [kN]"),
        ("wheel_vertical_load", "axle load<br>[kN]"),
    ):
        lines: list[_Line] = []
        for axle in AXLES:
            body, _, which = axle.partition("_")
            prefix = "trailer_" if body == "trailer" else ""
            total = _axle_sum(result, prefix, quantity, which[0])
            if total is not None:
                lines.append((f"{body} {which}", COLOUR[axle], total.time_s, total.value * 1e-3))
        panels.append((title, lines))
    return [(title, lines) for title, lines in panels if lines]


def signals(result: DriveResult) -> go.Figure:
    """Every measured signal against time."""
    panels = _panels(result)
    figure = make_subplots(
        rows=len(panels), cols=1, shared_xaxes=True, vertical_spacing=0.18 / max(4, len(panels))
    )
    for row, (title, lines) in enumerate(panels, 1):
        for label, colour, time, value in lines:
            t, y = thinned(time, value)
            figure.add_trace(
                go.Scatter(x=t, y=y, name=label, line={"color": colour, "width": 1.2},
                           showlegend=False),
                row=row, col=1,
            )  # fmt: skip
        if len(lines) > 1:
            names = (f"<span style='color:{colour}'>{label}</span>" for label, colour, *_ in lines)
            figure.add_annotation(
                text=f"<b>{' &#160; '.join(names)}</b>", x=1.0, y=1.0, xref="x domain",
                yref="y domain", xanchor="right", yanchor="bottom", showarrow=False,
                font={"size": 12}, row=row, col=1,
            )  # fmt: skip
        figure.update_yaxes(title_text=title, title_font_size=12, row=row, col=1)
    return _over_time(_layout(figure, 130 * len(panels) + 80, legend=False), result)


def time_frequency(result: DriveResult) -> go.Figure | None:
    """Spectrogram of the trailer's yaw rate (the car's without a trailer), and the line in it."""
    channels = result.drive.channels
    name = "trailer_yaw_rate" if "trailer_yaw_rate" in channels else "car_yaw_rate"
    channel = channels[name]
    rate = 20.0
    time = np.arange(channel.time_s[0], channel.time_s[-1], 1 / rate)
    value = np.interp(time, channel.time_s, channel.value)
    length = min(int(4.0 * rate), len(value))
    if length < rate:
        return None
    hop = max(2, len(value) // 1200)
    frequency, middle, density = scipy.signal.spectrogram(
        np.asarray(scipy.signal.detrend(value), dtype=np.float64), fs=rate, window="hann",
        nperseg=length, noverlap=length - min(hop, length - 1), nfft=1024, scaling="spectrum",
    )  # fmt: skip
    shown = frequency <= 3.0
    level = 20 * np.log10(np.sqrt(2 * density[shown]) * DEG + 1e-4)
    figure = go.Figure(
        go.Heatmap(
            x=middle + time[0], y=frequency[shown], z=level, colorscale="Viridis",
            zmin=float(np.percentile(level, 40)), zmax=float(level.max()),
            colorbar={
                "title": {"text": "amplitude [dB re 1 °/s]", "side": "top"}, "orientation": "h",
                "thickness": 10, "len": 0.3, "x": 1.0, "xanchor": "right", "y": 1.0,
                "yanchor": "bottom",
            },
        )
    )  # fmt: skip
    estimates = result.estimates
    good = _thin_mask(usable(estimates))
    if good.any():
        figure.add_trace(
            go.Scatter(
                x=estimates.time_s[good], y=estimates["frequency_hz"][good], mode="markers",
                marker={"color": "white", "size": 4, "line": {"color": "black", "width": 0.5}},
                name="tracked line",
            )
        )  # fmt: skip
    figure.update_yaxes(title_text="frequency [Hz]", range=[0, 3])
    _layout(figure, 430, legend=False)
    figure.update_layout(margin_t=86)
    return _over_time(figure, result)


# --- what was estimated ---------------------------------------------------------------------------


def oscillation(result: DriveResult) -> go.Figure | None:
    """Frequency, amplitude and damping ratio with bands of two standard errors."""
    estimates = result.estimates
    good = usable(estimates)
    if not good.any():
        return None
    figure = make_subplots(rows=3, cols=1, shared_xaxes=True, vertical_spacing=0.045)
    time = estimates.time_s[good]
    f, f_se = estimates["frequency_hz"][good], estimates["frequency_se_hz"][good]
    _band(figure, time, f, f_se, BLUE, "frequency", 1)
    a, a_se = estimates["amplitude_rad_s"][good] * DEG, estimates["amplitude_se_rad_s"][good] * DEG
    _band(figure, time, a, a_se, GREEN, "amplitude", 2)
    free = good & ~estimates.flagged("forced")
    z, z_se = estimates["damping_ratio"], estimates["damping_ratio_se"]
    forced = _thin_mask(good & ~free)
    figure.add_trace(
        go.Scatter(
            x=estimates.time_s[forced], y=z[forced], mode="markers",
            marker={"color": "#9ca3af", "size": 4, "symbol": "x"},
            name="apparent damping while the driver steers",
        ), row=3, col=1,
    )  # fmt: skip
    _band(figure, estimates.time_s[free], z[free], z_se[free], RED, "measured damping, free", 3)
    model = estimates.has("model")
    if model.any():
        m, m_se = estimates["model_damping_ratio"], estimates["model_damping_ratio_se"]
        _band(figure, estimates.time_s[model], m[model], m_se[model], BLUE, "model damping", 3)
    figure.add_hline(y=0.0, line={"color": "black", "width": 1, "dash": "dot"}, row=3, col=1)
    figure.update_yaxes(title_text="frequency [Hz]", range=_inner_range(f, f_se), row=1, col=1)
    figure.update_yaxes(title_text="yaw rate amplitude<br>[°/s]", rangemode="tozero", row=2, col=1)
    shown = z[free] if free.any() else z[good]
    error = z_se[free] if free.any() else z_se[good]
    both = np.concatenate([shown, estimates["model_damping_ratio"][model], [0.0]])
    low, high = _inner_range(both, error)
    figure.update_yaxes(
        title_text="damping ratio [–]", range=[max(low, -0.6), min(high, 1.0)], row=3, col=1
    )
    return _over_time(_layout(figure, 640), result)


def stiffness(result: DriveResult) -> go.Figure | None:
    """Cornering stiffness of each axle against time, and its argument."""
    estimates, good = result.estimates, usable(result.estimates)
    axles = [axle for axle in AXLES if (good & estimates.has(axle)).any()]
    if not axles:
        return None
    figure = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.06,
                           row_heights=[0.64, 0.36])  # fmt: skip
    values, errors, arguments = [], [], []
    for axle in axles:
        mask = good & estimates.has(axle)
        time = estimates.time_s[mask]
        value = estimates[f"{axle}.cornering_stiffness_n_per_rad"][mask] * 1e-3
        error = estimates[f"{axle}.cornering_stiffness_se_n_per_rad"][mask] * 1e-3
        _band(figure, time, value, error, COLOUR[axle], AXLE_NAMES[axle], 1)
        thin = _thin_mask(mask)
        argument = estimates[f"{axle}.argument_rad"][thin] * DEG
        arguments.append(argument)
        figure.add_trace(
            go.Scatter(x=estimates.time_s[thin], y=argument, mode="markers", showlegend=False,
                       marker={"color": COLOUR[axle], "size": 3}, name=AXLE_NAMES[axle]),
            row=2, col=1,
        )  # fmt: skip
        values.append(value)
        errors.append(error)
        body, _, which = axle.partition("_")
        believed = getattr(getattr(result.vehicle, body), f"{which}_cornering_stiffness", None)
        if believed:
            figure.add_hline(
                y=believed * 1e-3, line={"color": COLOUR[axle], "width": 1, "dash": "dash"},
                row=1, col=1,
            )  # fmt: skip
    low, high = _inner_range(np.concatenate(values), np.concatenate(errors))
    figure.update_yaxes(
        title_text="cornering stiffness [kN/rad]<br>dashed: vehicle.toml",
        range=[max(0.0, low), high], row=1, col=1,
    )  # fmt: skip
    flat = np.concatenate(arguments)
    figure.update_yaxes(
        title_text="argument [°]", range=_inner_range(flat, np.full(len(flat), 1.0)), row=2, col=1
    )
    return _over_time(_layout(figure, 600), result)


def loads(result: DriveResult) -> go.Figure | None:
    """Mean, effective and oscillating axle load."""
    estimates, good = result.estimates, usable(result.estimates)
    axles = [axle for axle in AXLES if (good & estimates.has(f"{axle}_load")).any()]
    if not axles:
        return None
    figure = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.07)
    for axle in axles:
        mask = good & estimates.has(f"{axle}_load")
        mask = _thin_mask(mask)
        time = estimates.time_s[mask]
        effective = estimates[f"{axle}.effective_load_n"][mask] * 1e-3
        error = estimates[f"{axle}.effective_load_se_n"][mask] * 1e-3
        _band(figure, time, effective, error, COLOUR[axle], f"{AXLE_NAMES[axle]}, effective", 1)
        figure.add_trace(
            go.Scatter(
                x=time, y=estimates[f"{axle}.load_n"][mask] * 1e-3, mode="lines",
                line={"color": COLOUR[axle], "width": 1, "dash": "dot"},
                name=f"{AXLE_NAMES[axle]}, mean",
            ), row=1, col=1,
        )  # fmt: skip
        figure.add_trace(
            go.Scatter(
                x=time, y=estimates[f"{axle}.load_harmonic_n"][mask], mode="lines",
                line={"color": COLOUR[axle], "width": 2}, showlegend=False,
                name=AXLE_NAMES[axle],
            ), row=2, col=1,
        )  # fmt: skip
    figure.update_yaxes(title_text="axle load [kN]", row=1, col=1)
    figure.update_yaxes(
        title_text="load amplitude at twice<br>the yaw frequency [N]", rangemode="tozero",
        row=2, col=1,
    )  # fmt: skip
    return _over_time(_layout(figure, 500), result)


def _model_lines(figure: go.Figure, results: list[DriveResult], speeds: FloatArray) -> None:
    """Curves of the model: identified, shifted onto the measured damping, as believed."""
    first = results[0]
    tyres = identified(results)
    believed, _ = model_damping(first.vehicle, speeds)
    if tyres:
        now, _ = model_damping(first.vehicle, speeds, tyres)
        figure.add_trace(
            go.Scatter(x=speeds * KMH, y=now, line={"color": BLUE, "width": 3},
                       name="single-track model, identified tyres")
        )  # fmt: skip
        for result in results:
            gap = damping_gap(result.values)
            if gap is not None:
                figure.add_trace(
                    go.Scatter(x=speeds * KMH, y=now + gap,
                               line={"color": RED, "width": 1.5, "dash": "dot"},
                               name=f"model shifted onto the measured damping, {result.drive.name}")
                )  # fmt: skip
    if np.isfinite(believed).any():
        figure.add_trace(
            go.Scatter(x=speeds * KMH, y=believed, line={"color": "black", "dash": "dash",
                       "width": 1}, name="single-track model, vehicle.toml")
        )  # fmt: skip


def margin_against_speed(results: list[DriveResult]) -> go.Figure | None:
    """Damping ratio over speed: model, measurements, critical speed and the speeds driven."""
    figure = go.Figure()
    critical = best_critical(results)
    top = 1.35 * critical if critical else 45.0
    speeds = np.linspace(5.0, top, 160)
    _model_lines(figure, results, speeds)
    colours = (RED, GREEN, PINK, ORANGE)
    for number, result in enumerate(results):
        free = _thin_mask(usable(result.estimates) & ~result.estimates.flagged("forced"))
        if not free.any():
            continue
        figure.add_trace(
            go.Scatter(
                x=result.estimates["speed_m_s"][free] * KMH,
                y=result.estimates["damping_ratio"][free], mode="markers",
                marker={"color": colours[number % 4], "size": 5, "opacity": 0.55},
                error_y={"array": result.estimates["damping_ratio_se"][free], "thickness": 0.6,
                         "width": 0},
                name=f"measured, {result.drive.name}",
            )
        )  # fmt: skip
    if not figure.data:
        return None
    figure.add_hrect(y0=-1.0, y1=0.0, fillcolor="#d64545", opacity=0.08, line_width=0)
    figure.add_hline(y=0.0, line={"color": "black", "width": 1})
    for number, result in enumerate(results):
        value = result.values.get("v_crit_m_s")
        if value is None:
            continue
        colour = colours[number % 4]
        figure.add_vrect(
            x0=(value.value - 2 * value.error) * KMH, x1=(value.value + 2 * value.error) * KMH,
            fillcolor=colour, opacity=0.15, line_width=0,
        )  # fmt: skip
        figure.add_vline(
            x=value.value * KMH, line={"color": colour, "width": 1.5, "dash": "dot"},
            annotation_text=f"v_crit {result.drive.name}: {value.value * KMH:.1f} km/h",
            annotation_position="top left" if number % 2 == 0 else "bottom left",
        )  # fmt: skip
    for number, result in enumerate(results):
        speed = result.drive.channels["speed"].value * KMH
        low, high = np.percentile(speed, [1, 99])
        figure.add_trace(
            go.Scatter(
                x=[low, high], y=[-0.115 - 0.02 * number] * 2, mode="lines",
                line={"color": colours[number % 4], "width": 6},
                name=f"speed driven, {result.drive.name}",
            )
        )  # fmt: skip
    figure.update_xaxes(title_text="speed [km/h]", range=[20, top * KMH])
    figure.update_yaxes(title_text="damping ratio of the sway mode [–]", range=[-0.2, 0.6])
    _layout(figure, 460)
    figure.update_layout(hovermode="closest")
    return figure


def best_critical(results: list[DriveResult]) -> float | None:
    """Critical speed of the drive that knows it best, m/s."""
    values = [r.values["v_crit_m_s"] for r in results if "v_crit_m_s" in r.values]
    return min(values, key=lambda v: v.error).value if values else None


def identified(results: list[DriveResult]) -> dict[str, float]:
    """Identified stiffness of each axle, N/rad, from the drive that knows it best."""
    found: dict[str, float] = {}
    for axle in AXLES:
        key = f"{axle}.cornering_stiffness_n_per_rad"
        values = [result.values[key] for result in results if key in result.values]
        if values:
            found[axle] = min(values, key=lambda v: v.error).value
    return found


def margin(result: DriveResult) -> go.Figure | None:
    """Speed, critical speed with its band, and the alarm state against time."""
    estimates = result.estimates
    mask = estimates.has("critical_speed") & found_critical(estimates)
    speed = result.drive.channels["speed"]
    figure = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.05,
                           row_heights=[0.86, 0.14])  # fmt: skip
    time, value = thinned(speed.time_s, speed.value * KMH)
    figure.add_trace(
        go.Scatter(x=time, y=value, line={"color": BLUE, "width": 2}, name="speed"), row=1, col=1
    )
    top = float(value.max())
    if mask.any():
        critical = estimates["v_crit_m_s"][mask] * KMH
        error = estimates["v_crit_se_m_s"][mask] * KMH
        _band(figure, estimates.time_s[mask], critical, error, RED, "critical speed ± 2 s.e.", 1)
        low, high = _inner_range(critical, error)
        figure.update_yaxes(range=[min(low, float(value.min()) - 3), max(high, top + 3)], row=1,
                            col=1)  # fmt: skip
    for alarm in result.alarms:
        figure.add_trace(
            go.Scatter(
                x=[alarm.start_s, alarm.end_s, alarm.end_s, alarm.start_s], y=[0, 0, 1, 1],
                fill="toself", fillcolor=ALARM_COLOUR[alarm.state], line={"width": 0},
                mode="lines", name=f"{alarm.state}: {', '.join(alarm.reasons)}", hoveron="fills",
                showlegend=False,
            ), row=2, col=1,
        )  # fmt: skip
    figure.update_yaxes(title_text="speed [km/h]", row=1, col=1)
    figure.update_yaxes(title_text="alarm", showticklabels=False, range=[0, 1], row=2, col=1)
    return _over_time(_layout(figure, 400), result)
