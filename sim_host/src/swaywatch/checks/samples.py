"""One channel at a time: gaps, frozen and clipped stretches, single wild samples.

A stretch of equal values is a frozen sensor only while the other channels say that this one should
have moved: a car that goes straight on shows equal yaw rates too.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import scipy.signal

from swaywatch.drive import Channel, Drive

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]
Window = tuple[float, float]

SHORTEST_FREEZE_S = 0.3
LONGER = 8.0
"""A frozen stretch is so many times longer than equal values usually last,"""
AWAY = 2.0
"""and so many times farther from what the other channels say than the channel ever is."""
KNOWN = 0.25
"""Part of a recording that it takes to learn what the other channels say."""
OFTEN_EQUAL = ("steering_wheel_angle", "speed")
"""Channels that may rest at one value; only the others tell whether they should."""
STANDING_M_S = 1.0
MOST_WINDOWS = 20
LONG_FLAT = 10
"""Samples of a flat top that is none of a rough resolution."""
WILD = 12.0
"""A spike leaves its surroundings by so many times the usual bend between neighbours,"""
FLAT = 0.3
"""which themselves move by less than this part of it."""
WILD_WHEEL = 25.0
"""A wheel can jump: bumps, and a brake that locks it and lets go."""
NAMED = 4
"""Windows or times that a sentence lists."""


@dataclass(frozen=True)
class Finding:
    """Something to know about a recording.

    Attributes
    ----------
    severity
        ``error``: results would be wrong; ``warning``: some are affected; ``info``.
    kind
        ``gap``, ``stuck``, ``clipped``, ``spike``, ``sign_or_unit``, ``swapped``, ``drift``,
        ``delay``, ``clock``, ``load``, ``loss``, ``remark``,
        ``supervision``.
    signals
        Names in the recording.
    text
        One sentence, with numbers.
    time_s
        Where to look first.
    channels
        Roles of the faulty signals, the likeliest first; empty where it is not known which.
    windows
        Start and stop in s of each stretch; a single sample starts where it stops.
    amount
        ``sign_or_unit``: factor that puts the channel right; ``drift``: unit of the channel per
        second; ``clock``: seconds of delay gained in a second.
    """

    severity: str
    kind: str
    signals: tuple[str, ...]
    text: str
    time_s: float | None = None
    channels: tuple[str, ...] = ()
    windows: tuple[Window, ...] = ()
    amount: float = 1.0


def check_samples(drive: Drive) -> list[Finding]:
    """Findings on each channel of a drive, the others informed about frozen ones."""
    findings: list[Finding] = []
    for channel in drive.channels.values():
        runs = _runs(channel.value)
        stuck = _all_along(channel, runs)
        if not stuck:
            windows = _equal_stretches(channel, runs)
            frozen = [w for w in windows if _should_move(drive, channel, w, windows)]
            stuck = _frozen_or_clipped(channel, runs, frozen)
        moving = cleaned(drive, stuck).channels[channel.name]
        findings += _gaps(channel) + stuck + _spikes(moving)
    return findings


def check_channel(channel: Channel) -> list[Finding]:
    """Findings on a channel of which nothing else is known."""
    runs = _runs(channel.value)
    stuck = _all_along(channel, runs)
    if not stuck:
        often = channel.name in OFTEN_EQUAL
        windows = [] if often else _equal_stretches(channel, runs)
        stuck = _frozen_or_clipped(channel, runs, windows)
    return _gaps(channel) + stuck + _spikes(channel)


def cleaned(drive: Drive, findings: Iterable[Finding]) -> Drive:
    """The drive without the samples that spikes, frozen and clipped stretches have spoilt.

    What is left out becomes a gap, which everything behind knows how to treat; the first and the
    last sample of a channel stay, so that the drive keeps its length.
    """
    channels = dict(drive.channels)
    for finding in findings:
        if finding.kind not in ("spike", "stuck", "clipped") or not finding.windows:
            continue
        (name,) = finding.channels
        channel = channels[name]
        bad = inside(channel.time_s, finding.windows)
        bad[[0, -1]] = False
        if 0 < np.count_nonzero(bad) < len(bad) - 2:
            channels[name] = replace(
                channel, time_s=channel.time_s[~bad], value=channel.value[~bad]
            )
    return replace(drive, channels=channels)


def inside(time_s: FloatArray, windows: Sequence[Window]) -> BoolArray:
    """Which samples lie in one of the windows. Shape of `time_s`."""
    found = np.zeros(len(time_s), dtype=np.bool_)
    for start, stop in windows:
        found |= (time_s >= start - 1e-9) & (time_s <= stop + 1e-9)
    return found


def listed(windows: Sequence[Window]) -> str:
    """Windows or times in words."""
    words = [f"{a:.2f} s" if a == b else f"{a:.2f} to {b:.2f} s" for a, b in windows[:NAMED]]
    more = len(windows) - NAMED
    return ", ".join(words) + (f" and {more} more" if more > 0 else "")


def _gaps(channel: Channel) -> list[Finding]:
    step = np.diff(channel.time_s)
    period = float(np.median(step))
    limit = max(0.1, 3.0 * period)
    wide = np.flatnonzero(step > limit)
    if not len(wide):
        return []
    worst = wide[np.argmax(step[wide])]
    windows = tuple((float(channel.time_s[i]), float(channel.time_s[i + 1])) for i in wide)
    return [
        Finding(
            "warning",
            "gap",
            (channel.signal,),
            f"{channel.signal}: {len(wide)} gap(s) without a valid sample ({listed(windows)}), the "
            f"longest {step[worst]:.2f} s at {channel.time_s[worst]:.2f} s (usual step "
            f"{period * 1e3:.1f} ms); estimates whose window touches a gap are marked",
            float(channel.time_s[worst]),
            (channel.name,),
            windows,
        )
    ]


def _runs(value: FloatArray) -> tuple[IntArray, IntArray]:
    """Start and length of each stretch of equal samples."""
    edges = np.flatnonzero(np.diff(value) != 0.0) + 1
    starts = np.concatenate([[0], edges])
    lengths = np.diff(np.concatenate([starts, [len(value)]]))
    return starts, lengths


def _resolution(channel: Channel) -> float:
    if channel.resolution > 0.0:
        return channel.resolution
    steps = np.abs(np.diff(np.unique(channel.value)))
    return float(steps.min()) if len(steps) else 0.0


def _all_along(channel: Channel, runs: tuple[IntArray, IntArray]) -> list[Finding]:
    if len(runs[0]) > 1:
        return []
    return [
        Finding(
            "warning",
            "stuck",
            (channel.signal,),
            f"{channel.signal}: the same value {channel.value[0]:g} {channel.unit} through the "
            "whole recording; is the sensor connected?",
            None,
            (channel.name,),
            ((float(channel.time_s[0]), float(channel.time_s[-1])),),
        )
    ]


def _equal_stretches(channel: Channel, runs: tuple[IntArray, IntArray]) -> list[Window]:
    """Stretches of equal values that last far longer than they usually do."""
    starts, lengths = runs
    period = float(np.median(np.diff(channel.time_s)))
    found = []
    for at in np.argsort(-lengths)[:MOST_WINDOWS]:
        count = int(lengths[at])
        if count * period < SHORTEST_FREEZE_S:
            break
        short = lengths[lengths < count / 4]
        if short.sum() * period < 2.0 * SHORTEST_FREEZE_S:
            continue
        usual = float(np.percentile(np.repeat(short, short), 90))
        if count >= LONGER * usual:
            first = int(starts[at])
            found.append((float(channel.time_s[first]), float(channel.time_s[first + count - 1])))
    return sorted(found)


def _should_move(drive: Drive, channel: Channel, window: Window, suspect: Sequence[Window]) -> bool:
    """Whether the other channels, which elsewhere tell this one, say another value here."""
    others = [c for c in drive.channels.values() if c is not channel and len(c.time_s) > 3]
    if channel.name == "speed":  # steady is what it should be; only the wheels know better
        others = [c for c in others if c.name.startswith("wheel_speed")]
        if np.interp(window[0], channel.time_s, channel.value) < STANDING_M_S:
            return False
    rate_hz = 20.0
    grid = np.arange(channel.time_s[0], channel.time_s[-1], 1.0 / rate_hz)
    columns = [np.ones(len(grid))]
    for other in others:
        held = _equal_stretches(other, _runs(other.value))
        if other.name not in OFTEN_EQUAL and any(a < window[1] and b > window[0] for a, b in held):
            continue  # perhaps frozen with it
        value = np.interp(grid, other.time_s, other.value)
        columns += [value, np.gradient(value)]
    a = np.stack(columns, axis=1)
    a = a / (np.sqrt(np.mean(a**2, axis=0)) + 1e-12)
    value = np.interp(grid, channel.time_s, channel.value)
    out = inside(grid, suspect)
    here = inside(grid, [window])
    known = np.count_nonzero(~out)
    if len(columns) < 3 or known < max(4 * a.shape[1], KNOWN * len(grid)) or not here.any():
        return False
    normal = a[~out].T @ a[~out] + 1e-6 * np.eye(a.shape[1]) * np.count_nonzero(~out)
    rest = value - a @ np.linalg.solve(normal, a[~out].T @ value[~out])
    size = int(np.count_nonzero(here))
    sliding = np.convolve(np.where(out, 0.0, rest) ** 2, np.ones(size) / size, mode="valid")
    usual = float(np.sqrt(sliding.max())) if len(sliding) else math.inf
    away = float(np.sqrt(np.mean(rest[here] ** 2)))
    return away > AWAY * usual and away > 2.0 * _resolution(channel)


def _merged(windows: Sequence[Window], gap_s: float = 0.05) -> list[Window]:
    found: list[Window] = []
    for a, b in sorted(windows):
        if found and a <= found[-1][1] + gap_s:
            found[-1] = (found[-1][0], max(b, found[-1][1]))
        else:
            found.append((a, b))
    return found


def _stuck(channel: Channel, windows: Sequence[Window]) -> list[Finding]:
    if not windows:
        return []
    longest = max(windows, key=lambda w: w[1] - w[0])
    held = channel.value[np.searchsorted(channel.time_s, longest[0])]
    return [
        Finding(
            "warning",
            "stuck",
            (channel.signal,),
            f"{channel.signal}: frozen {listed(windows)}, the longest for "
            f"{longest[1] - longest[0]:.2f} s at {held:g} {channel.unit}, while other signals move",
            longest[0],
            (channel.name,),
            tuple(windows),
        )
    ]


def _frozen_or_clipped(
    channel: Channel, runs: tuple[IntArray, IntArray], frozen: Sequence[Window]
) -> list[Finding]:
    """A flat top is clipped, however long it lasts."""
    clipped = _clipped(channel, runs, frozen)
    flat = clipped[0].windows if clipped else ()
    return _stuck(channel, _merged([w for w in frozen if w not in flat])) + clipped


def _clipped(
    channel: Channel, runs: tuple[IntArray, IntArray], frozen: Sequence[Window]
) -> list[Finding]:
    """Flat tops: several stretches at the highest or lowest value, entered by a large step.

    One is enough where the others say that the channel should have moved on.
    """
    starts, lengths = runs
    value, resolution = channel.value, _resolution(channel)
    windows: list[Window] = []
    ends: list[str] = []
    limited = False
    for end, word in ((float(value.max()), "upper"), (float(value.min()), "lower")):
        if end == 0.0:  # standing still is no clipping
            continue
        at_end = (value[starts] == end) & (lengths >= 4) & (starts > 0)
        entry = np.abs(value[starts] - value[np.maximum(starts - 1, 0)])
        flat = at_end & (entry >= 3.0 * resolution)
        limit = max(channel.limits) if word == "upper" else min(channel.limits)
        on_limit = math.isfinite(limit) and abs(end - limit) <= resolution
        first = channel.time_s[starts]
        held = flat.any() and any(np.any(first[flat] == start) for start, _ in frozen)
        if channel.name not in OFTEN_EQUAL:
            held |= flat.any() and at_end.sum() >= 2 and lengths[at_end].max() >= LONG_FLAT
        tops = flat.sum() >= 2 and channel.name not in OFTEN_EQUAL  # hands may stop at one angle
        if tops or held or (on_limit and at_end.any()):
            first = starts[at_end]
            last = first + lengths[at_end] - 1
            time_s = channel.time_s
            windows += [
                (float(time_s[i]), float(time_s[j])) for i, j in zip(first, last, strict=True)
            ]
            ends.append(f"its {word} end {end:g} {channel.unit}")
            limited |= on_limit
    if not windows:
        return []
    windows.sort()
    count = int(np.count_nonzero(inside(channel.time_s, windows)))
    return [
        Finding(
            "warning",
            "clipped",
            (channel.signal,),
            f"{channel.signal}: clipped at {' and '.join(ends)} ({count} samples: "
            f"{listed(windows)})"
            + ("; that is the limit of its bits or its DBC range" if limited else ""),
            windows[0][0],
            (channel.name,),
            tuple(windows),
        )
    ]


def wild_samples(value: FloatArray, resolution: float, jumpy: bool = False) -> IntArray:
    """Indices of samples, alone or in pairs, that leave their surroundings and come back.

    The tip of a fast steering impulse is none: beside it the signal moves as fast.
    """
    if len(value) < 50:
        return np.zeros(0, dtype=np.int64)
    smooth = scipy.signal.medfilt(value, 5)
    smooth[:2], smooth[-2:] = smooth[2], smooth[-3]
    rest = np.abs(value - smooth)
    bend = value[1:-1] - 0.5 * (value[2:] + value[:-2])
    scale = 1.4826 * float(np.median(np.abs(bend))) + resolution
    spread = float(np.subtract(*np.percentile(value, [84.0, 16.0]))) / 2.0
    times, least = (WILD_WHEEL, 0.1) if jumpy else (WILD, 0.01)
    step = np.abs(np.diff(smooth, prepend=smooth[0]))
    moving = np.max([np.roll(step, shift) for shift in range(-2, 4)], axis=0)
    found: IntArray = np.flatnonzero(
        (rest > max(times * scale, least * spread)) & (moving < FLAT * rest)
    )
    found = found[(found > 2) & (found < len(value) - 3)]
    return np.array([i for i in found if _off_both_sides(value, found, i, 0.5 * rest[i])], int)


def _off_both_sides(value: FloatArray, wild: IntArray, index: int, least: float) -> bool:
    """Neither what came before nor what comes after leads to a sample: no corner of the signal."""
    near = set(wild.tolist())
    before = index - (2 if index - 1 in near else 1)
    after = index + (2 if index + 1 in near else 1)
    led = value[before] + (value[before] - value[before - 1]) * (index - before)
    leads = value[after] - (value[after + 1] - value[after]) * (after - index)
    return bool(min(abs(value[index] - led), abs(value[index] - leads)) > least)


def _spikes(channel: Channel) -> list[Finding]:
    """Single samples far off their surroundings."""
    jumpy = channel.name == "speed" or channel.name.startswith(("wheel_", "trailer_wheel_"))
    wild = wild_samples(channel.value, _resolution(channel), jumpy)
    if not len(wild):
        return []
    smooth = scipy.signal.medfilt(channel.value, 5)
    size = channel.value[wild] - smooth[wild]
    worst = int(np.argmax(np.abs(size)))
    at = tuple((float(t), float(t)) for t in channel.time_s[wild])
    return [
        Finding(
            "warning",
            "spike",
            (channel.signal,),
            f"{channel.signal}: {len(wild)} single-sample spike(s) ({listed(at)}), the largest "
            f"by {size[worst]:+.3g} {channel.unit} at {at[worst][0]:.2f} s",
            at[worst][0],
            (channel.name,),
            at,
        )
    ]
