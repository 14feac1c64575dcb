"""The missing force itself: the input at a place that explains the runs, with its error over time.

Linear least squares of pulses under the observer (`diagnose/evidence/locate.py`): the channels'
responses to a pulse at the place are simulated, and the amplitudes of all pulses and the initial
state are solved for together, the vehicle as it was fitted beside the law. The law itself does not
enter into it, so that it can be compared with it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import bilinear, lfilter

from swaywatch.diagnose.evidence.locate import Locator
from swaywatch.diagnose.fit.fit import OBSERVER, Fit, Fitter, plant_of
from swaywatch.discover.effect import ID, RATE_S, bend_of, made_of, side_of
from swaywatch.discover.find import Discovery
from swaywatch.discover.forms import amount, curve, share_by_the_way, sized
from swaywatch.discover.law import (
    ANYWHERE,
    BALL,
    BODIES,
    HEADINGS,
    LAGGED,
    MOMENT,
    MOTIONS,
    OSCILLATING,
    PERIODIC,
    PLACES,
    SIDES,
    SUDDEN,
    THERE,
    TRANSIENT,
    Law,
    of_a_motion,
    one_way,
)
from swaywatch.discover.way import (
    AXLES,
    DISTANCE,
    DRAG,
    SLOTS,
    SPEED_M_S,
    course,
    driven,
    since,
    stretch,
)
from swaywatch.effects.effect import Act, Effect, Parameter, Values, Window
from swaywatch.effects.runs import RATE_HZ, Run
from swaywatch.plant.lanes import BODY, LAW_FELT, OUTPUT, PlantInput, simulate

Array = NDArray[np.float64]

PULSE_S = 0.25
RIDGE = 1e-2


def _act(
    slots: Sequence[tuple[str, float]],
) -> Act:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del values
        for window in windows:
            for slot, sign in slots:
                plant.add_series(slot, sign * window.values["size"] * window.mask(run.time))

    return act


def free_input(place: str, ahead_m: float = 0.0) -> Effect:
    """An unknown input at a place, in pulses; of a place of a body: so far ahead of its centre."""
    size, body = PLACES[place], ANYWHERE.get(place, "")
    lever = ((f"force_{body}", 1.0), (f"moment_{body}", ahead_m))
    return Effect(
        id="_input",
        component=place,
        kind="physics",
        equation="an unknown input",
        source="none",
        parameters=(Parameter("size", size.unit, 0.0, -1e6, 1e6, (1.0,), 0.2 * size.level),),
        act=_act(lever if body else SLOTS[place]),
        windowed=True,
    )


def place_of(law: Law) -> str:
    """The place at which an unknown input shows a law best."""
    if law.place in BODIES:
        return f"{'moment' if law.motion == 'turn' else 'force'}_{law.place}"
    return {"tyres": "moment_car", DRAG: MOMENT, BALL: "force_trailer"}.get(law.place, law.place)


def missing_inputs(found: Discovery) -> dict[str, Any]:
    """The unknown input over time at the place of the law, and the variable of the law."""
    law = found.law
    place = place_of(law)
    without = tuple(t for t in found.fit.terms if t.effect.id != ID)
    fit = Fit(without, found.fit.nuisance, found.fit.shift)
    fitter = Fitter(replace(found.search.problem, observer=OBSERVER))
    missing = Locator(fitter, fit).course(
        free_input(place, found.term.as_dict().get("ahead_m", 0.0)),
        ridge=RIDGE, pulse_s=PULSE_S, held=True,
    )  # fmt: skip
    runs = []
    for index, run in enumerate(fitter.problem.runs):
        edges = missing.edges[index]
        middle = 0.5 * (edges[1:] + edges[:-1])
        moved = motion(found, index, law)
        bins = np.clip(np.searchsorted(edges, run.time, side="right") - 1, 0, middle.size - 1)
        count = np.maximum(np.bincount(bins, minlength=middle.size), 1)

        def mean(
            values: Array, bins: Any = bins, count: Any = count, size: int = middle.size
        ) -> list[float]:
            return list((np.bincount(bins, values, size) / count).astype(float))

        times = (
            motion(found, index, replace(law, motion=law.by, second="", by="", side=""))
            if law.by
            else None
        )
        law_there = None if moved is None else mean(valued(found, moved, run, times))
        value = missing.amplitude[index][:, 0]
        if law.motion == DISTANCE and law_there is not None:
            value = value + np.mean(law_there) - np.mean(value)  # a constant cannot be seen
        runs.append(
            {
                "run": run.name, "time_s": middle.tolist(), "value": value.tolist(),
                "standard_error": missing.error[index][:, 0].tolist(),
                "motion": None if moved is None else mean(moved),
                "law": law_there,
            }
        )  # fmt: skip
    unit = MOTIONS[law.motion].unit if law.motion in MOTIONS else ""
    return {"place": place, "unit": PLACES[place].unit, "motion_unit": unit, "runs": runs}


_COLUMNS = {
    "articulation": ("articulation",), "yaw_rate_car": ("car_yaw_rate",),
    "yaw_rate_trailer": ("trailer_yaw_rate",), "roll_car": ("car_roll",),
    "roll_trailer": ("trailer_roll",), "heading": ("trailer_yaw_rate",),  # its integral
    "heading_car": ("car_yaw_rate",), "lateral_acceleration_car": ("car_acceleration",),
    "lateral_acceleration_trailer": ("trailer_acceleration",), "hitch_force": ("hitch_y",),
}  # fmt: skip


def motion(found: Discovery, index: int, law: Law) -> Array | None:
    """The variable of a law in a run of the model, shape (n,); None: a state of its own."""
    if not law.has_gain:
        return None
    if law.second:
        each = [replace(law, motion=m, second="") for m in (law.motion, law.second)]
        alone = [motion(found, index, one) for one in each]
        share = found.term.as_dict()["second_share"]
        return np.tensordot((1.0, share), np.array(alone), 1)
    problem, fit = found.search.problem, found.fit
    plant = plant_of(problem, index, fit.terms, fit.nuisance[index], fit.shift)
    values = found.term.as_dict()
    lag_s = values.get("lag_s", RATE_S)
    given = {
        DISTANCE: driven(problem.runs[index]), "steer": plant.steer,
        "steer_rate": changed(plant.steer, lag_s) / lag_s,
    }  # fmt: skip
    if law.motion in given:
        return given[law.motion]
    if law.motion != THERE:
        return _simulated(law.motion, plant)
    parts = made_of(law, problem.runs[index], values).items()
    return np.asarray(sum(share * _simulated(name, plant) for name, share in parts))


def _simulated(name: str, plant: PlantInput) -> Array:
    """A motion that the plant makes, shape (n,)."""
    out = simulate(plant)
    column = {key: out[:, i] for i, key in enumerate(OUTPUT)}
    if name in _COLUMNS:
        course = np.asarray(column[_COLUMNS[name][0]])
        return np.cumsum(course) / RATE_HZ if name in HEADINGS else course
    if name == "articulation_rate":
        return np.asarray(column["trailer_yaw_rate"] - column["car_yaw_rate"])
    return _angle(name, plant, column)


def _angle(name: str, plant: PlantInput, column: Mapping[str, Array]) -> Array:
    """Side-slip angle of a body at its centre of gravity, or slip angle of its tyres, rad."""
    at = {key: plant.body[i] for i, key in enumerate(BODY)}
    side, rate = column["lateral_velocity"], column["car_yaw_rate"]
    name = "slip_trailer" if name == AXLES else name  # of every axle: shown at the trailer's
    if name in ("sideslip_car", "slip_car_front", "slip_car_rear"):
        ahead = {
            "sideslip_car": 0.0, "slip_car_front": at["car.front_axle_to_cog"],
            "slip_car_rear": -at["car.rear_axle_to_cog"],
        }[name]  # fmt: skip
        drift = np.arctan((side + ahead * rate) / plant.speed)
        return np.asarray(drift if name == "sideslip_car" else _steered(name, plant) - drift)
    ball = side - at["car.hitch_to_cog"] * rate
    sine, cosine = np.sin(column["articulation"]), np.cos(column["articulation"])
    along = cosine * plant.speed + sine * ball
    rate = column["trailer_yaw_rate"]
    across = cosine * ball - sine * plant.speed - at["trailer.hitch_to_cog"] * rate
    if name == "sideslip_trailer":
        return np.asarray(np.arctan(across / along))
    axles = [-at["trailer.rear_axle_to_cog"]]
    if at["trailer.front_cornering_stiffness"] > 0.0:
        axles.append(at["trailer.front_axle_to_cog"])
    return np.asarray(np.mean([-np.arctan((across + x * rate) / along) for x in axles], axis=0))


def _steered(name: str, plant: PlantInput) -> Array:
    """Steering angle of an axle of the car."""
    return plant.steer if name == "slip_car_front" else np.zeros_like(plant.steer)


def changed(z: Array, lag_s: float) -> Array:
    """What has changed within a lag, shape (n,): less its mean over the past."""
    kept = math.exp(-1.0 / (RATE_HZ * lag_s))
    return np.asarray(z - lfilter([1.0 - kept], [1.0, -kept], z))


def followed(z: Array, frequency_hz: float, damping_ratio: float) -> Array:
    """What an oscillator makes of a course, shape (n,)."""
    omega = 2.0 * math.pi * frequency_hz
    ahead, back = bilinear([omega**2], [1.0, 2.0 * damping_ratio * omega, omega**2], RATE_HZ)
    return np.asarray(lfilter(ahead, back, z))


def stretched(shape: str, z: Array, bend: float, lag_s: float) -> Array:
    """Deflection of a spring before a damper, which its force makes give way, shape (n,)."""
    span = np.linspace(-1.0, 1.0, 4001) * 2.0 * (np.max(np.abs(z)) + 1e-9)
    force = curve(shape, span, bend)
    state, share = 0.0, 1.0 - math.exp(-1.0 / (RATE_HZ * max(lag_s, 1e-3)))
    found = np.empty_like(z)
    for i, value in enumerate(z):
        found[i] = value - state
        state += share * float(np.interp(found[i], span, force))
    return found


def valued(found: Discovery, z: Array, run: Run, times: Array | None = None) -> Array:
    """The law over the course of its variable, and of what multiplies it, shape (n,)."""
    law = found.law
    values = found.term.as_dict()
    names = [stretch(each) for each in found.search.problem.runs]
    if law.response == PERIODIC:
        share = values["gain"] * (run.speed / SPEED_M_S) ** law.power
        share = share * course(run, values, names, half=one_way(law), raised=of_a_motion(law))
        return np.asarray(share if law.motion == DISTANCE else share * z)
    begun = since(run, values, names) if law.response == SUDDEN else np.ones(run.time.size)
    if law.motion == DISTANCE:
        return np.asarray(begun * values["gain"] * share_by_the_way(law, run, values))
    bend = bend_of(values)
    if law.motion in LAW_FELT:
        z = z - changed(z, values["lag_s"])
    if law.response == TRANSIENT:
        z = stretched(law.shape, z, bend, values["lag_s"])
    bent = amount(law.shape, z, values, bend)
    share = begun * share_by_the_way(law, run, values)
    force = bent * (run.speed / SPEED_M_S) ** law.power * share
    if times is not None:
        on = 0.5 + 0.5 * np.tanh(side_of(law) * times)
        force = force * (on if law.side in SIDES else sized(law, times, values))
    if law.response == LAGGED and values["lag_s"] > 0.0:
        force = force - changed(force, values["lag_s"])
    if law.response == OSCILLATING:
        force = followed(force, values["frequency_hz"], values["damping_ratio"])
    return np.asarray(force)
