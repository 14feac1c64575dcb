"""What the user of a generated case has and knows: vehicle, its tolerances, sensors, length.

Every case draws a tier, as the road recordings have them:

A vehicle known exactly, all sensors; B vehicle as users know it, all sensors; C exact, no force
sensors; D as users know it, no force sensors; E as users know it, the car's own sensors; F as users
know it, all sensors, bodies on springs with saturating, relaxing, load-sensitive tyres, gravity in
the accelerometers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from numpy.random import Generator

from swaywatch.models.multibody_vehicle import (
    GRAVITY,
    Axle,
    Body,
    Combination,
    Damper,
    reference_combination,
    static_loads,
)

TIERS = ("A", "B", "C", "D", "E", "F")
SHARES = (0.12, 0.3, 0.06, 0.1, 0.12, 0.3)
FORCES = (
    "FyFL", "FyFR", "FyRL", "FyRR", "FzFL", "FzFR", "FzRL", "FzRR", "HitchFx", "HitchFy",
)  # fmt: skip
#: Half the distance between the two halves of a single axle, m: rolls and steers as one.
HALF_M = 0.05
#: True over believed of what users know: uniform within; centres of gravity in m.
WITHIN = {"mass": 0.025, "yaw_inertia": 0.1, "cornering_stiffness": 0.08}
VALUES = ("mass", "yaw_inertia", "front_cornering_stiffness", "rear_cornering_stiffness")
COG_M = {"car": 0.03, "trailer": 0.05}
LOAD_SCALE = 0.01
USUAL_S = {"run1": 38.3, "run2": 36.3, "run3": 28.3}


@dataclass(frozen=True)
class Knowledge:
    """Of one case.

    Attributes
    ----------
    tier
        See the module.
    factors
        True over believed, by value of vehicle.toml.
    shift_m
        By how much the true centre of gravity of car and trailer lies ahead of the believed one.
    loads
        Measured over true, of the four axles.
    lengths_s
        Of the runs.
    """

    tier: str
    factors: dict[str, float]
    shift_m: dict[str, float]
    loads: tuple[float, float, float, float]
    lengths_s: dict[str, float]

    @property
    def sprung(self) -> bool:
        """Bodies on springs."""
        return self.tier == "F"

    @property
    def hidden(self) -> tuple[str, ...]:
        """Channels that are not recorded."""
        if self.tier in "CD":
            return FORCES
        return (*FORCES, "YawRate2", "LatAcc2") if self.tier == "E" else ()


def draw(rng: Generator, *, tier: str | None = None) -> Knowledge:
    """Tier, errors of what is believed, and how long is driven."""
    drawn = str(rng.choice(TIERS, p=SHARES))
    tier = tier or drawn
    kind = str(rng.choice(("usual", "short", "long"), p=(0.76, 0.12, 0.12)))
    lengths = dict(USUAL_S)
    if kind == "short":
        lengths |= {run: round(float(rng.uniform(8.0, 16.0)), 1) for run in ("run1", "run2")}
    elif kind == "long":
        lengths |= {run: round(float(rng.uniform(80.0, 300.0)), 1) for run in ("run1", "run2")}
    names = [
        f"{body}.{value}"
        for body in ("car", "trailer")
        for value in (
            "mass",
            "yaw_inertia",
            "front_cornering_stiffness",
            "rear_cornering_stiffness",
        )
    ]
    known = tier in "AC"
    factors, shift = {}, {}
    for name in names:
        size = next(v for k, v in WITHIN.items() if k in name)
        off = round(1.0 + float(rng.uniform(-size, size)), 4)
        factors[name] = 1.0 if known else off
    for body, size in COG_M.items():
        shift[body] = 0.0 if known else round(float(rng.uniform(-size, size)), 4)
    scale = 1.0 + (0.0 if known else LOAD_SCALE) * rng.standard_normal(4).clip(-2.0, 2.0)
    front, rear, first, second = map(float, scale)
    return Knowledge(tier, factors, shift, (front, rear, first, second), lengths)


def draw_combination(rng: Generator) -> Combination:
    """A passenger car and a caravan or a box trailer, on one axle or two."""
    reference = reference_combination()
    mass = float(rng.uniform(1250.0, 2250.0))
    base = 2.45 + 0.45 * (mass - 1250.0) / 1000.0 + float(rng.uniform(-0.1, 0.1))
    share = float(rng.uniform(0.49, 0.58))
    ahead, behind = base * (1.0 - share), base * share
    car = replace(
        reference.car,
        mass_kg=round(mass),
        yaw_inertia_kgm2=round(mass * ahead * behind * float(rng.uniform(0.82, 1.05))),
        hitch_to_cog_m=round(behind + float(rng.uniform(0.75, 1.05)), 3),
        front=_axle(reference.car.front, ahead, mass * share, float(rng.uniform(10.0, 14.0))),
        rear=_axle(
            reference.car.rear, -behind, mass * (1.0 - share), float(rng.uniform(16.0, 20.0))
        ),
    )
    car = _heavier(car, mass / reference.car.mass_kg)
    return _with_trailer(rng, replace(reference, car=car))


def _with_trailer(rng: Generator, whole: Combination) -> Combination:
    old = whole.trailer
    mass = max(700.0, whole.car.mass_kg * float(rng.uniform(0.55, 0.98)))
    length = float(rng.uniform(3.6, 5.3))
    nose = mass * GRAVITY * float(rng.uniform(0.03, 0.05))
    behind = nose * length / (mass * GRAVITY - nose)
    half = HALF_M if rng.random() < 0.5 else round(float(rng.uniform(0.3, 0.42)), 3)
    stiffness = float(rng.uniform(12.0, 16.0))
    axles = [
        _axle(axle, place, 0.5 * (mass - nose / GRAVITY), stiffness)
        for axle, place in ((old.front, half - behind), (old.rear, -half - behind))
    ]
    trailer = replace(
        old,
        mass_kg=round(mass),
        yaw_inertia_kgm2=round(mass * (length * float(rng.uniform(0.38, 0.48))) ** 2),
        hitch_to_cog_m=round(length, 3),
        front=axles[0],
        rear=axles[1],
    )
    ratio = round(float(rng.uniform(13.5, 17.5)), 2)
    return replace(
        whole,
        trailer=_heavier(trailer, mass / old.mass_kg),
        nose_load_n=round(nose),
        steering_ratio=ratio,
    )


def single_axle(whole: Combination) -> bool:
    """The trailer's two axles are halves of one."""
    front, rear = whole.trailer.front, whole.trailer.rear
    return math.isclose(front.to_cog_m - rear.to_cog_m, 2.0 * HALF_M, abs_tol=0.01)


def _axle(old: Axle, place: float, carried: float, per_newton: float) -> Axle:
    """At a place, with the stiffness of tyres that carry so much."""
    stiffness = round(carried * GRAVITY * per_newton, -2)
    return replace(old, to_cog_m=round(place, 3), cornering_stiffness_n_rad=stiffness)


def _heavier(body: Body, factor: float) -> Body:
    """Inertias against roll and pitch, springs, bars and dampers grow with the mass."""

    def axle(old: Axle) -> Axle:
        damper = replace(old.damper, coefficient_ns_m=old.damper.coefficient_ns_m * factor)
        return replace(
            old,
            spring_n_m=old.spring_n_m * factor,
            roll_bar_n_m=old.roll_bar_n_m * factor,
            damper=damper,
        )

    return replace(
        body,
        roll_inertia_kgm2=round(body.roll_inertia_kgm2 * factor),
        pitch_inertia_kgm2=round(body.yaw_inertia_kgm2 * 0.95),
        front=axle(body.front),
        rear=axle(body.rear),
    )


def on_springs(whole: Combination) -> Combination:
    """With dampers for bodies that heave, pitch and roll."""

    def axle(old: Axle, coefficient: float) -> Axle:
        return replace(old, damper=Damper("bilinear", coefficient))

    def body(old: Body, coefficient: float) -> Body:
        front, rear = axle(old.front, coefficient), axle(old.rear, coefficient)
        return replace(old, front=front, rear=rear)

    car = 1800.0 * whole.car.mass_kg / 1955.0
    trailer = 3000.0 * whole.trailer.mass_kg / 1880.0
    return replace(whole, car=body(whole.car, car), trailer=body(whole.trailer, trailer))


def vehicle_toml(true: Combination, known: Knowledge, user: dict[str, float]) -> str:
    """What the user believes; `user` are factors (true over believed) of effects."""
    lines = ["# What the user believes of this combination (SI units)."]
    loads = [load * scale for load, scale in zip(static_loads(true), known.loads, strict=True)]
    for number, (name, body) in enumerate((("car", true.car), ("trailer", true.trailer))):
        shift = known.shift_m[name]
        values = {
            "mass": body.mass_kg,
            "yaw_inertia": body.yaw_inertia_kgm2,
            "front_axle_to_cog": body.front.to_cog_m + shift,
            "rear_axle_to_cog": -(body.rear.to_cog_m + shift),
            "hitch_to_cog": body.hitch_to_cog_m + (-shift if name == "car" else shift),
            "front_cornering_stiffness": body.front.cornering_stiffness_n_rad,
            "rear_cornering_stiffness": body.rear.cornering_stiffness_n_rad,
        }
        if name == "car":
            values["steering_ratio"] = true.steering_ratio
        for key in values:
            full = f"{name}.{key}"
            values[key] /= known.factors.get(full, 1.0) * user.get(full, 1.0)
        values["front_axle_load"], values["rear_axle_load"] = loads[2 * number : 2 * number + 2]
        if name == "trailer":
            values = _trailer_axles(values, single=single_axle(true))
        lines.append(f"[{name}]")
        lines += [f"{key} = {float(f'{value:.6g}')}" for key, value in values.items()]
    return "\n".join(lines) + "\n"


def _trailer_axles(values: dict[str, float], *, single: bool) -> dict[str, float]:
    """Values of a trailer; one axle where it has but one."""
    if not single:
        return values
    middle = 0.5 * (values["rear_axle_to_cog"] - values["front_axle_to_cog"])
    out = {key: value for key, value in values.items() if not key.startswith("front_")}
    out["rear_axle_to_cog"] = middle
    for key in ("cornering_stiffness", "axle_load"):
        out[f"rear_{key}"] = values[f"front_{key}"] + values[f"rear_{key}"]
    return out
