"""What goes with the way, whatever the motion: what comes, fades, or comes and goes along the road.

Ruts, wind between houses, a brake that binds. What comes and goes has a size and a number of
repetitions for each kilometre; where on the road a run begins nobody knows, so each run has a phase
of its own. How often it repeats is seen in what a model leaves, against the way (`repetitions`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from swaywatch.effects.effect import Act, Parameter, Values, Window
from swaywatch.effects.runs import RATE_HZ, Run, block_mean
from swaywatch.plant.lanes import BODY, PlantInput

Array = NDArray[np.float64]

SPEED_M_S = 25.0  # at which the gain of a law is stated
DISTANCE = "distance"  # the variable of what does not depend on the motion
AXLES = "axles"
#: Wheels of one side of the trailer: a yaw moment by their drag, which the ball has to pull.
DRAG = "drag_trailer"
HALF_TRACK_M = 0.95  # of a trailer
#: Series slots that represent a force at a place, with their sign.
SLOTS: dict[str, tuple[tuple[str, float], ...]] = {
    "hitch": (("moment_car", 1.0), ("moment_trailer", -1.0)),
    "force_car": (("force_car", 1.0),),
    "force_trailer": (("force_trailer", 1.0),),
    "moment_car": (("moment_car", 1.0),),
    "moment_trailer": (("moment_trailer", 1.0),),
    DRAG: (("moment_trailer", 1.0),),
    "slip_car_front": (("slip_car_front", 1.0),),
    "slip_car_rear": (("slip_car_rear", 1.0),),
    "slip_trailer": (("slip_trailer_front", 1.0), ("slip_trailer_rear", 1.0)),
    AXLES: tuple(
        (f"slip_{axle}", 1.0) for axle in ("car_front", "car_rear", "trailer_front", "trailer_rear")
    ),
}
#: Where something can come and go along the road: on a body, an axle, or every axle in turn.
ROAD_PLACES = (
    AXLES, "force_car", "force_trailer", "moment_car", "moment_trailer", "slip_car_front",
    "slip_car_rear", "slip_trailer",
)  # fmt: skip
USUAL_WORK_RAD_M = 1e-3  # that a hitch works through in a test drive, where no sensor says so
NARROWEST = 0.98  # above which part of a sine a pulse may be: a sixteenth of the way
RISE_S = 0.05  # within which something breaks or comes loose
#: Repetitions for each kilometre that are looked for: every 15 to 400 m.
FEWEST, MOST = 2.5, 65.0
MOST_GRIPS = 130.0  # of tyres on slabs, every 8 m
FINENESS = 0.2  # of what the way of the longest run can resolve
COARSE = 0.5  # the same where each costs more
BESIDE = 6  # of that, over which the power of neighbours is averaged
CHOSEN = 5  # numbers of repetitions that are tried at every place


def begins(names: Sequence[str]) -> tuple[Parameter, ...]:
    """The moment of each run from which on something acts."""
    return tuple(
        Parameter(f"begins_{i + 1}_s", "s", 0.0, -5.0, 1e5, (20.0,), 0.2, 1e9)
        for i in range(len(names))
    )


def since(run: Run, values: Values, names: Sequence[str]) -> Array:
    """Share of what acts from a moment of each run on, shape (n,); in an unknown run all of it."""
    if stretch(run) not in names:
        return np.ones(run.time.size)
    at = values[f"begins_{names.index(stretch(run)) + 1}_s"]
    return np.asarray(0.5 + 0.5 * np.tanh((run.time - at) / RISE_S))


def driven(run: Run) -> Array:
    """Way from the start of the recording, m, shape (n,); of a part of it with that before."""
    before = float(run.speed[0] * run.time[0])
    return np.asarray(before + np.cumsum(run.speed) / RATE_HZ)


def worked(run: Run) -> Array:
    """Angle that the hitch has worked through from the start of a run, rad, shape (n,)."""
    if not run.both_watched:
        return driven(run) * USUAL_WORK_RAD_M
    return np.asarray(np.cumsum(np.abs(run.yaw_rates["trailer"] - run.yaw_rates["car"])) / RATE_HZ)


def left(run: Run, values: Values) -> Array:
    """Share that is left of what fades over a way, or over an angle that the hitch works through.

    The former exponentially, the latter as what wears by its own work. Shape (n,).
    """
    if "over_rad" in values:
        return np.asarray(1.0 / (1.0 + worked(run) / max(values["over_rad"], 1e-3)))
    return np.asarray(np.exp(-driven(run) / max(values["over_m"], 1.0)))


def stretch(run: Run) -> str:
    """What tells a run, or a stretch of one, from others: also of files that have one name."""
    speed = float(run.channels["speed"][0]) if "speed" in run.channels else 0.0
    return f"{run.name} from {run.time[0]:.2f} s at {speed:.6f} m/s"


def phases(names: Sequence[str]) -> tuple[Parameter, ...]:
    """Repetitions, and where in one each run begins."""
    often = Parameter("repetitions_per_km", "1/km", 0.0, 0.2, 200.0, (10.0,), 0.02, 1e9)
    each = (f"phase_{i + 1}_rad" for i in range(len(names)))
    return (often, *(Parameter(p, "rad", 0.0, -20.0, 20.0, (0.0,), 0.2, 1e9) for p in each))


def course(
    run: Run,
    values: Values,
    names: Sequence[str],
    behind_m: float = 0.0,
    *,
    half: bool = False,
    raised: bool = False,
) -> Array:
    """A sine along the road, or its positive half alone, as what is so far behind the car meets it.

    Of what comes in pulses only what is above a part of it, as high as it was. Raised: from nothing
    to one, and half of that in the mean. 0 in an unknown run.
    """
    if stretch(run) not in names:
        return np.zeros(run.time.size)
    phase = values[f"phase_{names.index(stretch(run)) + 1}_rad"]
    turns = values["repetitions_per_km"] * (driven(run) - behind_m) / 1000.0
    sine = np.sin(2.0 * np.pi * turns + phase)
    above = min(values.get("above", 0.0), NARROWEST)
    if raised and not half:
        return np.asarray(0.5 + 0.5 * sine)
    return np.asarray(np.maximum(sine - above, 0.0) / (1.0 - above) if half else sine)


def set_drag(plant: PlantInput, place: str) -> None:
    """Wheels of one side that make a moment by their drag, which the ball has to pull."""
    if place == DRAG:
        plant.scalar("law_drag_trailer", 1.0 / HALF_TRACK_M)


def comes_and_goes(
    place: str, names: Sequence[str], power: int = 0, *, grip: bool = False, half: bool = False
) -> Act:
    """What a place of the road does each time: it adds a force, or to the stiffness of tyres.

    `half`: only in one direction, as what lies beside a part of the road does.
    """

    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del windows
        set_drag(plant, place)
        for slot, sign in SLOTS[place]:
            behind = behind_m(plant.body, slot) if place == AXLES else 0.0
            sine = course(run, values, names, behind, half=half)
            name = slot.replace("slip_", "stiffness_") if grip else slot
            plant.add_series(name, sign * values["gain"] * sine * (run.speed / SPEED_M_S) ** power)

    return act


def behind_m(body: Array, slot: str) -> float:
    """How far an axle is behind the car's centre of gravity, m; of a vehicle's values."""
    at = {key: float(body[i]) for i, key in enumerate(BODY)}
    trailer = at["car.hitch_to_cog"] + at["trailer.hitch_to_cog"]
    return {
        "slip_car_front": -at["car.front_axle_to_cog"],
        "slip_car_rear": at["car.rear_axle_to_cog"],
        "slip_trailer_front": trailer - at["trailer.front_axle_to_cog"],
        "slip_trailer_rear": trailer + at["trailer.rear_axle_to_cog"],
    }[slot]


def longest_way_km(runs: Sequence[Run]) -> float:
    """Way of the longest run, km."""
    return max(0.05, *(float(way[-1] - way[0]) / 1000.0 for way in map(driven, runs)))


def repetitions(runs: Sequence[Run], residuals: Sequence[Array]) -> list[float]:
    """Repetitions for each kilometre that stand out in what a model leaves, the clearest first.

    Parameters
    ----------
    runs, residuals
        Of each run what is left, over its noise, shape (blocks x channels,).

    Returns
    -------
    list of float
        Where the power against the way, of all runs, is largest over that of its neighbours.
    """
    ways = [block_mean(driven(run)) / 1000.0 for run in runs]
    longest = longest_way_km(runs)
    rates = np.arange(FEWEST, MOST, FINENESS / longest)
    total = np.zeros(rates.size)
    for way, flat in zip(ways, residuals, strict=True):
        rest = flat.reshape(way.size, -1)
        total += [np.sum(np.abs(np.exp(-2j * np.pi * r * way) @ rest) ** 2) for r in rates]
    width = max(1, round(BESIDE / FINENESS))
    around = np.convolve(np.pad(total, width, mode="edge"), np.ones(2 * width + 1), mode="valid")
    found: list[float] = []
    for i in np.argsort(-total / around):
        peak = total[i] >= np.max(total[max(i - 1, 0) : i + 2])
        if peak and all(abs(rates[i] - other) > 1.0 / longest for other in found):
            found.append(float(rates[i]))
    return found[:CHOSEN]
