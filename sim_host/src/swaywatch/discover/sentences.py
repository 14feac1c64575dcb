"""A law in words, and what is known to act in this way. The law is the finding, the name a hint."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from swaywatch.discover.effect import effect_of
from swaywatch.discover.forms import in_pieces
from swaywatch.discover.known import KNOWN
from swaywatch.discover.law import (
    BALL,
    BY_THE_WAY,
    CURVE,
    FADING,
    FALLING,
    FIFTHS,
    FRICTION,
    GROWING,
    INSTANT,
    LAGGED,
    LATE,
    LEVELS,
    LIMITED_RATE,
    LINE_AND_CUBE,
    LOST_MOTION,
    MOMENT,
    MOTIONS,
    NOTCHED,
    OSCILLATING,
    PERIODIC,
    PLACES,
    RATES,
    SIDES,
    SLIDING,
    STEPPED,
    STOPS,
    SUDDEN,
    SWITCHED,
    THERE,
    TRANSIENT,
    UNEVEN,
    WAITING,
    Law,
    Place,
    of_a_motion,
    one_way,
)
from swaywatch.discover.way import DISTANCE, DRAG, SPEED_M_S

#: Motions that a place works against: their product is power.
_WORKS = {
    "hitch": ("articulation", "articulation_rate", -1.0),
    "moment_car": ("", "yaw_rate_car", 1.0),
    "moment_trailer": ("", "yaw_rate_trailer", 1.0),
}
_OF_SLIP = {
    LAGGED: "wheels that turn after their slip, held by a damper: a self-steering axle",
    GROWING: "tyres that lose air, or wear; if they become stiffer, that grow warm",
    PERIODIC: "slabs, patches or joints of the road that grip more and less",
    FADING: "dirt or ice in the tread that is thrown off, tyres that grow warm",
    OSCILLATING: "wheels that swing after their slip: a self-steering axle without its damper",
}
_MORE = {side: f", only while that is {side.removesuffix(' side')}" for side in SIDES} | {
    "rubbing": ", against its rate at any speed of it (friction that grows with the deflection)"
}
_TYRES = {
    "axles": "all tyres as they come to a place", "slip_car_front": "the car's front tyres",
    "slip_car_rear": "the car's rear tyres", "slip_trailer": "the trailer's tyres",
}  # fmt: skip
_LOST = ("force_trailer", "lateral_acceleration_trailer", GROWING)
_AT_HITCH = {
    TRANSIENT: "a damper in elastic eyes",
    "play": "a damper whose eyes are worn: it resists once their play is used up",
    FADING: "friction or a damper that fades: pads that glaze, oil that grows hot",
    GROWING: "friction or a damper that works itself in",
}
_RUBS = {
    ("slip_car_front", "steer"): "friction in the steering: a strut mount or a joint that binds",
    ("slip_trailer", "hitch_force"):
        "a frame whose joints work: the ball twists it, with friction",
}  # fmt: skip
_DRY = Law("hitch", "articulation_rate", "saturating")
_PRESSED = {
    ("hitch", "articulation_rate", "hitch_force"):
        "friction that the force on the ball presses: a coupling without grease",
    **dict.fromkeys(
        (("hitch", "articulation_rate", motion)
         for motion in ("roll_trailer", "lateral_acceleration_trailer")),
        "friction that grows as the trailer leans: a coupling that jams on its ball",
    ),
}  # fmt: skip
AS_STEEP = 0.98  # of the steepest that a fit allows: as good as that
_UNITS = {"Nm": ("kNm", 1e-3), "N": ("kN", 1e-3), "rad": ("rad", 1.0)}


def suggestion(law: Law, gain: float) -> str:
    """What is known to act in this way; empty if nothing is, or where no form tells."""
    if law.shape == CURVE:
        return ""
    if law.place == BALL:
        cracked = "a crack at the drawbar or its coupling that opens to one side"
        return cracked if law.shape == UNEVEN else KNOWN[law.place, law.motion][0]
    pressed = _PRESSED.get((law.place, law.motion, law.times), "") or _of_a_lean(law)
    if law.response == SUDDEN:
        lasting = suggestion(replace(law, response=INSTANT), gain)
        return f"what breaks, sticks or comes loose{f': {lasting}' if lasting else ''}"
    special = pressed or _of_form(law, gain) or _at_hitch(law, gain)
    place = MOMENT if law.place == DRAG else law.place
    return special or KNOWN.get((place, law.motion), ("", ""))[gain < 0.0]


def _of_form(law: Law, gain: float) -> str:
    """What the form of a law alone makes likely."""
    if law.swings:
        return _moving_load(law)
    kinds = {
        LIMITED_RATE: "an actuator that can go no faster",
        WAITING: "a controller that waits for a swing to grow",
        LOST_MOTION: "a link with play",
        SWITCHED: "something that is switched on and off",
        STEPPED: "an actuator that moves in steps",
        NOTCHED: "something that snaps from notch to notch",
    }
    if law.motion == law.place and law.response in _OF_SLIP:
        return _OF_SLIP[law.response]
    if (law.place, law.motion, law.response) == _LOST:
        return "a load that is lost on the way" if gain > 0.0 else "a load that is taken up"
    if (law.place, law.response) == ("moment_trailer", TRANSIENT):
        return "a gyroscope, or a controller that leaves a steady turn alone"
    return _of_the_way(law) or _of_friction(law, gain) or kinds.get(law.shape, "")


def _of_the_way(law: Law) -> str:
    """What lies along the road, or binds on the way."""
    if law.motion == DISTANCE and law.power:
        return "water or wind on one side of the road"
    if of_a_motion(law) and law.motion.startswith("sideslip_"):
        return "wind in places: between cuttings, woods or houses"
    if law.motion != DISTANCE or law.place != DRAG:
        return ""
    soft = "a soft verge, or brakes that come and go"
    return soft if law.response == PERIODIC else "brakes on one side that bind"


def _of_a_lean(law: Law) -> str:
    """Tyres that hold less while a body leans on them."""
    leans = law.by.startswith(("roll_", "lateral_acceleration_"))
    if law.place != law.motion or not leans:
        return ""
    return "tyres that hold less as the body leans on them: bump stops, too little air"


def _of_friction(law: Law, gain: float) -> str:
    """What rubs there."""
    if replace(law, by="", side="") == _DRY and gain > 0.0:
        return "dry friction: of a ball, a stabiliser, a slewing ring"
    if law.shape == FALLING and law.motion in RATES:
        return "dry friction that falls as it slides faster"
    if law.shape not in FRICTION:
        return ""
    trailer = law.place == "slip_trailer"
    bushes = "axle compliance with friction: worn bushes" if trailer else ""
    return _RUBS.get((law.place, law.motion), bushes)


def _moving_load(law: Law) -> str:
    """What moves in a body otherwise than a pendulum."""
    in_trailer = law.place == "trailer"
    named = {
        SLIDING: f"a load that slides on the floor of the {law.place}",
        "odd square": "a liquid between baffles" if in_trailer else "a liquid in the car",
        "dead zone": "a load that rolls, slides or swings between stops",
        LOST_MOTION: "a load that slides until a net or a wall catches it",
        UNEVEN: "a load that is lashed on one side only",
        "rubbing": "a stack that leans and rubs in itself, sacks or bales",
    }
    if law.response == FADING:
        return "a load whose straps come loose"
    return named.get(law.shape, "") if law.motion == "swing" else ""


def _at_hitch(law: Law, gain: float) -> str:
    """What acts at the hitch otherwise than a spring or a damper."""
    if law.place != "hitch" or law.motion not in ("articulation", "articulation_rate"):
        return ""
    if law.response in _AT_HITCH:
        play = law.response == TRANSIENT and law.shape == "dead zone"
        return _AT_HITCH["play" if play else law.response]
    if law.shape == "dead zone":
        return "a stop: contact at large articulation"
    if law.shape in (*SIDES, *STOPS):
        rate = law.motion == "articulation_rate"
        return "a damper that resists one way only" if rate else "a chain or a stop on one side"
    if law.shape == "rubbing" and gain > 0.0:
        return "friction that grows with the articulation: a worn coupling"
    return ""


def energy(law: Law, gain: float) -> str:
    """Whether the law can supply energy to the motion."""
    if law.swings or law.place in (DRAG, BALL):
        own = "friction" if law.place == BALL else "its own damping"
        held = f"stores energy and dissipates it by {own}: passive"
        drags = "brakes the trailer: takes energy from the forward motion"
        return drags if law.place == DRAG else held
    if law.motion in (DISTANCE, law.place):
        grips = law.response == PERIODIC
        return {
            DISTANCE: "acts from outside, whatever the motion",
            law.place: "changes the grip of the tyres and adds no force of its own"
            if grips
            else "is a compliance under the tyre side force: passive",
        }[law.motion]
    stores, loses, sign = _WORKS.get(law.place, ("", "", 0.0))
    if law.motion == stores and law.shape == "rubbing":
        return (
            "dissipates energy of the motion: passive"
            if sign * gain < 0.0
            else "supplies energy to the motion, taken from the forward motion or from an actuator"
        )
    late = law.shape in (LIMITED_RATE, LOST_MOTION)
    at_once = law.response in (INSTANT, *BY_THE_WAY) and not (law.second or late)
    if law.motion == stores and at_once and not law.power and not law.by:
        return "stores energy and returns it: passive"
    scrubs = law.motion == THERE and gain < 0.0
    if law.shape != CURVE and at_once and (scrubs or (law.motion == loses and sign * gain < 0.0)):
        return "dissipates energy of the motion: passive"
    return "can supply energy to the motion, taken from the forward motion or from an actuator"


def sentence(law: Law, parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """The law in one sentence, with its values."""
    if law.swings:
        return _oscillation(law, parameters)
    if law.motion == "side_force":
        lever = parameters["lever_m"]
        side = "behind" if lever["value"] >= 0.0 else "ahead of"
        return f"the tyre side forces act {_range(lever, 1000.0)} mm {side} the wheel centres"
    if law.response == PERIODIC and law.motion == law.place:
        return _grip(law, parameters)
    if law.place == BALL:
        return _in_coupling(law, parameters)
    place, motion = PLACES[law.place], MOTIONS[law.motion]
    gain = parameters["gain"]
    unit, factor = _UNITS[place.unit]
    if place.unit != "rad" and abs(gain["value"]) < 500.0:
        unit, factor = place.unit, 1.0
    curve = {"cube": " cubed", "odd square": " squared, with its sign", "even square": " squared"}
    shape = curve.get(law.shape, "")
    order = "^" + ("3" if law.shape == "cube" else "2") if shape else ""
    per = motion.unit if not order else f"({motion.unit}){order}"
    words = f"{place.words}{_lever(parameters)}"
    if law.shape == CURVE:
        words += f", a curve of the {motion.words}: {_pieces(law, parameters, unit, factor)}"
    elif law.motion == DISTANCE:
        words += f": {_range(gain, factor)} {unit}, whatever the motion"
        words += "" if law.power else " and the speed"
    elif _steep(law, gain["value"]):
        words += f": {_of_one_size(law, parameters)}"
    else:
        words += f": {_range(gain, factor)} {unit} per {per} of the {motion.words}"
        words += _second(law, parameters) + shape
    words += "" if law.motion == DISTANCE else _shape(law, parameters)
    words += {
        -1: f", at {SPEED_M_S:g} m/s, inversely proportional to the speed",
        0: "" if law.motion == DISTANCE else ", independent of speed",
        1: f", at {SPEED_M_S:g} m/s, proportional to the speed",
        2: f", at {SPEED_M_S:g} m/s, proportional to the square of the speed",
    }[law.power]
    return words + _response(law, parameters)


def _steep(law: Law, gain: float) -> bool:
    """Whether it rises as steeply as the fit allows to a size: how steeply is not known."""
    known = effect_of(law).parameters[0]
    return law.shape == "saturating" and known.steepness and abs(gain) > AS_STEEP * known.high


def _of_one_size(law: Law, parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """The size of what is steep, and with the sign of what it goes."""
    size, motion = _limit(parameters, PLACES[law.place]), MOTIONS[law.motion]
    goes = motion.words + ("" if law.by else _second(law, parameters))
    size += _second(law, parameters).removeprefix(" and") if law.by else ""
    sign = "with" if parameters["gain"]["value"] > 0.0 else "against"
    whole = 2.0 * float(parameters["bend"]["value"])
    return f"{size}, {sign} the sign of the {goes}, all of it from {whole:.2g} {motion.unit} on"


def _pieces(law: Law, parameters: Mapping[str, Mapping[str, Any]], unit: str, factor: float) -> str:
    """A free curve by its values where its slope changes."""
    values = {name: float(row["value"]) for name, row in parameters.items()}
    z = values["bend"] * np.array([n / len(FIFTHS) for n in (*(-m for m in FIFTHS[::-1]), *FIFTHS)])
    there = zip(z, factor * in_pieces(z, values), strict=True)
    motion = MOTIONS[law.motion]
    points = ", ".join(f"{y:.2g} at {x:.2g}" for x, y in there)
    return f"{points} ({unit} at {motion.symbol} in {motion.unit})"


def _lever(parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """Where on a body a force acts that has a place of its own."""
    if "ahead_m" not in parameters:
        return ""
    x = parameters["ahead_m"]
    side = "ahead of" if x["value"] >= 0.0 else "behind"
    return f", {_range(dict(x) | {'value': abs(x['value'])})} m {side} its centre of gravity"


def _grip(law: Law, parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """What comes and goes along the road is the grip of tyres."""
    tyres = _TYRES[law.place]
    size = _range(parameters["gain"], 100.0)
    return f"the cornering stiffness of {tyres} {_comes(law)} by {size} %" + _response(
        law, parameters
    )


def _comes(law: Law) -> str:
    return "changes in places" if one_way(law) else "comes and goes"


def _second(law: Law, parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """What a second variable adds to a sentence."""
    if law.side in SIDES:
        return f", only while the {MOTIONS[law.by].words} is {law.side.removesuffix(' side')}"
    if law.by:
        by = MOTIONS[law.by]
        at = float(parameters["by_bend"]["value"]) if law.side else 0.0
        if law.side == LEVELS:
            return f", where the {by.words} is large: half of it at {at:.2g} {by.unit}"
        beyond = f" beyond {at:.2g} {by.unit}" if law.side == LATE else ""
        return f" and per {by.unit} of the size of the {by.words}{beyond}"
    if not law.second:
        return ""
    share, motion = parameters["second_share"], MOTIONS[law.second]
    sign = "plus" if share["value"] > 0.0 else "less"
    size = dict(share) | {"value": abs(share["value"])}
    return f" {sign} {_range(size)} times the {motion.words}"


def _response(law: Law, parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """What a lag adds to a sentence, or a washout, or the way."""
    if law.response in BY_THE_WAY:
        return _by_the_way(law, parameters)
    if law.response == PERIODIC:
        often = parameters["repetitions_per_km"]
        only = ", one way only, with nothing between" if one_way(law) else ""
        if of_a_motion(law):
            only = ", in places, with nothing between" if one_way(law) else ", coming and going"
        if "above" in parameters:
            share = 100.0 / math.pi * math.acos(min(parameters["above"]["value"], 1.0))
            way = "in places" if of_a_motion(law) else "one way only, in pulses"
            only = f", {way} over {share:.0f} % of the way"
        every = f"every {1000.0 / often['value']:.1f} m"
        return f"{only}, {_range(often)} times for each kilometre, {every}"
    if law.response == SUDDEN:
        return _from_then_on(parameters)
    if law.response == OSCILLATING:
        hz, ratio = parameters["frequency_hz"], max(parameters["damping_ratio"]["value"], 0.0)
        of = f"{_range(hz)} Hz with a damping ratio of {100.0 * ratio:.0f} %"
        return f", as an oscillator of its own of {of} follows it"
    if law.response == INSTANT and "lag_s" not in parameters:
        return ""
    lag = f"{1000.0 * parameters['lag_s']['value']:.0f} ms"
    return (
        f", {lag} lag"
        if law.response in (LAGGED, INSTANT)
        else f", only what has changed within {lag}"
    )


def _by_the_way(law: Law, parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """How far, or through which angle, what comes or fades takes."""
    growing = law.response == GROWING
    if "over_rad" in parameters:
        over = f"{parameters['over_rad']['value']:.2g} rad"
        half = "half of it" if growing else "half of it left"
        return f", {half} once the hitch has worked through {over}"
    over = f"{parameters['over_m']['value']:.0f} m"
    return f", {'two thirds of it' if growing else 'a third of it left'} after the first {over}"


def _from_then_on(parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """From which moment of each run on."""
    each = [row for name, row in parameters.items() if name.startswith("begins_")]
    at = [f"from {_range(row)} s of run {i + 1} on" for i, row in enumerate(each)]
    return f", {' and '.join(at)}" if at else ", from some moment on"


def _shape(law: Law, parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """What a shape adds to a sentence."""
    unit = MOTIONS[law.motion].unit
    at = f"{abs(parameters['bend']['value']):.3g} {unit}" if "bend" in parameters else ""
    limit = _limit(parameters, PLACES[law.place]) if "limit" in parameters else ""
    limit += f" per {MOTIONS[law.times].unit}" if law.times else ""
    again = f"{2.0 * math.pi * float(parameters.get('bend', {'value': 0.0})['value']):.3g}"
    if law.shape == UNEVEN:
        return f", {_range(parameters['other_side'])} times as much while that is negative"
    if law.shape == LINE_AND_CUBE:
        return _line_and_cube(law, parameters)
    return {
        "saturating": ""
        if _steep(law, parameters["gain"]["value"])
        else f", saturating at {limit}",
        "dead zone": f", only beyond {at}",
        WAITING: f", only while it swings beyond {at}",
        "hysteretic": f", sliding after {at} at {limit} (dry friction)",
        LIMITED_RATE: f", following it no faster than {at} a second",
        STOPS[0]: f", only while that is above {at}",
        STOPS[1]: f", only while that is below -{at}",
        LOST_MOTION: f", following it with a play of {at} either way",
        FALLING: f", {limit} where that is small, half of it at {at}",
        SWITCHED: f", nothing within {at}, {limit} beyond it",
        STEPPED: f", in steps of {at}",
        NOTCHED: f", up to {limit} to and fro, again every {again} {unit}",
    }.get(law.shape, _MORE.get(law.shape, ""))


def _line_and_cube(law: Law, parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """A line that grows steeper, or bends back and changes its sign."""
    steeper, unit = float(parameters["per_square"]["value"]), MOTIONS[law.motion].unit
    at = f"{1.0 / math.sqrt(max(abs(steeper), 1e-12)):.3g} {unit}"
    if steeper < 0.0:
        return f", less steep where that is large: none at {at}, the other way beyond"
    return f", steeper where that is large: twice as much at {at}"


def _oscillation(law: Law, parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """A mass that oscillates, in one sentence."""
    if law.slides:
        return _sliding(law, parameters)
    hz, ratio = parameters["frequency_hz"], parameters["damping_ratio"]
    much = f"a damping ratio of {100.0 * max(ratio['value'], 0.0):.0f} %"
    if law.motion == "turn":
        size = _range(parameters["inertia_kgm2"])
        return (
            f"a load with a yaw inertia of {size} kg m2 in the {law.place} oscillates about "
            f"the vertical axis at {_range(hz)} Hz with {much}"
        )
    mass, where = parameters["mass_kg"], _where(parameters)
    if "gap_m" in parameters:
        gap = 1000.0 * abs(parameters["gap_m"]["value"])
        less = _within_gap(parameters)
        where += f", {less} within {gap:.0f} mm either way"
    if "drag_per_m" in parameters:
        drag = max(parameters["drag_per_m"]["value"], 0.0)
        where += f", decelerated by {drag:.2g} 1/m times the square of its rate"
    if "rubbing_share" in parameters:
        share = 100.0 * parameters["rubbing_share"]["value"]
        slips = 1000.0 * parameters["slips_m"]["value"]
        where += f", {share:.0f} % of what holds it is friction that slips after {slips:.0f} mm"
    if law.shape == UNEVEN:
        where += _lashed(parameters)
    if law.response == FADING:
        where += _comes_loose(parameters)
    return (
        f"a mass of {_range(mass)} kg in the {law.place} oscillates laterally at "
        f"{_range(hz)} Hz with {much}{where}"
    )


def _within_gap(parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """How a mass moves in the gap between what holds it."""
    if "friction_m_s2" in parameters:
        return f"sliding on the floor (friction {_range(parameters['friction_m_s2'])} m/s2)"
    share = parameters["held_within"]["value"]
    return f"held {100.0 * share:.2g} % as stiffly" if share >= 0.005 else "free"


def _lashed(parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """Held otherwise to the right than to the left."""
    return f", held to the right {_range(parameters['other_side'])} times as stiffly as to the left"


def _comes_loose(parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """Held less and less, or more and more, on the way."""
    lost, over = parameters["lost"]["value"], parameters["over_m"]["value"]
    how = "less" if lost >= 0.0 else "more"
    share = f"{100.0 * abs(lost):.0f} % {how} stiffly in the end"
    return f", held {share}, two thirds of that after the first {over:.0f} m"


def _in_coupling(law: Law, parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """A ball that moves across its coupling, in one sentence."""
    soft = parameters["compliance"]
    if law.shape == LOST_MOTION:
        play = _range(parameters["play_m"], 1000.0)
        return f"the ball moves freely across its coupling by {play} mm either way"
    if law.shape == UNEVEN:
        return (
            f"the drawbar or its coupling gives way to the left by {_range(soft, 1e6)} mm per kN, "
            f"and is {_range(parameters['other_side'])} times as stiff to the right"
        )
    return (
        f"the ball gives way across its coupling by {_range(soft, 1e6)} mm per kN, with a dry "
        f"friction of {_range(parameters['friction_n'])} N"
    )


def _where(parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """Where a mass that moves is at rest."""
    x = parameters["position_m"]["value"]
    return f", {abs(x):.1f} m {'ahead of' if x >= 0.0 else 'behind'} the centre of gravity"


def _sliding(law: Law, parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """A mass that slides, in one sentence."""
    return (
        f"a mass of {_range(parameters['mass_kg'])} kg in the {law.place} slides laterally where "
        f"more than {_range(parameters['friction_m_s2'])} m/s2 acts on it{_where(parameters)}"
    )


def _limit(parameters: Mapping[str, Mapping[str, Any]], place: Place) -> str:
    """The value at which a law saturates, with its unit."""
    limit = parameters["limit"]
    unit, factor = _UNITS[place.unit]
    if abs(limit["value"]) * factor < 0.5:
        unit, factor = place.unit, 1.0
    return f"{_range(limit, factor)} {unit}"


def _range(row: Mapping[str, Any], factor: float = 1.0) -> str:
    """A value with half of its 90 % interval, to the digits that the interval supports."""
    value = factor * float(row["value"])
    half = 0.5 * abs(factor) * (float(row["high"]) - float(row["low"]))
    if not math.isfinite(half) or half <= 0.0:
        return f"{value:.3g}"
    digits = max(0, 1 - math.floor(math.log10(half)))
    return f"{value:.{digits}f} +- {half:.{digits}f}"
