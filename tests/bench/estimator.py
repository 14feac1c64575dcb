"""Accuracy of the estimator against the Cramer-Rao bound and against other methods.

    estimator.py LIBRARY [--quick] [--report FILE]

Seeds are fixed. Prints the tables in Markdown; exit status 1 where a goal is missed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from estimator_core import (
    APART,
    FORCED,
    GAP,
    MISFIT,
    RATE_HZ,
    UNUSABLE,
    Array,
    Core,
    Estimate,
    Line,
    bound,
    middle_time,
    signal,
)
from estimator_methods import METHODS
from scipy.signal import hilbert

CYCLES = (1.6, 1.8, 2.0, 2.3, 3.0, 4.0, 6.0)
SNR_DB = (20, 40, 60)
#: rad/s or m/s2: the size of a line; the samples are micro-units.
AMPLITUDE = 0.2
TRAILER_YAW_RATE = 3


@dataclass
class Report:
    """Lines of Markdown, and whether every goal was met."""

    lines: list[str] = field(default_factory=list)
    missed: list[str] = field(default_factory=list)
    summary: list[str] = field(default_factory=list)

    def say(self, text: str = "") -> None:
        print(text, flush=True)
        self.lines.append(text)

    def table(self, head: list[str], rows: list[list[str]]) -> None:
        self.say("| " + " | ".join(head) + " |")
        self.say("|" + "---|" * len(head))
        for row in rows:
            self.say("| " + " | ".join(row) + " |")
        self.say()

    def goal(self, name: str, value: float, limit: float, low: float = -np.inf) -> None:
        if not low <= value <= limit:
            self.missed.append(f"{name}: {value:.4g}, wanted {low:.4g} to {limit:.4g}")


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
    """Root mean square by column; nan where the method failed in more than half of the trials."""
    good = ~np.isnan(values)
    count = good.sum(axis=0)
    square = np.sum(np.where(good, values, 0.0) ** 2, axis=0) / np.maximum(count, 1)
    return np.where(2 * count > len(values), np.sqrt(square), np.nan)


def number(value: float) -> str:
    """Three figures, or a dash."""
    return "-" if np.isnan(value) else f"{value:.3g}" if value >= 10 else f"{value:.2f}"


def limit_of(cycles: float) -> float:
    """The goal for RMSE over the bound."""
    return 1.15 if cycles >= 2 else 1.4


def accuracy(core: Core, report: Report, count: int, others: int, cells: list) -> None:
    """RMSE over the bound, ours and other people's, and honesty of our standard errors."""
    ours, honesty = [], []
    compared: dict[str, list[list[str]]] = {name: [] for name in METHODS}
    for cycles, snr_db in cells:
        rng = np.random.default_rng([3, round(cycles * 10), snr_db])
        ratio, normal = [], []
        by_method: dict[str, list[Array]] = {name: [] for name in METHODS}
        for i, trial in enumerate(trials(rng, cycles, snr_db, count)):
            limits = bound([trial.line], [trial.sigma], trial.rows)
            deviation = np.array([limits[0], limits[1], limits[2][0], limits[3][0]])
            estimate = core.window({TRAILER_YAW_RATE: trial.samples})
            error = errors(estimate, TRAILER_YAW_RATE, trial.line, trial.rows)
            ratio.append(error / deviation)
            normal.append(error / stated(estimate, TRAILER_YAW_RATE))
            if i < others:
                for name, method in METHODS.items():
                    by_method[name].append(
                        method_error(method(trial.samples), trial.line) / deviation
                    )
        cell = f"{cycles} cycles, {snr_db} dB"
        result = rms(np.array(ratio))
        z = np.array(normal)
        inside = 100 * (abs(z) < 1.96).mean(axis=0)
        head = [f"{cycles}", f"{snr_db}"]
        ours.append(head + [number(value) for value in result])
        variance = (z**2).mean(axis=0)
        honesty.append(
            head + [f"{v:.2f}, {p:.1f} %" for v, p in zip(variance, inside, strict=True)]
        )
        for k, what in enumerate(("frequency", "growth", "amplitude", "phase")):
            report.goal(f"RMSE/bound, {what}, {cell}", result[k], limit_of(cycles))
            report.goal(f"variance of error/SE, {what}, {cell}", variance[k], 1.25, 0.8)
            report.goal(f"95 % interval, {what}, {cell}", inside[k], 98, 92)
        for name in METHODS if others else ():
            compared[name].append([number(value) for value in rms(np.array(by_method[name]))])
    names = ["frequency", "growth", "amplitude", "phase"]
    report.say(f"### RMSE over the Cramer-Rao bound, one channel ({count} windows a cell)\n")
    report.table(["cycles", "dB", *names], ours)
    report.say("### Standard errors: variance of error/SE, share inside 1.96 SE\n")
    report.table(["cycles", "dB", *names], honesty)
    if others:
        report.summary = summary(ours, compared)
        report.say(f"### Frequency and amplitude, RMSE over the bound, other methods ({others})\n")
        rows = [
            row[:3] + [row[4]] + [f"{c[i][0]}, {c[i][2]}" for c in compared.values()]
            for i, row in enumerate(ours)
        ]
        report.table(["cycles", "dB", "ours: frequency", "ours: amplitude", *METHODS], rows)
        report.say("### Growth, RMSE over the bound, the methods that give one\n")
        growing = ["log decrement", "matrix pencil", "ERA"]
        rows = [
            row[:2] + [row[3]] + [compared[n][i][1] for n in growing] for i, row in enumerate(ours)
        ]
        report.table(["cycles", "dB", "ours", *growing], rows)


def summary(ours: list[list[str]], compared: dict[str, list[list[str]]]) -> list[str]:
    """The README's table: the worst of the three noise levels for each length of window."""
    shown = ["A.3", "Jacobsen", "matrix pencil", "ERA"]
    lines = [
        "| cycles | frequency | growth | amplitude | phase | "
        + " | ".join(f"{name}: frequency" for name in shown)
        + " |",
        "|" + "---|" * (5 + len(shown)),
    ]
    for cycles in CYCLES:
        at = [i for i, row in enumerate(ours) if row[0] == f"{cycles}"]
        cells = [max((ours[i][2 + k] for i in at), key=float) for k in range(4)]
        for name in shown:
            values = [compared[name][i][0] for i in at]
            cells.append("-" if "-" in values else max(values, key=float))
        lines.append(f"| {cycles} | " + " | ".join(cells) + " |")
    return lines


def joint(core: Core, report: Report, count: int, cells: list) -> None:
    """Four channels with one frequency and growth, unlike amplitudes and noise."""
    channels = [(1, 0.5, 1.0), (2, 3.0, 10.0), (3, 1.0, 1.0), (5, 0.3, 0.2)]  # id, size, noise
    table = []
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
        table.append(
            [f"{cycles}", f"{snr_db}"]
            + [f"{number(r)} ({v:.2f})" for r, v in zip(result, variance, strict=True)]
        )
        for k, what in enumerate(("frequency", "growth", "amplitude", "phase")):
            report.goal(f"joint {what}, {cycles} cycles, {snr_db} dB", result[k], limit_of(cycles))
            report.goal(f"joint SE {what}, {cycles} cycles, {snr_db} dB", variance[k], 1.25, 0.8)
    report.say(
        f"### Four channels together, RMSE over the joint bound (variance of error/SE; {count})\n"
    )
    report.table(["cycles", "dB", "frequency", "growth", "amplitude", "phase"], table)


def noise_free(core: Core, report: Report, phases: int) -> None:
    """Worst case over phase, frequency and growth, with offset and trend."""
    table = []
    for cycles in CYCLES:
        worst = np.zeros(3)
        for frequency in (0.4, 0.67, 0.9):
            for growth in (-0.3, 0.0, 0.3):
                for phase in np.linspace(-np.pi, np.pi, phases, endpoint=False):
                    rows = round(cycles / frequency * RATE_HZ)
                    line = Line(2 * np.pi * frequency, growth, AMPLITUDE, phase)
                    samples = signal(line, rows, 5 * AMPLITUDE, AMPLITUDE)
                    estimate = core.window({TRAILER_YAW_RATE: samples})
                    error = abs(errors(estimate, TRAILER_YAW_RATE, line, rows))
                    here = [error[0] / 2 / np.pi, 100 * error[2] / AMPLITUDE, np.degrees(error[3])]
                    worst = np.maximum(worst, here)
        table.append([f"{cycles}"] + [f"{value:.1e}" for value in worst])
        for value, limit, what in zip(worst, (1e-4, 0.1, 0.1), ("Hz", "%", "deg"), strict=True):
            report.goal(f"noise-free worst case, {cycles} cycles, {what}", value, limit)
    report.say("### Noise-free worst case over phase, frequency and growth\n")
    report.table(["cycles", "Hz (1e-4)", "amplitude % (0.1)", "phase deg (0.1)"], table)


def equation_4_3(core: Core, report: Report) -> None:
    """Amplitude 5 + 0.25 t, frequency 0.75 - 0.01 t (Eq. 4.3), beside a Hilbert transform."""
    t = np.arange(2000) / RATE_HZ
    samples = (5 + 0.25 * t) * np.sin(2 * np.pi * (0.75 * t - 0.005 * t**2))
    scale = 0.1
    found = [e for e in core.follow({3: samples * scale}, 2.0) if not e.flags]
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
            ["ours", f"{worst_f:.4f}", f"{worst_a:.2f}"],
            ["Hilbert transform", f"{by_hilbert:.4f}", f"{100 * amplitude_hilbert:.2f}"],
        ],
    )


@dataclass(frozen=True)
class Disturbance:
    """A long recording with something wrong in it between `begin` and `end` (s)."""

    name: str
    begin: float
    end: float
    run: Callable[[Core, Array, Array, np.random.Generator], list[Estimate]]
    #: flags that have to appear in every estimate whose window touches the disturbance
    must_flag: int = 0


def _channels(wave: Array, rng: np.random.Generator) -> dict[int, Array]:
    noise = AMPLITUDE * 0.01 / np.sqrt(2)
    return {
        c: g * wave + noise * rng.standard_normal(len(wave))
        for c, g in ((1, 0.6), (3, 1.0), (5, 0.8))
    }


def _changed(change: Callable[[Array, Array], Array]):
    def run(core: Core, t: Array, base: Array, rng: np.random.Generator) -> list[Estimate]:
        return core.follow(_channels(change(t, base), rng), 2.0)

    return run


def _impulses(core: Core, t: Array, base: Array, rng: np.random.Generator) -> list[Estimate]:
    samples = _channels(base, rng)
    for values in samples.values():
        at = rng.integers(0, len(t), len(t) // 100)
        values[at] += rng.choice([-2, 2], len(at)) * AMPLITUDE
    return core.follow(samples, 2.0)


def _lost(core: Core, t: Array, base: Array, rng: np.random.Generator) -> list[Estimate]:
    time, channel, value = [], [], []
    for c, values in _channels(base, rng).items():
        kept = rng.random(len(t)) > 0.05
        time.append(t[kept])
        channel.append(np.full(kept.sum(), c))
        value.append(values[kept])
    order = np.argsort(np.concatenate(time), kind="stable")
    joined = (np.concatenate(part)[order] for part in (time, channel, value))
    return core.follow_samples(*joined, 2.0)


def _gap(core: Core, t: Array, base: Array, rng: np.random.Generator) -> list[Estimate]:
    time, channel, value = [], [], []
    for c, values in _channels(base, rng).items():
        kept = (t < 20) | (t >= 20.3)
        time.append(t[kept])
        channel.append(np.full(kept.sum(), c))
        value.append(values[kept])
    order = np.argsort(np.concatenate(time), kind="stable")
    joined = (np.concatenate(part)[order] for part in (time, channel, value))
    return core.follow_samples(*joined, 2.0)


def _driver(core: Core, t: Array, base: Array, rng: np.random.Generator) -> list[Estimate]:
    drive = 0.5 * np.cos(2 * np.pi * 0.5 * t) * ((t > 15) & (t < 25))
    samples = _channels(base + AMPLITUDE * drive, rng)
    return core.follow(samples | {0: 0.3 * drive}, 2.0)


def _step(t: Array, base: Array) -> Array:
    return base * np.where(t > 20, 1.5, 1.0)


def _distorted(t: Array, base: Array) -> Array:
    second = np.cos(2 * 2 * np.pi * 0.67 * t + 0.3)
    third = np.cos(3 * 2 * np.pi * 0.67 * t + 2.0)
    return base + 0.1 * AMPLITUDE * (second + third)


DISTURBANCES = (
    Disturbance("none", 0, 0, _changed(lambda t, x: x)),
    Disturbance("driver at 0.5 Hz, 15-25 s", 15, 25, _driver, FORCED),
    Disturbance("step of the amplitude by 1.5 at 20 s", 20, 20, _changed(_step)),
    Disturbance("onset at 20 s", 20, 20, _changed(lambda t, x: x * (t > 20))),
    Disturbance("2f and 3f of 10 %", 0, 40, _changed(_distorted)),
    Disturbance("1 % impulses of two amplitudes", 0, 40, _impulses),
    Disturbance("5 % of the frames lost", 0, 40, _lost),
    Disturbance("gap of 300 ms at 20 s", 20, 20.3, _gap, GAP),
)  # fmt: skip


def is_doubted(estimate: Estimate) -> bool:
    """Whether the flags say that frequency and growth may be wrong beyond their standard errors."""
    driven = estimate.flags & FORCED and not estimate.flags & APART
    return bool(driven or estimate.flags & (UNUSABLE | MISFIT))


def disturbances(core: Core, report: Report) -> None:
    """Errors inside and outside the disturbance, and what the flags say there."""
    table = []
    t = np.arange(4000) / RATE_HZ
    base = AMPLITUDE * np.cos(2 * np.pi * 0.67 * t + 1)
    for case in DISTURBANCES:
        found = case.run(core, t, base, np.random.default_rng(5))
        settled = [e for e in found if e.mid_time > 3]
        half = 1.6
        touched = [e for e in settled if case.begin - half < e.mid_time < case.end + half]
        clear = [e for e in settled if e not in touched]
        if case.name.startswith("onset"):
            clear = [e for e in clear if e.mid_time > 20]

        def worst(some: list[Estimate]) -> str:
            usable = [e for e in some if not e.flags & UNUSABLE]
            if not usable:
                return "-"
            return f"{max(abs(e.omega / 2 / np.pi - 0.67) for e in usable):.4f}"

        honest = [e for e in touched if not is_doubted(e)]
        z = np.array([(e.omega - 2 * np.pi * 0.67) / e.omega_se for e in honest])
        flagged = sum(is_doubted(e) or bool(e.flags & (FORCED | GAP)) for e in touched)
        lost = sum(bool(e.flags & UNUSABLE) for e in clear)
        table.append(
            [
                case.name,
                worst(clear),
                f"{lost} of {len(clear)}",
                worst(touched),
                worst(honest),
                f"{np.sqrt((z**2).mean()):.1f}" if len(z) else "-",
                f"{flagged} of {len(touched)}",
            ]
        )
        report.goal(f"{case.name}: lock lost outside", lost, 0)
        if case.must_flag:
            inside = [e for e in touched if case.begin - 1.2 < e.mid_time < case.end + 1.2]
            missing = sum(not e.flags & case.must_flag for e in inside)
            report.goal(f"{case.name}: not flagged", missing, 0)
    report.say("### Disturbances (0.67 Hz, three channels, 40 dB, two cycles); errors in Hz\n")
    report.table(
        [
            "", "worst outside", "unusable outside", "worst inside, usable",
            "worst inside, not doubted", "RMS of error/SE there", "flagged inside",
        ],
        table,
    )  # fmt: skip


def dynamic_range(core: Core, report: Report, count: int) -> None:
    """1 deg/s of sway on a channel of +-300 deg/s, near its end, against double precision."""
    rng = np.random.default_rng(6)
    ours, double = [], []
    for _ in range(count):
        rows = 298
        line = Line(2 * np.pi * 0.67, 0.0, np.radians(1.0), rng.uniform(-np.pi, np.pi))
        clean = signal(line, rows, np.radians(298.0), 0.0)
        samples = clean + np.radians(0.01) * rng.standard_normal(rows)
        ours.append(errors(core.window({3: samples}), 3, line, rows))
        double.append(_double_precision(samples, line))
    loss = 20 * np.log10(rms(np.array(ours)) / rms(np.array(double)))
    report.say("### 1 deg/s of sway on 298 of +-300 deg/s: loss in dB against double precision\n")
    names = ["frequency", "growth", "amplitude", "phase"]
    report.table(names, [[f"{value:+.3f}" for value in loss]])
    for what, value in zip(names, loss, strict=True):
        report.goal(f"dynamic range, {what}, dB", value, 1.0)


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


MARKS = ("<!-- make bench-estimator writes this -->", "<!-- to here -->")


def put_summary(readme: Path, lines: list[str]) -> None:
    """Replaces what is between the marks; leaves a file without them alone."""
    text = readme.read_text(encoding="utf-8")
    begin, end = (text.find(mark) for mark in MARKS)
    if lines and 0 <= begin < end:
        table = "\n".join([MARKS[0], "", *lines, "", ""])
        readme.write_text(text[:begin] + table + text[end:], encoding="utf-8")


def main() -> int:
    """Runs the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("library", type=Path)
    parser.add_argument("--quick", action="store_true", help="a subset, in some seconds")
    parser.add_argument("--report", type=Path, help="write the tables to this file")
    parser.add_argument("--readme", type=Path, help="put the short table between its marks here")
    options = parser.parse_args()
    core, report = Core(options.library), Report()
    cells = [(cycles, snr) for snr in SNR_DB for cycles in CYCLES]
    if options.quick:
        cells = [(1.6, 40), (2.0, 20), (2.0, 60), (3.0, 40)]
    accuracy(core, report, 400 if options.quick else 1000, 0 if options.quick else 60, cells)
    joint(core, report, 300, cells)
    noise_free(core, report, 4 if options.quick else 32)
    equation_4_3(core, report)
    disturbances(core, report)
    dynamic_range(core, report, 100 if options.quick else 500)
    for line in report.missed or ["every goal met"]:
        report.say(f"- {line}")
    if options.report:
        options.report.write_text("\n".join(report.lines) + "\n", encoding="utf-8")
    if options.readme and options.readme.exists():
        put_summary(options.readme, report.summary)
    return 1 if report.missed else 0


if __name__ == "__main__":
    sys.exit(main())
