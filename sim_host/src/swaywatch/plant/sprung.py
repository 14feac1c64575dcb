"""Springs, dampers and heights of car and trailer: what ``vehicle.toml`` does not say.

The ball's height over the two roll axes counts most for the critical speed (see DESIGN.md) and is
known least; it has a wide tolerance, which a fit may use.

Each value of the sprung plant has a rule that takes it from the vehicle's mass and wheelbase, the
tolerance of that rule and where both come from. A fit takes rule and tolerance as its belief; the
page shows them.

    scalars = neutral()
    put(scalars, defaults(body))
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swaywatch.plant.lanes import BODY, GRAVITY, SCALARS

Array = NDArray[np.float64]
Values = dict[str, float]


@dataclass(frozen=True)
class SprungValue:
    """A value that is believed until a recording says otherwise.

    Attributes
    ----------
    name : scalar slot of the plant
    unit : of the value
    rule : value from the combination's constants (`plant.lanes.BODY`) and the beliefs before it
    tolerance : standard deviation of the rule over vehicles, as a share of the value
    absolute : the same in `unit`, where a share makes no sense; else 0
    words : the rule in words
    source : where rule and tolerance come from
    """

    name: str
    unit: str
    rule: Callable[[Mapping[str, float], Mapping[str, float]], float]
    tolerance: float
    absolute: float
    words: str
    source: str

    def deviation(self, value: float) -> float:
        """Standard deviation in `unit` around a value."""
        return self.absolute if self.absolute > 0.0 else self.tolerance * abs(value)


_NHTSA = "Heydinger et al., SAE 1999-01-1336 (NHTSA, some 500 measured vehicles)"
_SSF = "NHTSA, Trends in the static stability factor, DOT HS 809 868: T/2h 1.41 cars, 1.17 SUV"
_REIMPELL = "Reimpell, Stoll, Betzler, The Automotive Chassis, 2nd ed. 2001"
_GILLESPIE = "Gillespie, Fundamentals of Vehicle Dynamics, SAE 1992, ch. 6"
_DIXON = "Dixon, The Shock Absorber Handbook, 2nd ed. 2007, ch. 1"
_CARAVAN = "range of European caravans and box trailers; no survey known, hence the tolerance"
_R55 = "UN ECE R55, annex 7: centre of the ball 350 to 420 mm over the road"
GRADIENT = {"car": 5.5, "trailer": 6.0}
"""deg per g of lateral acceleration: Gillespie gives 3 to 7 for cars."""
DAMPING = {"car": 0.25, "trailer": 0.2}
"""Damping ratio of roll."""


def _lever(name: str) -> Callable[[Mapping[str, float], Mapping[str, float]], float]:
    return lambda _, so_far: so_far[f"sprung_mass_{name}"] * so_far[f"sprung_height_{name}"]


def _stiffness(name: str) -> Callable[[Mapping[str, float], Mapping[str, float]], float]:
    """K from the roll gradient: phi (K - m_s g h) = m_s h a_y."""
    gradient = math.radians(GRADIENT[name]) / GRAVITY

    def rule(body: Mapping[str, float], so_far: Mapping[str, float]) -> float:
        lever = _lever(name)(body, so_far)
        return lever / gradient + lever * GRAVITY

    return rule


def _damping(name: str) -> Callable[[Mapping[str, float], Mapping[str, float]], float]:
    def rule(body: Mapping[str, float], so_far: Mapping[str, float]) -> float:
        lever = _lever(name)(body, so_far)
        inertia = so_far[f"roll_inertia_{name}"] + lever * so_far[f"sprung_height_{name}"]
        net = so_far[f"roll_stiffness_{name}"] - lever * GRAVITY
        return 2.0 * DAMPING[name] * math.sqrt(max(net, 0.0) * inertia)

    return rule


def _wheelbase(body: Mapping[str, float]) -> float:
    return body["car.front_axle_to_cog"] + body["car.rear_axle_to_cog"]


BELIEFS: tuple[SprungValue, ...] = (
    SprungValue("track_car_front", "m", lambda b, _: 0.57 * _wheelbase(b), 0.05, 0.0,
                "0.57 of the wheelbase", _NHTSA),
    SprungValue("track_car_rear", "m", lambda _, s: s["track_car_front"], 0.05, 0.0,
                "as at the front", _NHTSA),
    SprungValue("track_trailer", "m",
                lambda b, _: min(1.2 + 5e-4 * b["trailer.mass"], 2.1), 0.12, 0.0,
                "1.2 m and 0.5 m per 1000 kg, at most 2.1 m", _CARAVAN),
    SprungValue("wheel_radius", "m", lambda _b, _s: 0.31, 0.07, 0.0, "0.31 m", _REIMPELL),
    SprungValue("ball_height_car", "m", lambda _b, _s: 0.2, 0.0, 0.1,
                "0.2 m: ball at 0.4 m, roll axis rising to 0.1 to 0.3 m behind the rear axle",
                f"{_R55}; {_REIMPELL}"),
    SprungValue("ball_height_trailer", "m", lambda _b, _s: 0.2, 0.0, 0.15,
                "0.2 m: ball at 0.4 m, roll axis on the road with trailing arms, at 0.3 to "
                "0.4 m with a rigid axle", f"{_R55}; {_REIMPELL}"),
    SprungValue("sprung_mass_car", "kg", lambda b, _: 0.89 * b["car.mass"], 0.03, 0.0,
                "0.89 of the mass", _GILLESPIE),
    SprungValue("sprung_mass_trailer", "kg", lambda b, _: 0.92 * b["trailer.mass"], 0.03, 0.0,
                "0.92 of the mass", _CARAVAN),
    SprungValue("roll_axis_height_car", "m", lambda _b, _s: 0.08, 0.0, 0.05,
                "0.08 m: independent suspensions 0 to 0.15 m", _REIMPELL),
    SprungValue("roll_axis_height_trailer", "m", lambda _b, _s: 0.05, 0.0, 0.08,
                "0.05 m: trailing arms have it on the road, rigid axles at 0.3 m", _REIMPELL),
    SprungValue("sprung_height_car", "m",
                lambda _, s: 0.5 * s["track_car_front"] / 1.33 * 1.06 - s["roll_axis_height_car"],
                0.12, 0.0,
                "half the track over 1.33, 6 % for the wheels' share, over the roll axis",
                _SSF),
    SprungValue("sprung_height_trailer", "m",
                lambda _, s: 0.42 * s["track_trailer"] - s["roll_axis_height_trailer"],
                0.2, 0.0, "0.42 of the track, over the roll axis", _CARAVAN),
    SprungValue("roll_inertia_car", "kg m2",
                lambda _, s: s["sprung_mass_car"] * (0.37 * s["track_car_front"]) ** 2, 0.2, 0.0,
                "radius of gyration 0.37 of the track", _NHTSA),
    SprungValue("roll_inertia_trailer", "kg m2",
                lambda _, s: s["sprung_mass_trailer"] * (0.39 * s["track_trailer"]) ** 2, 0.3, 0.0,
                "radius of gyration 0.39 of the track", _CARAVAN),
    SprungValue("roll_stiffness_car", "N m/rad", _stiffness("car"), 0.3, 0.0,
                f"for {GRADIENT['car']:g} deg of roll per g", _GILLESPIE),
    SprungValue("roll_stiffness_trailer", "N m/rad", _stiffness("trailer"), 0.4, 0.0,
                f"for {GRADIENT['trailer']:g} deg of roll per g", _CARAVAN),
    SprungValue("roll_damping_rate_car", "N m s/rad", _damping("car"), 0.4, 0.0,
                f"damping ratio {DAMPING['car']:g}", _DIXON),
    SprungValue("roll_damping_rate_trailer", "N m s/rad", _damping("trailer"), 0.5, 0.0,
                f"damping ratio {DAMPING['trailer']:g}", _DIXON),
    SprungValue("roll_front_share_car", "1", lambda _b, _s: 0.55, 0.0, 0.07,
                "0.55: cars understeer by it", _REIMPELL),
    SprungValue("roll_front_share_trailer", "1", lambda _b, _s: 0.5, 0.0, 0.07,
                "0.5: equal axles", _CARAVAN),
    SprungValue("roll_damping_share_car", "1", lambda _b, _s: 0.5, 0.0, 0.1,
                "0.5: dampers of both axles alike, bars do not damp", _DIXON),
    SprungValue("roll_damping_share_trailer", "1", lambda _b, _s: 0.5, 0.0, 0.1,
                "0.5: equal axles", _CARAVAN),
    SprungValue("sensor_height_car", "m", lambda _, s: 0.45 - s["roll_axis_height_car"], 0.0, 0.15,
                "0.45 m over the road, less the roll axis", "tunnel or floor of the cabin"),
    SprungValue("sensor_height_trailer", "m", lambda _, s: 0.6 - s["roll_axis_height_trailer"],
                0.0, 0.2, "0.6 m over the road, less the roll axis", "floor of the trailer"),
    SprungValue("wind_height_car", "m", lambda _, s: s["sprung_height_car"], 0.0, 0.25,
                "at the sprung mass's centre of gravity", "side views of cars: 0.5 to 0.8 m"),
    SprungValue("wind_height_trailer", "m", lambda _, s: s["sprung_height_trailer"], 0.0, 0.4,
                "at the sprung mass's centre of gravity", "side views: 0.3 m loads "
                "to 1.4 m caravans"),
    SprungValue("sensed_roll_car", "1", lambda _b, _s: 1.0, 0.0, 0.0,
                "1: the accelerometer rolls with the body", "ISO 15037-1, 4.2: to be corrected"),
    SprungValue("sensed_roll_trailer", "1", lambda _b, _s: 1.0, 0.0, 0.0,
                "1: the accelerometer rolls with the body", "ISO 15037-1, 4.2: to be corrected"),
)  # fmt: skip
"""Every value of the sprung plant, in an order in which each rule knows what it needs."""

_INDEX = {name: index for index, name in enumerate(SCALARS)}


def defaults(body: Array, known: Mapping[str, float] | None = None) -> Values:
    """Values of the sprung plant for a combination.

    Parameters
    ----------
    body : constants in the order of `plant.lanes.BODY`; a car alone has a trailer of mass 0.
    known : values by slot that are better known; what depends on them follows them.

    Returns
    -------
    Value of every belief by the name of its slot.

    Raises
    ------
    ValueError
        ``known`` names what is no value of the sprung plant.
    """
    names = {belief.name for belief in BELIEFS}
    wrong = sorted(set(known or {}) - names)
    if wrong:
        raise ValueError(f"{wrong[0]!r} is no value of the sprung plant; they are: "
                         f"{', '.join(sorted(names))}")  # fmt: skip
    constants = dict(zip(BODY, (float(value) for value in body), strict=True))
    values: Values = {}
    for belief in BELIEFS:
        given = (known or {}).get(belief.name)
        values[belief.name] = belief.rule(constants, values) if given is None else float(given)
    return values


def tolerances(values: Mapping[str, float]) -> Values:
    """Standard deviation of every belief around its value, in its unit; 0: exact."""
    return {belief.name: belief.deviation(values[belief.name]) for belief in BELIEFS}


def put(scalars: Array, values: Mapping[str, float]) -> Array:
    """Write values by slot into scalar slots (`plant.lanes.SCALARS`); returns them."""
    for name, value in values.items():
        scalars[_INDEX[name]] = value
    return scalars
