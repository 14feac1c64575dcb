"""Relations of a car alone, each from measured signals only.

Acceleration against speed times yaw rate, wheels of an axle against the yaw rate, front against
rear wheels, steering against the path's curvature. What breaks them names the sensor or the road.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

from swaywatch.diagnose.car_alone.data import LEAST_SPEED, CarData, CarRun
from swaywatch.diagnose.car_alone.effects import ACC, STEER, YAW
from swaywatch.effects.runs import RATE_HZ, low_pass
from swaywatch.plant.lanes import GRAVITY

Array = NDArray[np.float64]

SMOOTH_HZ = 1.5
GENTLE = 3.0  # m/s2: below it the wheels' radii under load transfer hardly matter
#: Track widths of cars in wheelbases; wider than any, so that a yaw rate is not accused lightly.
TRACKS_M = (1.30, 1.75)
#: Gains of a production car's sensors as standard deviations: lateral acceleration and yaw rate of
#: a stability controller (data sheets: within 3 to 4 %), speed (rolling radius within 2 %).
GAINS = (0.02, 0.02, 0.01)
#: Roll of cars per lateral acceleration, rad per m/s2, and its standard deviation: 5.5 +- 1.8 deg
#: per g, from sports cars (3) to soft family cars (8.5); Milliken, Race Car Vehicle Dynamics, 1995.
USUAL_ROLL = (0.0098, 0.0032)
BANK_HZ = 0.15
LEAST_BANK = 0.6  # m/s2
SHORTEST_BANK_S = 4.0


@dataclass(frozen=True)
class RelationFit:
    """One relation over all runs.

    Attributes
    ----------
    value, spread
        Slope and the standard deviation of it over the runs.
    residual
        RMS of what is left over the RMS of the left side.
    """

    name: str
    value: float
    spread: float
    unit: str
    residual: float
    per_run: dict[str, float]
    meaning: str

    def as_dict(self) -> dict[str, object]:
        """For diagnosis.json."""
        return dict(vars(self))


def _moving(run: CarRun) -> NDArray[np.bool_]:
    return np.asarray(low_pass(run.channels["speed"], 1.0) > LEAST_SPEED)


def _slope(rows: dict[str, tuple[Array, Array]], name: str, unit: str, meaning: str) -> RelationFit:
    """Least-squares slope over all runs; of each run too where it has enough to say."""
    left = np.concatenate([a for a, _ in rows.values()])
    right = np.concatenate([b for _, b in rows.values()])
    value = float(left @ right / (right @ right))
    per_run = {
        run: float(a @ b / (b @ b)) for run, (a, b) in rows.items() if b @ b > 0.02 * right @ right
    }
    spread = float(np.std(list(per_run.values()))) if len(per_run) > 1 else float("nan")
    rest = float(np.sqrt(np.mean((left - value * right) ** 2) / np.mean(left**2)))
    return RelationFit(name, value, spread, unit, rest, per_run, meaning)


def relations(data: CarData) -> list[RelationFit]:
    """All relations that the recorded channels allow."""
    found = []
    if all(c in data.channels for c in (YAW, ACC)):
        found.append(_turn(data))
        found.append(_lag(data))
    if all("wheel_speed_rl" in run.channels for run in data.runs) and YAW in data.channels:
        for axle, word in (("r", "rear"), ("f", "front")):
            found.append(_track(data, axle, word))
    if YAW in data.channels:
        found.append(_curvature(data))
    return found


def _turn(data: CarData) -> RelationFit:
    rows = {}
    for run in data.runs:
        on = _moving(run)
        if on.any():
            v, r = run.channels["speed"], low_pass(run.channels[YAW], SMOOTH_HZ)
            a = low_pass(run.channels[ACC], SMOOTH_HZ)
            slow = on & (np.abs(np.gradient(r) * RATE_HZ) < 0.25)
            high = _without_drift(a, slow), _without_drift(v * r, slow)
            rows[run.name] = high
    return _slope(
        rows, "lateral acceleration / (speed x yaw rate)", "-",
        "1 in a turn without bank or roll; above 1: roll lets the accelerometer see gravity, or a "
        "gain of one of the three; in quick manoeuvres the rate of the side-slip shifts it by some "
        "per cent",
    )  # fmt: skip


def _without_drift(x: Array, on: NDArray[np.bool_]) -> Array:
    """Without what is slower than 0.05 Hz: road bank and offsets."""
    sos = butter(1, 0.05 / (0.5 * RATE_HZ), btype="high", output="sos")
    return np.asarray(sosfiltfilt(sos, x))[on]


def _lag(data: CarData) -> RelationFit:
    """Time by which the acceleration follows speed times yaw rate, where they agree best."""
    per_run = {}
    for run in data.runs:
        on = _moving(run)
        if on.sum() < 5 * RATE_HZ:
            continue
        v, r = run.channels["speed"], low_pass(run.channels[YAW], 3.0)
        a = low_pass(run.channels[ACC], 3.0)
        shifts = np.arange(-0.2, 0.2001, 0.005)
        scores = [
            np.corrcoef(a[on], np.interp(run.time - s, run.time, v * r)[on])[0, 1] for s in shifts
        ]
        per_run[run.name] = round(float(shifts[int(np.argmax(scores))]), 3)
    values = list(per_run.values()) or [float("nan")]
    return RelationFit(
        "lag of the lateral acceleration behind speed x yaw rate", float(np.median(values)),
        float(np.std(values)), "s", 0.0, per_run,
        "tens of milliseconds either way are the car's (side-slip builds up) or a sensor's",
    )  # fmt: skip


def _track(data: CarData, axle: str, word: str) -> RelationFit:
    """Speed difference of an axle's wheels over the yaw rate: the track, if both are right."""
    rows = {}
    for run in data.runs:
        c = run.channels
        r = low_pass(c[YAW], SMOOTH_HZ)
        d = low_pass(c[f"wheel_speed_{axle}r"] - c[f"wheel_speed_{axle}l"], SMOOTH_HZ)
        v = low_pass(c["speed"], SMOOTH_HZ)
        on = _moving(run) & (np.abs(v * r) < GENTLE)
        if on.sum() < 3 * RATE_HZ:
            continue
        # tyres worn unequally make a difference in proportion to the speed
        bias = np.stack([v[on]], axis=1)
        d, r = d[on], r[on]
        d = d - bias @ np.linalg.lstsq(bias, d, rcond=None)[0]
        r = r - bias @ np.linalg.lstsq(bias, r, rcond=None)[0]
        rows[run.name] = (d, r)
    return _slope(
        rows, f"{word} wheels' speed difference / yaw rate", "m",
        f"the {word} track; another value than the tape's is a gain of the yaw rate",
    )  # fmt: skip


def _curvature(data: CarData) -> RelationFit:
    """Road-wheel angle against wheelbase times curvature in gentle turns."""
    car = data.vehicle.car
    rows = {}
    for run in data.runs:
        v, r = run.channels["speed"], low_pass(run.channels[YAW], SMOOTH_HZ)
        steer = low_pass(run.channels[STEER], SMOOTH_HZ) / car.steering_ratio
        on = _moving(run) & (np.abs(v * r) < GENTLE)
        if on.sum() > 3 * RATE_HZ:
            bent = (car.wheelbase * r / np.maximum(v, 1.0))[on]
            rows[run.name] = (steer[on] - steer[on].mean(), bent - bent.mean())
    if not rows:
        rows = {"none": (np.zeros(1), np.ones(1))}
    return _slope(
        rows, "road-wheel angle / (wheelbase x curvature), gentle turns", "-",
        "1 + understeer; well above 1 at low speed: steering ratio or compliance",
    )  # fmt: skip


def yaw_gain_range(found: list[RelationFit]) -> tuple[float, float] | None:
    """Gain of the yaw rate that the wheels allow: no car's track leaves `TRACKS_M`."""
    tracks = [f.value for f in found if f.unit == "m"]
    if not tracks:
        return None
    track = float(np.mean(tracks))
    return track and (TRACKS_M[0] / track, TRACKS_M[1] / track)  # type: ignore[return-value]


def banked(data: CarData, ratio: float) -> tuple[tuple[int, float, float], ...]:
    """Stretches where the acceleration leaves the turn for seconds: (run, start, stop)."""
    found = []
    if not all(c in data.channels for c in (YAW, ACC)):
        return ()
    for number, run in enumerate(data.runs):
        on = _moving(run)
        rest = run.channels[ACC] - ratio * run.channels["speed"] * run.channels[YAW]
        slow = low_pass(np.where(on, rest, 0.0), BANK_HZ, order=2)
        high = np.abs(slow) > LEAST_BANK
        edges = np.flatnonzero(np.diff(np.r_[False, high, False].astype(int)))
        for a, b in zip(edges[::2], edges[1::2], strict=True):
            if b - a >= SHORTEST_BANK_S * RATE_HZ:
                stop = run.time[min(b, run.time.size - 1)]
                begin = -EVER if a == 0 else run.time[a]
                found.append((number, float(begin), float(EVER if b >= slow.size else stop)))
    return tuple(found)


EVER = 1e6  # s: a stretch that was there before the recording began or goes on after it


def bank_angles(run: CarRun, start: float, stop: float, roll: float) -> Array:
    """Bank of a stretch in pieces of 2 s away from its ends, deg; `roll` in rad per m/s2."""
    inside = (run.time > max(start, 0.0) + 2.0) & (run.time < min(stop, run.time[-1]) - 2.0)
    turn = run.channels["speed"] * run.channels[YAW]
    rest = (turn - run.channels[ACC] / (1.0 + GRAVITY * roll))[inside]
    count = rest.size // int(2.0 * RATE_HZ)
    if not count:
        return np.zeros(0)
    pieces = rest[: count * int(2.0 * RATE_HZ)].reshape(count, -1).mean(axis=1)
    return np.asarray(np.degrees(np.arcsin(np.clip(pieces / GRAVITY, -1.0, 1.0))))


def roll_per_acceleration(
    data: CarData, slip_rate: list[Array], parts: list[tuple[int, slice]]
) -> list[float]:
    """Gravity's share of the lateral acceleration, rad per m/s2, part by part.

    Parameters
    ----------
    slip_rate
        Derivative of the lateral velocity of the fitted model and the lever of the accelerometer,
        m/s2, per part: what a_y has besides speed times yaw rate.
    parts
        Run and slice of each.
    """
    found = []
    for extra, (number, where) in zip(slip_rate, parts, strict=True):
        c = data.runs[number].channels
        true = low_pass(c["speed"][where] * c[YAW][where] + extra, SMOOTH_HZ)
        seen = low_pass(c[ACC][where], SMOOTH_HZ)
        true, seen = true - true.mean(), seen - seen.mean()
        if np.std(true) > 0.8:
            found.append(float((seen @ true / (true @ true) - 1.0) / GRAVITY))
    return found


def believed_roll(parts: list[float]) -> tuple[float, float, float, float]:
    """Roll per lateral acceleration and its standard error; before them what the sensors say.

    The scatter of the parts says nothing of the sensors' gains, and no car rolls by any amount: the
    parts' median, with both errors, is weighed with `USUAL_ROLL` (normal distributions).

    Parameters
    ----------
    parts
        As of `roll_per_acceleration`, rad per m/s2; at least one.
    """
    seen = float(np.median(parts))
    scatter = float(np.std(parts)) / np.sqrt(max(len(parts) - 1, 1))
    gains = float(np.sqrt(np.sum(np.square(GAINS)))) * (1.0 + GRAVITY * seen) / GRAVITY
    error = float(np.hypot(scatter, gains))
    usual, spread = USUAL_ROLL
    weight = spread**2 / (spread**2 + error**2)
    known = usual + weight * (seen - usual)
    return seen, error, known, float(np.sqrt(weight)) * error
