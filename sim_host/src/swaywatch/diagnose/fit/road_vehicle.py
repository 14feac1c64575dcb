"""What every road vehicle has and no vehicle.toml says: springs, roll, tyres that relax.

A vehicle whose bodies roll on springs couples roll with the lateral motion, its tyres build up
force over a length of road, and its accelerometers may see gravity. None of that is missing
physics of one vehicle: it is believed of all, with wide tolerances, and a fit finds how much.

Recordings of simulators without springs exist too. So there are two forms of the baseline, the
planar one and this; the evidence chooses.
"""

from __future__ import annotations

from dataclasses import replace

from swaywatch.diagnose.fit.beliefs import Array, Belief, wheels_of_trailer
from swaywatch.diagnose.fit.fit import Problem
from swaywatch.effects.effect import Effect
from swaywatch.plant import sprung

_DIXON = "Dixon, The Shock Absorber Handbook, 2nd ed. 2007: rebound to compression 1 to 4"
_RIDE = "Gillespie, Fundamentals of Vehicle Dynamics, ch. 5: 1 to 1.5 Hz"
_REIMPELL = "Reimpell, Stoll, Betzler, ch. 3.4: arms that turn with the body lean its forces"
_PACEJKA = "Pacejka, Tyre and Vehicle Dynamics, 3rd ed., ch. 7: 0.1 to 0.6 m at road loads"
_FRICTION = "dry road 0.85 to 1.2"
_SENSITIVE = "Reimpell, Stoll, Betzler: stiffness grows 3 to 12 % less than in proportion"
#: Value, relative tolerance and source of slots of the tyres.
TYRES: dict[str, tuple[float, float, str]] = {
    "relaxation_car_front": (0.3, 0.5, _PACEJKA),
    "relaxation_car_rear": (0.3, 0.5, _PACEJKA),
    "relaxation_trailer": (0.3, 0.5, _PACEJKA),
    "peak_friction_inverse": (1.0, 0.2, _FRICTION),
    "degression": (0.06, 0.6, _SENSITIVE),
}
_HUCHO = "Hucho, Aerodynamics of Road Vehicles, 4th ed.: 0.6 to 0.8 m2"
_TOWED = "low box trailers 0.7 m2, caravans in the wake of the car 1.5 to 3 m2"
_STATICS = "1 by statics; lift, and simulators whose axle loads do not follow the drive"
_DRIVEN = "front, rear or all wheels: not stated in vehicle.toml"
#: Drag and drive: value, tolerance in its unit, source; simulators leave them out.
ALONG: dict[str, tuple[float, float, str]] = {
    "drag_area_car": (0.7, 0.15, _HUCHO),
    "drag_area_trailer": (1.1, 0.5, _TOWED),
    "front_drive": (0.5, 0.4, _DRIVEN),
    "pitch_transfer": (1.0, 0.5, _STATICS),
}
#: How a body bounces that its dampers and struts lift and drop as it rolls; 0: taken as it is.
BOUNCE: dict[str, tuple[float, float, str]] = {
    "heave_frequency_car_front": (8.0, 0.2, _RIDE),
    "heave_frequency_car_rear": (8.4, 0.2, _RIDE),
    "heave_frequency_trailer": (9.5, 0.0, _RIDE),
    "heave_damping_car": (0.3, 0.4, _DIXON),
    "heave_damping_trailer": (0.3, 0.0, _DIXON),
}
#: What lifts it, which may be next to nothing: tolerances in the unit of the slot.
LIFT: dict[str, tuple[float, float, str]] = {
    "damper_asymmetry_car": (0.25, 0.2, _DIXON),
    "damper_asymmetry_trailer": (0.25, 0.2, _DIXON),
    "jacking_car": (0.5, 0.4, _REIMPELL),
    "jacking_trailer": (0.5, 0.4, _REIMPELL),
    "load_by_struts": (0.5, 0.5, "1 of a force between wheel and body, 0 of one at the wheel"),
}
#: What may be nothing, but not less. A side force that pulls a leaning body down is possible.
NEVER_LESS = (*ALONG, "damper_asymmetry_car", "damper_asymmetry_trailer")
#: Where an accelerometer is mounted, and whether its logger takes out what it sees of gravity.
SENSORS: dict[str, tuple[float, float, str]] = {
    "sensed_roll": (0.5, 1.0, "ISO 15037-1, 4.2 asks to correct it; not every logger does"),
    "sensor_height": (0.25, 1.0, "floor of the cabin or the trailer, or on the roll axis"),
}
_FREE = (
    "sprung_height", "roll_inertia", "roll_stiffness", "roll_damping_rate", "roll_axis_height",
    "ball_height", "wind_height",
)  # fmt: skip
#: Effects that are part of this form already.
WITHIN = (
    "tyre_relaxation", "tyre_saturation", "tyre_load_sensitivity", "sensor_roll_gravity",
    "roll_stiffness_change",
)  # fmt: skip


def _weighed(channels: tuple[str, ...]) -> bool:
    return any(name.startswith("wheel_vertical_load") for name in channels)


def values(body: Array, *, heaves: bool) -> dict[str, float]:
    """Slots of the plant for a vehicle on springs, by name; `heaves`: its dampers lift it."""
    found = dict(sprung.defaults(body))
    found |= {name: known[0] for name, known in TYRES.items()}
    found |= {name: known[0] for name, known in ALONG.items()}
    if heaves:
        found |= {name: known[0] for name, known in (BOUNCE | LIFT).items()}
    for slot, known in SENSORS.items():
        found |= {f"{slot}_{part}": known[0] for part in ("car", "trailer")}
    return found


def beliefs(body: Array, channels: tuple[str, ...]) -> list[Belief]:
    """Tolerances of those slots that a recording can say something about."""
    typical = {belief.name: belief for belief in sprung.BELIEFS}
    found = []
    for part in ("car", "trailer"):
        slots = [f"{slot}_{part}" for slot in _FREE]
        if part == "car" and _weighed(channels):
            slots += ["roll_front_share_car", "roll_damping_share_car"]
            slots += ["track_car_front", "track_car_rear"]
        if part == "trailer" and wheels_of_trailer(channels):
            slots += ["track_trailer", "roll_front_share_trailer", "roll_damping_share_trailer"]
        for name in slots:
            own = typical[name]
            signed = own.absolute > 0.0
            tolerance = own.absolute if signed else own.tolerance
            found.append(Belief("typical", name, tolerance, own.source, signed))
        if f"{part}_lateral_acceleration" in channels:
            for slot, (_, tolerance, source) in SENSORS.items():
                found.append(Belief("typical", f"{slot}_{part}", tolerance, source))
    known, in_its_unit = dict(TYRES), dict(ALONG)
    if _weighed(channels):
        known |= {name: own_ for name, own_ in BOUNCE.items() if own_[1] > 0.0}
        in_its_unit |= LIFT
    found += [Belief("typical", name, *own_[1:]) for name, own_ in known.items()]
    found += [Belief("typical", name, *own_[1:], signed=True) for name, own_ in in_its_unit.items()]
    return found


def on_springs(problem: Problem, *, heaves: bool = False) -> Problem:
    """The same runs and file, the baseline a road vehicle.

    Its dampers lift it where wheel loads show that, or where it `heaves` in any case.
    """
    channels = tuple(problem.channels(problem.runs[0]))
    items = [b for b in problem.beliefs.items if b.kind != "typical"]
    items += beliefs(problem.body, channels)
    return replace(
        problem,
        beliefs=replace(problem.beliefs, items=tuple(items)),
        given=tuple(values(problem.body, heaves=heaves or _weighed(channels)).items()),
    )


def pushing(problem: Problem, shift: Array) -> set[str]:
    """Slots that a fit has taken below nothing, which drag, drive and dampers cannot be."""
    given = dict(problem.given)
    return {
        belief.name
        for belief, z in zip(problem.beliefs.items, shift, strict=True)
        if belief.name in NEVER_LESS and given[belief.name] + z * belief.tolerance < 0.0
    }


def without(problem: Problem, names: set[str]) -> Problem:
    """The same with slots that are nothing, and exact."""
    items = tuple(b for b in problem.beliefs.items if b.name not in names)
    given = tuple((name, 0.0 if name in names else value) for name, value in problem.given)
    return replace(problem, beliefs=replace(problem.beliefs, items=items), given=given)


def outside(effects: list[Effect]) -> list[Effect]:
    """Effects that a road vehicle does not have anyway, as they are said beside one."""
    own = [effect for effect in effects if effect.id not in WITHIN]
    return [effect.on_springs or effect for effect in own]
