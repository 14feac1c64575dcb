"""The estimator on signals that are not one damped line, or not all there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from estimator_accuracy import AMPLITUDE
from estimator_core import (
    APART,
    FORCED,
    GAP,
    MISFIT,
    RATE_HZ,
    SEEKING,
    UNUSABLE,
    Array,
    Core,
    Estimate,
)
from estimator_report import Report

SECONDS = 40
#: An estimate is wrong where frequency or growth is off by more than so many standard errors.
WRONG = 4.0


@dataclass(frozen=True)
class Scene:
    """A line of 40 s, and when something happens to it."""

    t: Array
    base: Array
    frequency: float
    event: float
    rng: np.random.Generator


@dataclass(frozen=True)
class Disturbance:
    """A long recording with something wrong in it between `begin` and `end` (s after the event)."""

    name: str
    #: nothing: the whole of it is disturbed
    span: tuple[float, float] | None
    run: Callable[[Core, Scene], list[Estimate]]
    #: one of these is due in every estimate whose window holds it in more than the newest third
    #: (a gap: sixth) and, at its old end, in more than a tenth
    must_flag: int = 0
    #: no estimate may be without a line
    holds: bool = True
    #: before the event there is nothing to see
    silent_before: bool = False


def _channels(wave: Array, rng: np.random.Generator) -> dict[int, Array]:
    noise = AMPLITUDE * 0.01 / np.sqrt(2)
    return {
        c: g * wave + noise * rng.standard_normal(len(wave))
        for c, g in ((1, 0.6), (3, 1.0), (5, 0.8))
    }


def _changed(change: Callable[[Scene], Array]) -> Callable[[Core, Scene], list[Estimate]]:
    def run(core: Core, scene: Scene) -> list[Estimate]:
        return core.follow(_channels(change(scene), scene.rng), 2.0)

    return run


def _impulses(core: Core, scene: Scene) -> list[Estimate]:
    samples = _channels(scene.base, scene.rng)
    for values in samples.values():
        at = scene.rng.integers(0, len(values), len(values) // 100)
        values[at] += scene.rng.choice([-2, 2], len(at)) * AMPLITUDE
    return core.follow(samples, 2.0)


def _frames(core: Core, scene: Scene, kept: Callable[[], np.ndarray]) -> list[Estimate]:
    """Through the grid, with the samples of each channel that are kept."""
    time, channel, value = [], [], []
    for c, values in _channels(scene.base, scene.rng).items():
        here = kept()
        time.append(scene.t[here])
        channel.append(np.full(here.sum(), c))
        value.append(values[here])
    order = np.argsort(np.concatenate(time), kind="stable")
    joined = (np.concatenate(part)[order] for part in (time, channel, value))
    return core.follow_samples(*joined, 2.0)


def _lost(core: Core, scene: Scene) -> list[Estimate]:
    return _frames(core, scene, lambda: scene.rng.random(len(scene.t)) > 0.05)


def _gap(core: Core, scene: Scene) -> list[Estimate]:
    return _frames(core, scene, lambda: (scene.t < scene.event) | (scene.t >= scene.event + 0.3))


def _driver(core: Core, scene: Scene) -> list[Estimate]:
    """The driver steers at 0.5 Hz, 0.17 Hz below the sway, for 10 s."""
    tone = np.cos(2 * np.pi * (scene.frequency - 0.17) * scene.t)
    drive = 0.5 * tone * ((scene.t > scene.event - 5) & (scene.t < scene.event + 5))
    samples = _channels(scene.base + AMPLITUDE * drive, scene.rng)
    return core.follow(samples | {0: 0.3 * drive}, 2.0)


def _step(scene: Scene) -> Array:
    return scene.base * np.where(scene.t > scene.event, 1.5, 1.0)


def _onset(scene: Scene) -> Array:
    return scene.base * (scene.t > scene.event)


def _distorted(scene: Scene) -> Array:
    turn = 2 * np.pi * scene.frequency * scene.t
    second = np.cos(2 * turn + scene.rng.uniform(0, 6))
    third = np.cos(3 * turn + scene.rng.uniform(0, 6))
    return scene.base + 0.1 * AMPLITUDE * (second + third)


#: No line is held any more. (An estimate that has not converged or shows no oscillation is flagged,
#: and the line is held on to for some more.)
LOST = SEEKING
BROKEN = MISFIT | UNUSABLE
DISTURBANCES = (
    Disturbance("none", (0, 0), _changed(lambda scene: scene.base)),
    Disturbance("two tones: driver 0.17 Hz below, for 10 s", (-5, 5), _driver, FORCED | BROKEN),
    Disturbance("amplitude steps by 1.5", (0, 0), _changed(_step), BROKEN, holds=False),
    Disturbance("onset", (0, 0), _changed(_onset), BROKEN, holds=False, silent_before=True),
    Disturbance("2f and 3f of 10 % each", None, _changed(_distorted)),
    Disturbance("1 % impulses of two amplitudes", None, _impulses),
    Disturbance("5 % of the frames lost", None, _lost),
    Disturbance("gap of 300 ms in all channels", (0, 0.3), _gap, GAP),
)  # fmt: skip


def is_flagged(estimate: Estimate) -> bool:
    """Whether the flags say that frequency and growth may be wrong beyond their standard errors."""
    driven = estimate.flags & FORCED and not estimate.flags & APART
    return bool(driven or estimate.flags & BROKEN)


@dataclass
class Tally:
    """Counts over all scenes of one disturbance; errors of the frequency in Hz."""

    outside: int = 0
    lost_outside: int = 0
    flagged_outside: int = 0
    inside: int = 0
    lost_inside: int = 0
    flagged: int = 0
    due: int = 0
    due_missing: int = 0
    wrong: int = 0
    error_outside: float = 0.0
    error_usable: float = 0.0
    error_trusted: float = 0.0

    def take(self, case: Disturbance, scene: Scene, estimate: Estimate) -> None:
        """One estimate after the first 3 s."""
        begin, end = case.span or (-SECONDS, SECONDS)
        before, after = scene.event + begin - estimate.end_time, scene.event + end
        touched = before < 0 and after > estimate.mid_time - estimate.half_s
        error = abs(estimate.omega / 2 / np.pi - scene.frequency)
        lost = bool(estimate.flags & LOST)
        if not touched or case.name == "none":
            if case.silent_before and before >= 0:
                return
            # a window that held the disturbance may leave its mark on the next half window
            late = estimate.mid_time - 1.6 * estimate.half_s < after
            self.outside += 1
            self.lost_outside += lost
            self.flagged_outside += is_flagged(estimate) and not (late and case.span is not None)
            self.error_outside = max(self.error_outside, error)
            return
        self.inside += 1
        self.lost_inside += lost
        self.flagged += is_flagged(estimate) or bool(estimate.flags & case.must_flag)
        if case.span is not None and case.must_flag:
            entered = -before > 2 / 3 * estimate.half_s * (0.5 if case.must_flag == GAP else 1.0)
            leaving = after - (estimate.mid_time - estimate.half_s) < 0.2 * estimate.half_s
            self.due += entered and not leaving
            self.due_missing += entered and not leaving and not estimate.flags & case.must_flag
        if estimate.flags & UNUSABLE:
            return
        self.error_usable = max(self.error_usable, error)
        if not is_flagged(estimate):
            self.error_trusted = max(self.error_trusted, error)
            z_omega = 2 * np.pi * error / estimate.omega_se
            self.wrong += max(z_omega, abs(estimate.growth) / estimate.growth_se) > WRONG


def disturbances(core: Core, report: Report, scenes: int) -> None:
    """Errors inside and outside the disturbance, and what the flags say there."""
    rows = []
    for case in DISTURBANCES:
        tally = Tally()
        rng = np.random.default_rng(5)
        t = np.arange(SECONDS * int(RATE_HZ)) / RATE_HZ
        for _ in range(scenes):
            frequency = rng.uniform(0.6, 0.75)
            wave = np.cos(2 * np.pi * frequency * t + rng.uniform(0, 2 * np.pi))
            scene = Scene(t, AMPLITUDE * wave, frequency, 20 + rng.uniform(-1, 1), rng)
            for estimate in case.run(core, scene):
                if estimate.mid_time > 3:
                    tally.take(case, scene, estimate)
        rows.append(_row(case, tally))
        _goals(report, case, tally)
    report.say(
        f"### Disturbances ({scenes} recordings each of 40 s, 0.6-0.75 Hz, any phase, three "
        "channels, 40 dB, windows of two oscillations); errors in Hz\n"
    )
    report.table(
        [
            "", "worst outside", "no line outside", "flagged outside", "worst inside",
            "worst inside, not flagged", f"off by > {WRONG:.0f} SE, not flagged",
            "no line inside", "flagged inside", "not flagged although disturbed",
        ],
        rows,
    )  # fmt: skip


def _row(case: Disturbance, tally: Tally) -> list[str]:
    out = tally.outside > 0
    return [
        case.name,
        f"{tally.error_outside:.4f}" if out else "-",
        f"{tally.lost_outside} of {tally.outside}" if out else "-",
        f"{tally.flagged_outside}" if out else "-",
        f"{tally.error_usable:.4f}" if tally.inside else "-",
        f"{tally.error_trusted:.4f}" if tally.inside else "-",
        f"{tally.wrong} of {tally.inside}" if tally.inside else "-",
        f"{tally.lost_inside}" if tally.inside else "-",
        f"{tally.flagged} of {tally.inside}" if tally.inside else "-",
        f"{tally.due_missing} of {tally.due}" if tally.due else "-",
    ]


def _goals(report: Report, case: Disturbance, tally: Tally) -> None:
    name = case.name
    report.goal(f"{name}: tracking lost outside", tally.lost_outside, 0)
    report.goal(
        f"{name}: flagged outside, share", tally.flagged_outside / max(tally.outside, 1), 0.001
    )
    if case.holds:
        report.goal(f"{name}: tracking lost inside", tally.lost_inside, 0)
    if case.must_flag:
        missing = tally.due_missing / max(tally.due, 1)
        report.goal(f"{name}: not flagged although disturbed, share", missing, 0.01)
        report.goal(f"{name}: estimates where a flag is due", tally.due, np.inf, 10)
    report.goal(f"{name}: wrong and not flagged, share", tally.wrong / max(tally.inside, 1), 0.02)
    if case.span is None:
        report.goal(f"{name}: flagged, share", tally.flagged / max(tally.inside, 1), 0.02)
    seen = [f"tracking lost without cause {tally.lost_outside + case.holds * tally.lost_inside}"]
    if case.must_flag:
        seen.append(f"not flagged although disturbed {tally.due_missing} of {tally.due}")
    elif tally.inside:
        seen.append(f"flagged {tally.flagged} of {tally.inside}")
    else:
        seen.append(f"flagged {tally.flagged_outside} of {tally.outside}")
    if tally.inside:
        seen.append(f"off by > {WRONG:.0f} SE and not flagged {tally.wrong} of {tally.inside}")
    report.show(f"disturbance: {name}", "0; <= 1 %; <= 2 %", "; ".join(seen))
