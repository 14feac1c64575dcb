"""Accuracy of the estimator beside the Cramer-Rao bound, other methods and double precision."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from estimator_core import (
    RATE_HZ,
    Array,
    Core,
    Estimate,
    Line,
    bound,
    middle_time,
    signal,
)
from estimator_methods import METHODS, SLOW
from estimator_report import Report, number, table
from scipy.signal import hilbert

CYCLES = (1.6, 1.8, 2.0, 2.3, 3.0, 4.0, 6.0)
SNR_DB = (20, 40, 60)
QUANTITIES = ("frequency", "growth", "amplitude", "phase")
#: rad/s or m/s2: the size of a line; the samples are micro-units.
AMPLITUDE = 0.2
TRAILER_YAW_RATE = 3
Cell = tuple[float, int]


@dataclass(frozen=True)
class Trial:
    """One window: what is in it, and the samples."""

    line: Line
    sigma: float
    rows: int
    samples: Array


def trials(rng: np.random.Generator, cycles: float, snr_db: float, count: int) -> Iterator[Trial]:
    """Windows as issue 3 asks for: random frequency, growth, phase, offset and trend."""
    sigma = AMPLITUDE * 10 ** (-snr_db / 20) / np.sqrt(2)
    for _ in range(count):
        frequency = rng.uniform(0.4, 0.9)
        rows = round(cycles / frequency * RATE_HZ)
        line = Line(
            2 * np.pi * frequency, rng.uniform(-0.3, 0.3), AMPLITUDE, rng.uniform(-np.pi, np.pi)
        )
        clean = signal(line, rows, rng.uniform(-5, 5) * AMPLITUDE, rng.choice([-1, 1]) * AMPLITUDE)
        yield Trial(line, sigma, rows, clean + sigma * rng.standard_normal(rows))


def wrapped(angle: float) -> float:
    """Angle into -pi..pi."""
    return float(np.angle(np.exp(1j * angle)))


def errors(estimate: Estimate, channel: int, line: Line, rows: int) -> Array:
    """Errors of omega, growth, amplitude, phase at the middle of the window that was given."""
    late = estimate.mid_time - (rows - 1) / 2 / RATE_HZ
    amplitude = abs(estimate.amplitude[channel]) * np.exp(-estimate.growth * late)
    phase = np.angle(estimate.amplitude[channel]) - estimate.omega * late
    return np.array(
        [
            estimate.omega - line.omega,
            estimate.growth - line.growth,
            amplitude - line.amplitude,
            wrapped(phase - line.phase),
        ]
    )


def stated(estimate: Estimate, channel: int) -> Array:
    """Standard errors that the estimator states, in the order of errors()."""
    return np.array(
        [
            estimate.omega_se,
            estimate.growth_se,
            estimate.amplitude_se[channel],
            estimate.phase_se[channel],
        ]
    )


def method_error(result: tuple[float | None, ...], line: Line) -> Array:
    """Errors of another method; nan for what it does not give."""
    omega, growth, amplitude, phase = (np.nan if value is None else value for value in result)
    return np.array(
        [
            omega - line.omega,
            growth - line.growth,
            amplitude - line.amplitude,
            np.nan if np.isnan(phase) else wrapped(phase - line.phase),
        ]
    )


def rms(values: Array) -> Array:
    """Root mean square by column; nan where a method failed in more than half of the trials."""
    good = ~np.isnan(values)
    count = good.sum(axis=0)
    square = np.sum(np.where(good, values, 0.0) ** 2, axis=0) / np.maximum(count, 1)
    return np.where(2 * count > len(values), np.sqrt(square), np.nan)


def limit_of(cycles: float) -> float:
    """The goal for RMSE over the bound."""
    return 1.15 if cycles >= 2 else 1.4


@dataclass(frozen=True)
class CellResult:
    """RMSE over the bound of ours and of the others, variance of error/SE, % inside 1.96 SE."""

    ours: Array
    variance: Array
    inside: Array
    others: dict[str, Array]
    flagged: int


def run_cell(core: Core, cell: Cell, count: int, slow: int) -> CellResult:
    """All methods on the same windows; the slow ones on the first `slow` of them."""
    rng = np.random.default_rng([3, round(cell[0] * 10), cell[1]])
    ratio, normal, flagged = [], [], 0
    others: dict[str, list[Array]] = {name: [] for name in METHODS if slow}
    for i, trial in enumerate(trials(rng, *cell, count)):
        limits = bound([trial.line], [trial.sigma], trial.rows)
        deviation = np.array([limits[0], limits[1], limits[2][0], limits[3][0]])
        estimate = core.window({TRAILER_YAW_RATE: trial.samples})
        error = errors(estimate, TRAILER_YAW_RATE, trial.line, trial.rows)
        ratio.append(error / deviation)
        normal.append(error / stated(estimate, TRAILER_YAW_RATE))
        flagged += bool(estimate.flags)
        for name, found in others.items():
            if i < slow or name not in SLOW:
                found.append(method_error(METHODS[name](trial.samples), trial.line) / deviation)
    z = np.array(normal)
    return CellResult(
        rms(np.array(ratio)),
        (z**2).mean(axis=0),
        100 * (abs(z) < 1.96).mean(axis=0),
        {name: rms(np.array(found)) for name, found in others.items()},
        flagged,
    )


def accuracy(core: Core, report: Report, count: int, slow: int, cells: list[Cell]) -> None:
    """RMSE over the bound, ours and other people's, and honesty of our standard errors."""
    results = {cell: run_cell(core, cell, count, slow) for cell in cells}
    for (cycles, snr_db), result in results.items():
        name = f"{cycles} cycles, {snr_db} dB"
        for k, what in enumerate(QUANTITIES):
            report.goal(f"RMSE/bound, {what}, {name}", result.ours[k], limit_of(cycles))
            report.goal(f"variance of error/SE, {what}, {name}", result.variance[k], 1.25, 0.8)
            report.goal(f"95 % interval, {what}, {name}", result.inside[k], 98, 92)
        report.goal(f"windows without a good flag, {name}", result.flagged / count, 0.001)
    _say_accuracy(report, results, count, slow)
    _sum_up(report, results, count)


def _say_accuracy(report: Report, results: dict[Cell, CellResult], count: int, slow: int) -> None:
    names = list(QUANTITIES)
    report.say(f"### RMSE over the Cramer-Rao bound, one channel ({count} windows a cell)\n")
    report.table(
        ["cycles", "dB", *names],
        [[str(x) for x in cell] + [number(v) for v in r.ours] for cell, r in results.items()],
    )
    report.say("### Standard errors: variance of error/SE, share inside 1.96 SE\n")
    report.table(
        ["cycles", "dB", *names],
        [
            [str(x) for x in cell]
            + [f"{v:.2f}, {p:.1f} %" for v, p in zip(r.variance, r.inside, strict=True)]
            for cell, r in results.items()
        ],
    )
    if not slow:
        return
    for k, what in enumerate(QUANTITIES):
        gives = [n for n in METHODS if any(not np.isnan(r.others[n][k]) for r in results.values())]
        report.say(
            f"### {what}: RMSE over the bound, all methods "
            f"(the same windows; {' and '.join(SLOW)}: the first {slow})\n"
        )
        report.table(
            ["cycles", "dB", "swaywatch", *gives],
            [
                [str(x) for x in cell]
                + [number(r.ours[k])]
                + [number(r.others[name][k]) for name in gives]
                for cell, r in results.items()
            ],
        )


def _sum_up(report: Report, results: dict[Cell, CellResult], count: int) -> None:
    """The README's table: the worst of the noise levels for each length of window."""
    everything = list(results.values())
    rows = []
    for cycles in sorted({cell[0] for cell in results}):
        here = [r for cell, r in results.items() if cell[0] == cycles]
        ours = np.max([r.ours for r in here], axis=0)
        others = [np.max([r.others[n][0] for r in here]) for n in everything[0].others]
        rows.append([f"{cycles}", *(number(v) for v in ours), *(number(v) for v in others)])
    names = [*QUANTITIES, *(f"{name}: frequency" for name in everything[0].others)]
    report.by_cycles = [
        f"RMSE over the Cramer-Rao bound, worst of 20, 40 and 60 dB, {count} windows a cell: "
        "offset to 5 amplitudes, trend, growth -0.3 to 0.3 1/s, 0.4 to 0.9 Hz, any phase",
        "",
        *table(["cycles", *names], rows),
    ]
    for low, high, limit in ((0.0, 1.9, 1.4), (1.9, 9.0, 1.15)):
        worst = max(
            (float(r.ours.max()) for cell, r in results.items() if low < cell[0] < high),
            default=np.nan,
        )
        span = "1.6 and 1.8 oscillations" if high < 2 else "2 oscillations and more"
        report.show(f"RMSE over the bound, worst cell, {span}", f"<= {limit}", number(worst))
    variance = np.array([r.variance for r in everything])
    inside = np.array([r.inside for r in everything])
    report.show(
        "variance of error/SE, all cells", "0.8 to 1.25",
        f"{variance.min():.2f} to {variance.max():.2f}",
    )  # fmt: skip
    report.show(
        "errors inside 1.96 SE, all cells", "92 to 98 %",
        f"{inside.min():.1f} to {inside.max():.1f} %",
    )  # fmt: skip


def joint(core: Core, report: Report, count: int, cells: list[Cell]) -> None:
    """Four channels with one frequency and growth, unlike amplitudes and noise."""
    channels = [(1, 0.5, 1.0), (2, 3.0, 10.0), (3, 1.0, 1.0), (5, 0.3, 0.2)]  # id, size, noise
    rows, worst, spread = [], 0.0, []
    for cycles, snr_db in cells:
        rng = np.random.default_rng([4, round(cycles * 10), snr_db])
        ratio, normal = [], []
        for trial in trials(rng, cycles, snr_db, count):
            lines, sigmas, samples = [], [], {}
            for channel, size, noise in channels:
                line = Line(
                    trial.line.omega,
                    trial.line.growth,
                    AMPLITUDE * size,
                    rng.uniform(-np.pi, np.pi),
                )
                clean = signal(
                    line, trial.rows, rng.uniform(-5, 5) * line.amplitude, line.amplitude
                )
                sigmas.append(trial.sigma * noise)
                samples[channel] = clean + sigmas[-1] * rng.standard_normal(trial.rows)
                lines.append(line)
            limits = bound(lines, sigmas, trial.rows)
            estimate = core.window(samples)
            error = errors(estimate, channels[0][0], lines[0], trial.rows)
            ratio.append(error / np.array([limits[0], limits[1], limits[2][0], limits[3][0]]))
            normal.append(error / stated(estimate, channels[0][0]))
        result, variance = rms(np.array(ratio)), (np.array(normal) ** 2).mean(axis=0)
        rows.append(
            [f"{cycles}", f"{snr_db}"]
            + [f"{number(r)} ({v:.2f})" for r, v in zip(result, variance, strict=True)]
        )
        worst = max(worst, float(result.max()))
        spread.extend(variance)
        for k, what in enumerate(QUANTITIES):
            report.goal(f"joint {what}, {cycles} cycles, {snr_db} dB", result[k], limit_of(cycles))
            report.goal(f"joint SE {what}, {cycles} cycles, {snr_db} dB", variance[k], 1.25, 0.8)
    report.say(
        f"### Four channels together, RMSE over the joint bound (variance of error/SE; {count})\n"
    )
    report.table(["cycles", "dB", *QUANTITIES], rows)
    report.show(
        "four channels jointly, RMSE over the joint bound; variance of error/SE",
        "<= 1.15 (1.4); 0.8 to 1.25",
        f"{worst:.2f}; {min(spread):.2f} to {max(spread):.2f}",
    )


def noise_free(core: Core, report: Report, phases: int) -> None:
    """Worst case over phase, frequency and growth, with offset and trend."""
    rows, of_all = [], np.zeros(3)
    for cycles in CYCLES:
        worst = np.zeros(3)
        for frequency in (0.4, 0.67, 0.9):
            for growth in (-0.3, 0.0, 0.3):
                for phase in np.linspace(-np.pi, np.pi, phases, endpoint=False):
                    count = round(cycles / frequency * RATE_HZ)
                    line = Line(2 * np.pi * frequency, growth, AMPLITUDE, phase)
                    samples = signal(line, count, 5 * AMPLITUDE, AMPLITUDE)
                    estimate = core.window({TRAILER_YAW_RATE: samples})
                    error = abs(errors(estimate, TRAILER_YAW_RATE, line, count))
                    here = [error[0] / 2 / np.pi, 100 * error[2] / AMPLITUDE, np.degrees(error[3])]
                    worst = np.maximum(worst, here)
        of_all = np.maximum(of_all, worst)
        rows.append([f"{cycles}"] + [f"{value:.1e}" for value in worst])
        for value, limit, what in zip(worst, (1e-4, 0.1, 0.1), ("Hz", "%", "deg"), strict=True):
            report.goal(f"noise-free worst case, {cycles} cycles, {what}", value, limit)
    report.say("### Noise-free worst case over phase, frequency and growth\n")
    report.table(["cycles", "Hz (1e-4)", "amplitude % (0.1)", "phase deg (0.1)"], rows)
    report.show(
        "noise-free worst case over phase, 1.6 to 6 oscillations",
        "1e-4 Hz, 0.1 %, 0.1 deg",
        f"{of_all[0]:.1e} Hz, {of_all[1]:.1e} %, {of_all[2]:.1e} deg",
    )


def equation_4_3(core: Core, report: Report) -> None:
    """Amplitude 5 + 0.25 t, frequency 0.75 - 0.01 t (Eq. 4.3), beside a Hilbert transform."""
    t = np.arange(2000) / RATE_HZ
    samples = (5 + 0.25 * t) * np.sin(2 * np.pi * (0.75 * t - 0.005 * t**2))
    scale = 0.1
    every = core.follow({3: samples * scale}, 2.0)
    first = next(i for i, e in enumerate(every) if not e.flags)
    found = every[first:]
    report.goal("Eq. 4.3, first good estimate after, s", every[first].end_time, 3.0)
    report.goal("Eq. 4.3, flagged after the first window", sum(bool(e.flags) for e in found), 0)
    mid = np.array([e.mid_time for e in found])
    frequency = np.array([e.omega for e in found]) / 2 / np.pi - (0.75 - 0.01 * mid)
    amplitude = np.array([abs(e.amplitude[3]) for e in found]) / scale / (5 + 0.25 * mid) - 1
    analytic = hilbert(samples)
    instant = np.gradient(np.unwrap(np.angle(analytic)), t) / 2 / np.pi
    at = slice(int(mid[0] * RATE_HZ), int(mid[-1] * RATE_HZ))
    by_hilbert = abs(instant - (0.75 - 0.01 * t))[at].max()
    amplitude_hilbert = abs(abs(analytic) / (5 + 0.25 * t) - 1)[at].max()
    worst_f, worst_a = abs(frequency).max(), 100 * abs(amplitude).max()
    report.goal("Eq. 4.3, frequency in Hz", worst_f, 0.002)
    report.goal("Eq. 4.3, amplitude in %", worst_a, 0.5)
    report.say(
        "### Eq. 4.3: amplitude 5 + 0.25 t, frequency 0.75 - 0.01 t, worst after one window\n"
    )
    report.table(
        ["", "frequency Hz (0.002)", "amplitude % (0.5)"],
        [
            ["swaywatch", f"{worst_f:.4f}", f"{worst_a:.2f}"],
            ["Hilbert transform", f"{by_hilbert:.4f}", f"{100 * amplitude_hilbert:.2f}"],
        ],
    )
    report.show(
        "Eq. 4.3 followed (Hilbert transform beside it)",
        "0.002 Hz, 0.5 %",
        f"{worst_f:.4f} Hz, {worst_a:.2f} % ({by_hilbert:.3f} Hz, {100 * amplitude_hilbert:.1f} %)",
    )


def dynamic_range(core: Core, report: Report, count: int) -> None:
    """1 deg/s of sway on a channel of +-300 deg/s, near its ends, against double precision."""
    rng = np.random.default_rng(6)
    ours, double = [], []
    for _ in range(count):
        rows = 298
        line = Line(2 * np.pi * 0.67, 0.0, np.radians(1.0), rng.uniform(-np.pi, np.pi))
        clean = signal(line, rows, np.radians(298.0) * rng.choice([-1, 1]), 0.0)
        samples = clean + np.radians(0.01) * rng.standard_normal(rows)
        ours.append(errors(core.window({3: samples}), 3, line, rows))
        double.append(_double_precision(samples, line))
    loss = 20 * np.log10(rms(np.array(ours)) / rms(np.array(double)))
    report.say("### 1 deg/s of sway on 298 of +-300 deg/s: loss in dB against double precision\n")
    report.table(list(QUANTITIES), [[f"{value:+.3f}" for value in loss]])
    for what, value in zip(QUANTITIES, loss, strict=True):
        report.goal(f"dynamic range, {what}, dB", value, 1.0)
    report.show(
        "1 deg/s of sway on a channel of +-300 deg/s, loss against double precision",
        "< 1 dB",
        f"{loss.max():.2f} dB",
    )


def _double_precision(samples: Array, start: Line) -> Array:
    """Maximum likelihood in double precision from the true values; errors as in errors()."""
    t = middle_time(len(samples))
    omega, growth = start.omega, start.growth
    for _ in range(20):
        wave = np.exp((growth + 1j * omega) * t)
        columns = np.stack([wave.real, -wave.imag, np.ones(len(t)), t], axis=1)
        c, *_ = np.linalg.lstsq(columns, samples, rcond=None)
        slope = t * (c[0] + 1j * c[1]) * wave
        jacobian = np.column_stack([columns, slope.real, -slope.imag])
        step, *_ = np.linalg.lstsq(jacobian, samples, rcond=None)
        growth, omega = growth + step[4], omega + step[5]
    line = complex(c[0], c[1])
    return np.array(
        [
            omega - start.omega,
            growth - start.growth,
            abs(line) - start.amplitude,
            wrapped(float(np.angle(line)) - start.phase),
        ]
    )
