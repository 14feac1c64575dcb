"""A law as an effect of the plant: how it acts (slots `law_*`, `mode_*`, `trail_*`), its numbers.

Fitted and judged like any effect of the library.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from swaywatch.discover.ball import NO_STIFFNESS, moves_in_coupling
from swaywatch.discover.forms import formula, rubs_at_hitch, share_by_the_way
from swaywatch.discover.known import KNOWN
from swaywatch.discover.law import (
    ANYWHERE,
    BALL,
    BY_THE_WAY,
    CURVE,
    FADING,
    FALLING,
    GROWING,
    INSTANT,
    LAGGED,
    LATE,
    LEVELS,
    LIMITED,
    LIMITED_RATE,
    LINE_AND_CUBE,
    LOST_MOTION,
    MOMENT,
    MOTIONS,
    NOTCHED,
    OF_EACH_RUN,
    OSCILLATING,
    PERIODIC,
    PIECES,
    PLACES,
    ROLLS,
    SHAPES,
    SIDES,
    SIZES,
    SLIPS,
    STOPS,
    SUDDEN,
    SWITCHED,
    THERE,
    TRANSIENT,
    UNEVEN,
    Law,
    law_of,
    of_a_motion,
    one_way,
)
from swaywatch.discover.way import (
    DISTANCE,
    DRAG,
    NARROWEST,
    SLOTS,
    SPEED_M_S,
    begins,
    comes_and_goes,
    course,
    left,
    phases,
    set_drag,
    since,
)
from swaywatch.effects.effect import Act, Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import BODY, LAW_FELT, LAW_OF, PlantInput

Array = NDArray[np.float64]

ID = "law"
OF_A_SHAPE = ("bend", "other_side", "per_square")  # numbers that only a shape has
BENDS = (1, 2, 6, 10, 12, 14, 15, 16, 17, 18, 19, 20, 21)  # shapes with a bend
#: Shortest lag of what is felt, and of a rate; neutral, so that a law may have it.
AT_ONCE_S = 0.02
RATE_S = 0.05  # over which the rate of steering is taken, to begin with
ON_A_SIDE = 0.05  # of its usual size, from which on a motion is on one side
#: Half the log prior weight of a law without a known cause, see `Effect.plausibility`.
UNHEARD_OF = -1.0
#: Plant slots of motions that have none of their own.
MADE_OF = {
    "heading_car": {"heading": 1.0, "articulation": -1.0},
}
#: Lever at which an oscillating mass acts by its moment only, m.
FAR_M = 1000.0
ALONG_THE_ROAD = "comes and goes with the road: no single critical speed belongs to it"
MOST_DAMPED = 0.7  # damping ratio up to which it counts as oscillating: 5 % overshoot


def effect_of_form(form: str) -> Effect:
    """The effect that a model block names: of what goes along the road, where phases are unknown.

    It has a place for the phase of each run that it was found in, and does nothing in others.
    """
    law, _, tail = form.partition("@")
    found = law_of(law)
    unknown = int(tail) if found.response in OF_EACH_RUN and tail else 0
    return effect_of(found, runs=tuple(f"?{i}" for i in range(unknown)))


def _comes(law: Law, runs: tuple[str, ...] = ()) -> Act:
    """What does not depend on the motion enters where unknown forces do."""

    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del windows
        force = values["gain"] * share_by_the_way(law, run, values)
        force *= since(run, values, runs) if law.response == SUDDEN else 1.0
        force *= (run.speed / SPEED_M_S) ** law.power
        set_drag(plant, law.place)
        for slot, sign in SLOTS[law.place]:
            plant.add_series(slot, sign * force)

    return act


def bend_of(values: Values) -> float:
    """The number that a shape has beside its gain; 0 without one."""
    return next((values[name] for name in OF_A_SHAPE if name in values), 0.0)


def side_of(law: Law) -> float:
    """One over what it takes to be on the side on which a law acts, with its sign; 0: on both."""
    sign = {SIDES[0]: 1.0, SIDES[1]: -1.0}.get(law.side, 0.0)
    return sign / (ON_A_SIDE * MOTIONS[law.by].usual) if sign else 0.0


def made_of(law: Law, run: Run, values: Values) -> dict[str, float]:
    """Motions in the plant that make the first variable of a law, with their weights."""
    if law.motion == THERE:
        body = ANYWHERE[law.place]
        per_rate = values["ahead_m"] / float(np.mean(run.speed))
        return {f"sideslip_{body}": 1.0, f"yaw_rate_{body}": per_rate}
    if law.motion == "steer_rate":  # what has changed within a time
        return {"steer": 1.0 / values.get("lag_s", RATE_S)}
    return MADE_OF.get(law.motion, {law.motion: 1.0})


def acts_at(place: str, values: Values) -> dict[str, float]:
    """Places in the plant at which a law acts, with their weights (of moments: levers, m)."""
    if place not in ANYWHERE:
        return {MOMENT if place == DRAG else place: 1.0}
    body = ANYWHERE[place]
    return {f"force_{body}": 1.0, f"moment_{body}": values["ahead_m"]}


def _set_shape(plant: PlantInput, shape: str, values: Values) -> None:
    """The slots of a law's form."""
    plant.scalar("law_gain", 1.0 if shape == CURVE else values["gain"])
    plant.scalar("law_shape", float(SHAPES.index(shape)))
    plant.scalar("law_bend", bend_of(values))
    if shape == CURVE:
        for name in PIECES:
            plant.scalar(f"law_{'line' if name == 'gain' else name}", values[name])


def _share(law: Law, run: Run, values: Values, runs: tuple[str, ...]) -> Array:
    """Share of a law that acts at each time, of what does not act all the time, shape (n,)."""
    if law.response == SUDDEN:
        return since(run, values, runs)
    if law.response == PERIODIC:
        return course(run, values, runs, half=one_way(law), raised=True)
    return share_by_the_way(law, run, values)


def _moves(law: Law, runs: tuple[str, ...] = ()) -> Act:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del windows
        _set_shape(plant, law.shape, values)
        plant.scalar("law_speed_power", float(law.power))
        rate, felt = law.motion == "steer_rate", law.motion in LAW_FELT
        plant.scalar("law_lag", max(values.get("lag_s", RATE_S if rate else 0.0), 0.0))
        passing = 2.0 * (law.response == TRANSIENT)
        plant.scalar("law_transient", 1.0 if rate else 3.0 if felt else passing)
        if law.response == OSCILLATING:
            plant.scalar("law_transient", 4.0)
            plant.scalar("law_lag", 1.0 / (2.0 * math.pi * values["frequency_hz"]))
            plant.scalar("law_bend", values["damping_ratio"])
        if law.response in (*BY_THE_WAY, *OF_EACH_RUN):
            plant.add_series("law", _share(law, run, values, runs) - 1.0)
        for motion, share in made_of(law, run, values).items():
            plant.scalar(f"law_of_{motion}", share)
        if law.second:
            plant.scalar(f"law_of_{law.second}", values["second_share"])
        if law.by:
            plant.scalar("law_by", 1.0 + (*LAW_OF, *LAW_FELT).index(law.by))
            plant.scalar("law_by_side", side_of(law))
            late = -1.0 if law.side == LATE else 1.0
            plant.scalar("law_by_bend", late * values.get("by_bend", 0.0))
        set_drag(plant, law.place)
        for place, share in acts_at(law.place, values).items():
            plant.scalar(f"law_to_{place}", share)
        if "roll_frequency_rad_s" in values:
            body = law.motion.removeprefix("roll_")
            plant.scalar(f"steer_frequency_{body}", values["roll_frequency_rad_s"])
            plant.scalar(f"steer_damping_{body}", values["roll_damping"])

    return act


def _swings(law: Law) -> Act:
    """The oscillating mass is a part of the mass of its body: the total stays as weighed."""
    body = law.place

    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del windows
        if law.response == FADING:
            plant.add_series("law", -values["lost"] * (1.0 - left(run, values)))
        mass, place = values["mass_kg"], values["position_m"]
        whole = plant.body[BODY.index(f"{body}.mass")]
        rest = whole - mass
        # the centre of gravity of the rest is as far the other way as the masses say
        ahead = -mass * place / rest
        plant.scalar(f"mode_mass_{body}", mass)
        plant.scalar(f"mode_frequency_{body}", 2.0 * math.pi * values.get("frequency_hz", 0.0))
        plant.scalar(f"mode_damping_{body}", values.get("damping_ratio", 0.0))
        plant.scalar(f"mode_gap_{body}", abs(values.get("gap_m", 0.0)))
        plant.scalar(f"mode_within_{body}", values.get("held_within", 0.0))
        plant.scalar(f"mode_other_side_{body}", values.get("other_side", 1.0) - 1.0)
        plant.scalar(f"mode_drag_{body}", max(values.get("drag_per_m", 0.0), 0.0))
        plant.scalar(f"mode_friction_{body}", max(values.get("friction_m_s2", 0.0), 0.0))
        plant.scalar(f"mode_rubbing_{body}", values.get("rubbing_share", 0.0))
        plant.scalar(f"mode_slips_{body}", max(values.get("slips_m", 0.0), 0.0))
        plant.scalar(f"mode_place_{body}", place - ahead)
        plant.scalar(f"sensor_ahead_{body}", -ahead)
        plant.body[BODY.index(f"{body}.mass")] = rest
        plant.body[BODY.index(f"{body}.yaw_inertia")] -= mass * place**2 + rest * ahead**2
        hitch = ahead if body == "car" else -ahead
        plant.body[BODY.index(f"{body}.front_axle_to_cog")] -= ahead
        plant.body[BODY.index(f"{body}.rear_axle_to_cog")] += ahead
        plant.body[BODY.index(f"{body}.hitch_to_cog")] += hitch
        sprung = plant.get(f"sprung_mass_{body}")
        if sprung > 0.0:
            plant.scalar(f"sprung_mass_{body}", sprung - mass)

    return act


def _loose(law: Law) -> Act:
    """A mass that swings, once all has gone that is lost on the way of what holds it."""
    swings = _swings(replace(law, response=INSTANT))

    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        held = math.sqrt(max(1.0 - values["lost"], 1e-6))
        now = {
            "frequency_hz": held * values["frequency_hz"],
            "damping_ratio": values["damping_ratio"] / held,
        }
        swings(plant, run, dict(values) | now, windows)

    return act


def _turns(body: str) -> Act:
    """The oscillating inertia is a part of the yaw inertia of its body."""

    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del run, windows
        inertia = values["inertia_kgm2"]
        plant.scalar(f"mode_mass_{body}", inertia / FAR_M**2)
        plant.scalar(f"mode_place_{body}", FAR_M)
        plant.scalar(f"mode_frequency_{body}", 2.0 * math.pi * values["frequency_hz"])
        plant.scalar(f"mode_damping_{body}", values["damping_ratio"])
        plant.body[BODY.index(f"{body}.yaw_inertia")] -= inertia

    return act


def _lever(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del run, windows
    for axle in ("car_front", "car_rear", "trailer"):
        plant.scalar(f"trail_{axle}", values["lever_m"])


def effect_of(
    law: Law, start_hz: float | None = None, *, sprung: bool = False, runs: tuple[str, ...] = ()
) -> Effect:
    """The law as an effect of the plant, fitted and judged like any other.

    Parameters
    ----------
    start_hz
        For an oscillating mass: the initial frequency of the fit.
    sprung
        Whether the vehicle rolls on springs; one without has a roll of its own for a law of it.
    runs
        Names of the runs, for what comes and goes along the road, or begins on the way: each has a
        phase or a moment of its own. The one does nothing in others, the other one all the time.
    """
    return _effect(law, start_hz, sprung, runs)


@cache
def _effect(law: Law, start_hz: float | None, sprung: bool, runs: tuple[str, ...]) -> Effect:
    act: Act
    parameters: tuple[Parameter, ...]
    if law.swings:
        act, parameters, equation = _with_a_frequency(law, start_hz or 0.8)
    elif law.place == BALL:
        act, parameters, equation = moves_in_coupling(law)
    elif law.motion == "side_force":
        act = _lever
        parameters = (Parameter("lever_m", "m", 0.0, -0.15, 0.15, (0.03,), 0.005, 0.003),)
        equation = "M = -lever x side force, of each tyre"
    else:
        act = _comes(law, runs) if law.motion == DISTANCE else _moves(law, runs)
        parameters = _numbers(law)
        if law.response == SUDDEN:
            parameters = (*parameters, *begins(runs))
        if law.response == PERIODIC:
            parameters = (*parameters, *phases(runs))
        if law.response == PERIODIC and not of_a_motion(law):
            grip, half = law.motion == law.place, one_way(law)
            act = comes_and_goes(law.place, runs, law.power, grip=grip, half=half)
        if law.motion in ROLLS and not sprung:
            parameters = (*parameters, *OWN_ROLL[law.motion])
        equation = formula(law)
    return Effect(
        id=ID,
        component=f"{law.place} of {' and '.join(filter(None, (law.motion, law.second, law.by)))}",
        kind="physics",
        equation=equation,
        source="identified from the recording",
        parameters=parameters,
        act=act,
        report=_with_limit
        if law.shape in (*LIMITED, FALLING, SWITCHED, NOTCHED) and law.has_gain
        else dict,
        plausibility=0.0 if (law.place, law.motion) in KNOWN else UNHEARD_OF,
        decided_by="the same manoeuvre at another speed and another amplitude",
        extra={
            "form": law.spec + (f"@{start_hz:g}" if start_hz else f"@{len(runs)}" if runs else ""),
            "law": law,
            "runs": runs,
            "located": tuple(p.name for p in (*begins(runs), *phases(runs))),
            "start_hz": start_hz,
            "imitated_on_springs": True,
        }
        | ({"possible": _can_swing} if law.swings and not law.slides else {})
        | _costs(law),
    )


def _costs(law: Law) -> dict[str, object]:
    """What the cost of a law is asked with: what acts at its largest, or why it has none."""
    if law.response == PERIODIC:
        return {"no_cost": ALONG_THE_ROAD}
    if law.place == BALL and law.shape == LOST_MOTION:
        return {"no_cost": NO_STIFFNESS}
    if law.motion == DISTANCE:
        return {"from_outside": True}
    if law.swings and law.response == FADING:
        return {"at_its_largest": _loose(law)}
    if law.response in (*BY_THE_WAY, SUDDEN):
        return {"at_its_largest": _moves(replace(law, response=INSTANT))}
    return {}


def _with_a_frequency(law: Law, at: float) -> tuple[Act, tuple[Parameter, ...], str]:
    """Act, parameters and equation of an oscillating mass, with its initial frequency."""
    swings = (
        Parameter("frequency_hz", "Hz", at, 0.15, 4.0, (at,), 0.03, 1e9),
        Parameter("damping_ratio", "1", 0.05, 0.0, 1.5, (0.05,), 0.02, 1e9),
    )
    if law.motion == "turn":
        size = Parameter("inertia_kgm2", "kg m2", 0.0, 0.0, 3000.0, (150.0,), 25.0, 5.0)
        equation = "I (q'' + 2 zeta omega q' + omega^2 q) = -I r'"
        return _turns(law.place), (size, *swings), equation
    mass = Parameter("mass_kg", "kg", 0.0, 0.0, 900.0, (60.0,), 10.0, 2.0)
    place = Parameter("position_m", "m", 0.0, -4.0, 4.0, (0.0,), 0.05, 1e9)
    if law.slides:
        rubs = Parameter("friction_m_s2", "m/s2", 1e3, 0.02, 20.0, (1.0, 0.4, 2.0), 0.05, 1e9)
        equation = "m q'' = -m a_y of its place - m friction sign(q')"
        return _swings(law), (mass, place, rubs), equation
    found: tuple[Parameter, ...] = (mass, *swings, place)
    held, drag = "q", ""
    if law.shape == "dead zone":
        within = Parameter("held_within", "1", 0.0, 0.0, 1.0, (0.1,), 0.02, 1e9)
        found = (*found, within, Parameter("gap_m", "m", 0.01, 0.0, 0.3, (0.01,), 0.003, 1e9))
        held = "(q beyond +-gap, by held_within of it within)"
    if law.shape == LOST_MOTION:
        rubs = Parameter("friction_m_s2", "m/s2", 0.0, 0.0, 20.0, (0.5,), 0.05, 1e9)
        found = (*found, Parameter("gap_m", "m", 0.01, 0.0, 0.5, (0.03,), 0.005, 1e9), rubs)
        held, drag = "(q beyond +-gap)", " + friction sign(q')"
    if law.shape == "odd square":
        found = (*found, Parameter("drag_per_m", "1/m", 0.0, 0.0, 100.0, (3.0,), 0.3, 1e9))
        drag = " + drag |q'| q'"
    if law.shape == "rubbing":
        slips = Parameter("slips_m", "m", 1e3, 0.001, 0.5, (0.02,), 0.003, 1e9)
        share = Parameter("rubbing_share", "1", 0.0, 0.0, 1.0, (0.4,), 0.03, 1e9)
        found, held = (
            (*found, slips, share),
            "(q (1 - share) + share z, dz/dt = q' - |q'| z / slips)",
        )
    if law.shape == UNEVEN:
        side = Parameter("other_side", "1", 1.0, 0.0, 8.0, (0.4, 2.5), 0.05, 1e9)
        found, held = (*found, side), "(q, on the right times the other side)"
    if law.response == FADING:
        found = (*found, *_of_way(law), Parameter("lost", "1", 0.0, -3.0, 1.0, (0.5,), 0.05, 1e9))
        held = "q (1 - lost (1 - exp(-way / over)))"
    equation = f"m (q'' + 2 zeta omega q'{drag} + omega^2 {held}) = -m a_y of its place"
    return _swings(law), found, equation


def _with_limit(values: Values) -> dict[str, float]:
    """Values with the one at which the law saturates."""
    return dict(values) | {"limit": abs(values["gain"] * values["bend"])}


def _can_swing(values: Values) -> bool:
    """Overdamped is not oscillating: a load or a liquid passes its rest position."""
    return values["damping_ratio"] < MOST_DAMPED


#: As of the library's roll steer: roll is not recorded, and a rigid vehicle has none.
OWN_ROLL = {
    motion: (
        Parameter("roll_frequency_rad_s", "rad/s", hz, 4.0, 40.0, (hz,), 0.2, 1e9),
        Parameter("roll_damping", "1", ratio, 0.03, 1.5, (ratio,), 0.02, 1e9),
    )
    for motion, hz, ratio in (("roll_car", 13.0, 0.112), ("roll_trailer", 9.0, 0.3))
}


def _numbers(law: Law) -> tuple[Parameter, ...]:
    """Numbers of a law, scaled by its dimensions; the gain is the first one."""
    second = (_second_share(law),) if law.second else ()
    size = (_of_size(law),) if law.side in SIZES else ()
    return (_gain(law), *_of_shape(law), *_of_way(law), *second, *size, *_of_place_and_lag(law))


def _gain(law: Law) -> Parameter:
    """Gain of a law."""
    place, motion = PLACES[law.place], MOTIONS[law.motion]
    curve = {"cube": 3, "odd square": 2, "even square": 2}.get(law.shape, 1)
    start = place.level / motion.usual**curve
    unit = f"{place.unit} per {motion.unit}" + (f"^{curve}" if curve > 1 else "")
    unit = place.unit if law.motion == DISTANCE else unit
    if law.times:
        start /= MOTIONS[law.times].usual
        unit += f" per {MOTIONS[law.times].unit}"
    if law.motion == law.place:  # the compliance of a wheel is at most its slip
        most = 1.0 / MOTIONS[law.times].usual if law.times else 1.0
        low, high, start, step, noticed = {
            GROWING: (-0.9, 1.0, -0.2, 0.05, 0.02),
            PERIODIC: (-0.95 * one_way(law), 0.95, 0.2, 0.05, 0.02),
        }.get(law.response, (-1.0, 0.0, -0.5, 0.1, 0.1))
        low, high, start, step, noticed = (most * x for x in (low, high, start, step, noticed))
        return Parameter("gain", unit, 0.0, low, high, (start,), step, noticed)
    high, levels_off = 100.0 * start, law.shape in (*LIMITED, FALLING)
    return Parameter(
        "gain", unit, 0.0, -high, high, (start,), 0.2 * start, 0.02 * start, levels_off
    )


def _of_shape(law: Law) -> list[Parameter]:
    """The number that a shape has."""
    motion = MOTIONS[law.motion]
    if law.response == PERIODIC:
        above = Parameter("above", "1", 0.0, 0.0, NARROWEST, (0.5,), 0.03, 1e9)
        return [above] if law.shape == STOPS[0] else []
    if law.shape == UNEVEN:
        return [Parameter("other_side", "1", 1.0, -2.0, 3.0, (0.5,), 0.1, 1e9)]
    if law.shape == LINE_AND_CUBE:
        most = 1.0 / motion.usual**2
        bounds = -50.0 * most, 50.0 * most, (-0.5 * most,)
        return [Parameter("per_square", f"1/({motion.unit})^2", 0.0, *bounds, 0.1 * most, 1e9)]
    if SHAPES.index(law.shape) not in BENDS:
        return []
    share = {"saturating": 0.5, LIMITED_RATE: 2.0, LOST_MOTION: 0.1, CURVE: 1.0, NOTCHED: 0.05}.get(
        law.shape, 0.3
    )
    bend, per_s = share * motion.usual, "/s" if law.shape == LIMITED_RATE else ""
    bounds = 0.02 * bend, 20.0 * bend, (bend,)
    found = [Parameter("bend", motion.unit + per_s, 1e3, *bounds, 0.1 * bend, 1e9)]
    if law.shape == CURVE:
        found += [replace(_gain(law), name=name) for name in PIECES[1:]]
    return found


def _of_way(law: Law) -> list[Parameter]:
    """How far, or through which angle, what grows or fades takes."""
    if law.response not in BY_THE_WAY:
        return []
    if rubs_at_hitch(law):
        return [Parameter("over_rad", "rad", 1e3, 0.02, 50.0, (0.5,), 0.05, 1e9)]
    return [Parameter("over_m", "m", 1e6, 20.0, 2e4, (250.0,), 30.0, 1e9)]


def _of_place_and_lag(law: Law) -> list[Parameter]:
    """A lever, where a force has a place of its own, and a lag."""
    found = []
    if law.place in ANYWHERE:
        found.append(Parameter("ahead_m", "m", 0.0, -5.0, 5.0, (2.5,), 0.1, 1e9))
    if law.motion in LAW_FELT:
        found.append(Parameter("lag_s", "s", AT_ONCE_S, AT_ONCE_S, 1.5, (0.06,), 0.01, 1e9))
    elif law.motion == "steer_rate":
        found.append(Parameter("lag_s", "s", AT_ONCE_S, AT_ONCE_S, 0.5, (RATE_S,), 0.01, 1e9))
    elif law.response == LAGGED:
        late = 0.4 if law.motion in SLIPS else 0.1  # a shorter one of a slip is a relaxation
        found.append(Parameter("lag_s", "s", 0.0, 0.0, 1.5, (late,), 0.01, 1e9))
    elif law.response == OSCILLATING:
        found.append(Parameter("frequency_hz", "Hz", 1e3, 0.2, 5.0, (1.2,), 0.05, 1e9))
        found.append(Parameter("damping_ratio", "1", 1.0, 0.0, 2.0, (0.3,), 0.03, 1e9))
    elif law.response == TRANSIENT:
        found.append(Parameter("lag_s", "s", 1e3, 0.02, 3.0, (0.3,), 0.03, 1e9))
    return found


def _of_size(law: Law) -> Parameter:
    """The size at which half of a law acts that levels off, or beyond which another one does."""
    motion = MOTIONS[law.by]
    at = 0.5 * motion.usual
    none = 1e3 if law.side == LEVELS else 0.0
    return Parameter("by_bend", motion.unit, none, 0.02 * at, 20.0 * at, (at,), 0.1 * at, 1e9)


def _second_share(law: Law) -> Parameter:
    """Weight of the second motion of a law: in a test drive as much as the first, to begin with."""
    first, second = MOTIONS[law.motion], MOTIONS[law.second]
    usual = first.usual / second.usual
    unit = f"{first.unit} per {second.unit}"
    return Parameter("second_share", unit, 0.0, -20 * usual, 20 * usual, (usual,), 0.2 * usual, 1e9)
