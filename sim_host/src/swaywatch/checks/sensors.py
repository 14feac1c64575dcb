"""Two swapped channels, and an offset that drifts: identified from the other channels.

Swapped channels of one quantity break the relations of :mod:`swaywatch.checks.relations`, and
swapped back they hold; left and right wheel of an axle enter those as a sum, but the outer wheel
carries the load, and the loaded wheel the side force. A drift shows in every static balance that a
channel is in, with the weight it has there, and in no other.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import scipy.signal

from swaywatch.checks.relations import Relation, RelationBuilder, badness, make_relations
from swaywatch.checks.samples import Finding
from swaywatch.drive import Drive, Grid
from swaywatch.roles import WHEELS
from swaywatch.vehicle import Vehicle

FloatArray = npt.NDArray[np.float64]

LIVELY = 0.12
"""Relations with a rest below it leave nothing for a swap to explain."""
SWAP_GAIN = 0.5
SWAP_REST = 0.35
AGAINST = -0.6
"""Correlation below which left and right are taken for each other."""

MIRRORED = (
    " - or, as it is so at every axle, all lateral signals are positive to the right (SAE axes) "
    "instead of to the left (ISO 8855): then `sign = -1` for each of these"
)

SLOW_HZ = 0.15
"""Corner below which a drift is looked for: no sway is that slow."""
BLOCK_S = 2.0
FEWEST_BLOCKS = 8
FEWEST_FREE = 3.0
"""Independent values of the slow balance that have to be left beside what is fitted to it."""
LEAST_DRIFT = 0.1
"""Part of a channel's standard deviation that a drift worth a word amounts to over the run."""
SURE = 7.0
"""So many standard errors it is away from none,"""
STRAIGHT = 0.8
"""this part of the balance's slow changes it explains,"""
SHARE = 0.15
"""and this part of what it does not explain is left."""
FLOOR = 0.02


# --- swapped --------------------------------------------------------------------------------------


def check_swapped(
    drive: Drive, vehicle: Vehicle, grid: Grid, relations: list[Relation]
) -> tuple[float, list[Finding]]:
    """Pairs that explain broken relations when swapped back; the rest that is left then."""
    sides = _sides(drive, grid)
    rests = [relation.rest() for relation in relations if relation.tight]
    now = badness(rests) if rests else 0.0
    broken = any(relation.is_broken() for relation in relations)
    if now < LIVELY and not broken:
        return now, sides
    best: tuple[float, tuple[str, str] | None] = (np.inf, None)
    for pair in _pairs(drive):
        a, b = pair
        if not _nearer_to_their_axles(grid, pair):
            continue
        value = {**grid.value, a: grid.value[b], b: grid.value[a]}
        trial = make_relations(drive, vehicle, replace(grid, value=value))
        rests = [relation.rest() for relation in trial if relation.tight]
        score = badness(rests) if rests else np.inf
        if score < best[0] and not any(relation.is_broken() for relation in trial):
            best = (score, pair)
    score, chosen = best
    if chosen is None or score > SWAP_GAIN * now or score > SWAP_REST:
        return now, sides
    names = "; ".join(r.name for r in relations if r.tight and r.rest() > 0.5 * now)
    detail = f"does not hold: {names} (residual {100 * now:.0f} %, swapped {100 * score:.0f} %)"
    return score, [_swapped(drive, chosen, detail), *sides]


def _nearer_to_their_axles(grid: Grid, pair: tuple[str, str]) -> bool:
    """Whether two lateral forces, swapped back, go with the other wheel of their axles no less.

    What turns the car about its vertical axis (a brake) breaks its balance as a swap does.
    """
    for name, swapped in (pair, pair[::-1]):
        other = grid.value.get(name[:-1] + ("l" if name[-1] == "r" else "r"))
        if "wheel_lateral_force" not in name or other is None:
            continue
        now, then = (float(np.corrcoef(grid.value[n], other)[0, 1]) for n in (name, swapped))
        if then < now:
            return False
    return True


def _swapped(drive: Drive, pair: tuple[str, str], detail: str) -> Finding:
    first, second = (drive.channels[name] for name in pair)
    return Finding(
        "error",
        "swapped",
        (first.signal, second.signal),
        f"{first.signal} and {second.signal} are swapped: {detail}; swap them in the signals.toml",
        None,
        pair,
        ((float(first.time_s[0]), float(first.time_s[-1])),),
    )


def _pairs(drive: Drive) -> Iterator[tuple[str, str]]:
    """Channels of one quantity that a harness or a mapping can swap; not left and right."""
    groups = [("car_yaw_rate", "trailer_yaw_rate")]
    groups += [("car_lateral_acceleration", "trailer_lateral_acceleration")]
    for prefix in ("", "trailer_"):
        groups += [
            (f"{prefix}wheel_lateral_force_{front}", f"{prefix}wheel_lateral_force_{rear}")
            for front in WHEELS[:2]
            for rear in WHEELS[2:]
        ]
    for pair in groups:
        if all(name in drive.channels for name in pair):
            yield pair


def _sides(drive: Drive, grid: Grid) -> list[Finding]:
    """Left and right wheels taken for each other."""
    found: list[Finding] = []
    loads = 0
    for prefix, body in (("", "car"), ("trailer_", "trailer")):
        side = grid.value.get(f"{body}_lateral_acceleration")
        if side is None:
            continue
        low = _slow(side - side.mean(), grid.rate_hz)
        for axle in ("f", "r"):
            for quantity in ("vertical_load", "lateral_force"):
                pair = (f"{prefix}wheel_{quantity}_{axle}l", f"{prefix}wheel_{quantity}_{axle}r")
                if not all(name in grid.value for name in pair):
                    continue
                score = side_score(grid, pair, low, "vertical" in quantity)
                loads += score is not None and "vertical" in quantity
                if score is not None and score < AGAINST:
                    what = "loaded" if "vertical" in quantity else "pulling"
                    found.append(
                        _swapped(
                            drive,
                            pair,
                            f"the inner wheel is the more {what} one in every bend (correlation "
                            f"{score:+.2f} with where the outer one should be)",
                        )
                    )
    if loads > 1 and sum("vertical" in finding.channels[0] for finding in found) == loads:
        return [replace(finding, text=finding.text + MIRRORED) for finding in found]
    return found


def side_score(grid: Grid, pair: tuple[str, str], side: FloatArray, vertical: bool) -> float | None:
    """Correlation of right minus left with where the load goes; positive as it should be."""
    left, right = (grid.value[name] for name in pair)
    difference = _slow(right - left, grid.rate_hz)
    total = _slow(left + right, grid.rate_hz)
    total = total - total.mean()
    columns = np.stack([np.ones_like(total), total], axis=1)
    expected = side if vertical else total * side
    if vertical:
        columns = columns[:, :1]
    good = np.ones(len(total), dtype=np.bool_)
    for name in pair:
        good &= grid.valid[name]
    if good.sum() < 3 * grid.rate_hz or float(np.std(side)) < 0.2:
        return None
    columns, difference, expected = columns[good], difference[good], expected[good]
    difference = difference - columns @ np.linalg.lstsq(columns, difference, rcond=None)[0]
    expected = expected - columns @ np.linalg.lstsq(columns, expected, rcond=None)[0]
    norm = float(np.linalg.norm(difference) * np.linalg.norm(expected))
    return float(difference @ expected) / norm if norm > 0.0 else None


def _slow(value: FloatArray, rate_hz: float, corner_hz: float = 2.5) -> FloatArray:
    sos = scipy.signal.butter(2, corner_hz, fs=rate_hz, output="sos")
    return np.asarray(scipy.signal.sosfiltfilt(sos, value))


# --- drift ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Balance:
    """A sum that stays the same but for what `known` makes of it.

    `weight` says how much of a channel's drift it shows; `size` is the variation of its largest
    term.
    """

    weight: dict[str, float]
    total: FloatArray
    known: tuple[FloatArray, ...]
    size: float


@dataclass(frozen=True)
class _Trend:
    """Slope of a balance per second, its standard error, and how straight it is."""

    weight: dict[str, float]
    slope: float
    error: float
    straight: float


def check_drift(drive: Drive, vehicle: Vehicle, grid: Grid) -> list[Finding]:
    """The one channel whose offset drifts, from all balances that it is in."""
    found = [_trend(balance, grid) for balance in balances(drive, vehicle, grid)]
    trends = [trend for trend in found if trend is not None]
    length = float(grid.time_s[-1] - grid.time_s[0])
    ranked = []
    for name in sorted({name for trend in trends for name in trend.weight}):
        result = _explained(trends, name)
        if result is not None:
            ranked.append((*result, name))
    if not ranked:
        return []
    ranked.sort()
    left, slope, error, straight, name = ranked[0]
    before = sum((t.slope / t.error) ** 2 for t in trends)
    channel = drive.channels[name]
    change = slope * length
    large = abs(change) > LEAST_DRIFT * float(np.std(channel.value))
    if not large or abs(slope) < SURE * error or straight < STRAIGHT:
        return []
    if left > SHARE * before + 4.0 * len(trends):
        return []
    equal = [n for other, *_, n in ranked[1:] if other < left + 0.1 * (before - left)][:3]
    also = f" (or that of {', '.join(drive.channels[n].signal for n in equal)})" if equal else ""
    return [
        Finding(
            "warning",
            "drift",
            (channel.signal, *(drive.channels[n].signal for n in equal)),
            f"{channel.signal}: its offset{also} drifts by {change:+.3g} {channel.unit} over the "
            f"{length:.0f} s of the run ({slope:+.2g} +- {1.645 * error:.1g} {channel.unit}/s), "
            "against the balances with the other signals",
            float(grid.time_s[0]),
            (name, *equal),
            ((float(grid.time_s[0]), float(grid.time_s[-1])),),
            slope,
        )
    ]


def _explained(trends: list[_Trend], name: str) -> tuple[float, float, float, float] | None:
    """What a drift of one channel leaves of all trends; its slope, error and straightness."""
    mine = [t for t in trends if name in t.weight]
    weight = np.array([t.weight[name] for t in mine])
    slope = np.array([t.slope for t in mine])
    error = np.array([t.error for t in mine])
    precision = float(np.sum((weight / error) ** 2))
    if precision <= 0.0:
        return None
    drift = float(np.sum(weight * slope / error**2)) / precision
    left = sum((t.slope / t.error) ** 2 for t in trends if name not in t.weight)
    left += float(np.sum(((slope - weight * drift) / error) ** 2))
    clearest = mine[int(np.argmax(np.abs(weight) / error))]
    return left, drift, 1.0 / np.sqrt(precision), clearest.straight


def _trend(balance: Balance, grid: Grid) -> _Trend | None:
    size = round(BLOCK_S * grid.rate_hz)
    count = len(grid.time_s) // size
    if count < FEWEST_BLOCKS:
        return None

    valid = np.all(list(grid.valid.values()), axis=0)[: count * size].reshape(count, size)
    whole = valid.all(axis=1)
    count = int(whole.sum())
    if count < FEWEST_BLOCKS:
        return None

    def blocks(value: FloatArray) -> FloatArray:
        value = _slow(value, grid.rate_hz, SLOW_HZ)[: whole.size * size]
        return np.asarray(value.reshape(-1, size).mean(axis=1)[whole])

    time = blocks(grid.time_s)
    time = time - time.mean()
    others = [blocks(known) for known in balance.known]
    columns = np.stack([np.ones(count), *(k - k.mean() for k in others)], axis=1)
    total = blocks(balance.total)
    bare = time - columns @ np.linalg.lstsq(columns, time, rcond=None)[0]
    flat = total - columns @ np.linalg.lstsq(columns, total, rcond=None)[0]
    power = float(bare @ bare)
    if power < 0.1 * float(time @ time):
        return None
    slope = float(bare @ flat) / power
    rest = flat - slope * bare
    # below its corner a balance has two independent values a second for each hertz
    independent = min(2.0 * SLOW_HZ * BLOCK_S, 1.0) * count
    freedom = independent - columns.shape[1] - 1
    if freedom < FEWEST_FREE:
        return None
    spread = np.sqrt(float(rest @ rest) / freedom)
    floor = FLOOR * balance.size / float(grid.time_s[-1] - grid.time_s[0])
    error = float(np.hypot(spread / np.sqrt(power), floor))
    if error <= 0.0:  # nothing moves: a car that stands
        return None
    straight = 1.0 - float(rest @ rest) / (float(flat @ flat) + 1e-30)
    return _Trend(balance.weight, slope, error, straight)


def balances(drive: Drive, vehicle: Vehicle, grid: Grid) -> list[Balance]:
    """Static balances of the channels, with whatever else moves them."""
    value = grid.value
    zero: tuple[FloatArray, ...] = ()
    speed = value.get("speed")
    known = (speed,) if speed is not None and float(np.std(speed)) > 0.3 else zero
    side = value.get("car_lateral_acceleration")
    moved = known if side is None else (*known, side)
    found = [
        _weighted(terms, value, moved) for terms in RelationBuilder(drive, vehicle, grid).raw()
    ]
    if speed is not None and "car_yaw_rate" in value:
        for body in ("car", "trailer"):
            name, yaw = f"{body}_lateral_acceleration", f"{body}_yaw_rate"
            if name in value and yaw in value:
                total = value[name] - speed * value[yaw]
                weight = {name: 1.0, yaw: -float(np.mean(speed))}
                # a body that rolls, and a gain that is a little off, show with the side force
                found.append(
                    Balance(weight, total, (*known, value[name]), float(np.std(value[name])))
                )
    if "car_yaw_rate" in value and "trailer_yaw_rate" in value:
        total = value["trailer_yaw_rate"] - value["car_yaw_rate"]
        weight = {"trailer_yaw_rate": 1.0, "car_yaw_rate": -1.0}
        found.append(Balance(weight, total, zero, float(np.std(value["trailer_yaw_rate"]))))
    found += _steering(value)
    return found + _wheels(value, known)


def _steering(value: dict[str, FloatArray]) -> list[Balance]:
    """The steering angle of slow driving: a part for the bend and one for the side force."""
    names = ("steering_wheel_angle", "speed", "car_yaw_rate", "car_lateral_acceleration")
    if not all(name in value for name in names):
        return []
    steer, speed, yaw, side = (value[name] for name in names)
    bend = yaw / np.maximum(speed, 5.0)
    return [Balance({names[0]: 1.0}, steer, (bend, side), float(np.std(steer)))]


def _weighted(
    terms: dict[str, tuple[float, FloatArray]],
    value: dict[str, FloatArray],
    known: tuple[FloatArray, ...],
) -> Balance:
    weight = {name: factor for name, (factor, _) in terms.items() if factor}
    total = sum((term for _, term in terms.values()), np.zeros(1))
    size = max(float(np.std(term)) for _, term in terms.values())
    return Balance(weight, np.asarray(total), known, size)


def _wheels(value: dict[str, FloatArray], known: tuple[FloatArray, ...]) -> list[Balance]:
    """Each wheel against the rest of its body: loads shift with the side force, forces share it."""
    found = []
    for prefix, body in (("", "car"), ("trailer_", "trailer")):
        side = value.get(f"{body}_lateral_acceleration")
        for axle in ("f", "r"):
            for quantity in ("vertical_load", "lateral_force"):
                left, right = (f"{prefix}wheel_{quantity}_{axle}{s}" for s in "lr")
                if side is None or left not in value or right not in value:
                    continue
                total = value[left] + value[right]
                size = float(np.std(value[left]))
                apart = (side,) if "vertical" in quantity else (side, side**2)
                weight = {right: 1.0, left: -1.0}
                difference = value[right] - value[left]
                found.append(Balance(weight, difference, (*known, *apart), size))
                if "vertical" in quantity:
                    weight = {right: 1.0, left: 1.0}
                    found.append(Balance(weight, total, (*known, side), size))
    return found
