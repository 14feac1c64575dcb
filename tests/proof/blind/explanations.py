"""Effects of the package's library as what is concealed, and as what else could be claimed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Effect, Parameter, library
from swaywatch.effects.library.axle_load_harmonic import generator_effect

Json = dict[str, Any]
Windows = Sequence[tuple[int, tuple[float, float]]]
"""Run, and start and stop in it."""
AtStrength = Callable[[float], ActiveEffect]
"""A concealed effect at a share of its strength: 1 as it is, 0 none."""

CHANNELS = {
    "YawRate1": "car_yaw_rate", "LatAccRear1": "car_lateral_acceleration",
    "YawRate2": "trailer_yaw_rate", "LatAcc2": "trailer_lateral_acceleration",
    "HitchFy": "hitch_lateral_force",
}  # fmt: skip
FORMS = {"backlash": "backlash", "aligned": "against_force"}
BANK_RISE_S = 1.0
INPUTS = ("steering_wheel_angle", "speed")
#: Sizes of wrong effects over what a search starts from: small and typical.
SIZES = (0.1, 1.0)
#: Size, in scales, of what a search starts from none of.
SCALES = 15.0


def _of_library(effect_id: str, component: str, form: str = "") -> Effect:
    for effect in library():
        here = (effect.id, effect.component) == (effect_id, component)
        if here and form in ("", effect.extra.get("form")):
            return effect
    raise KeyError(f"no {effect_id} of {component} {form} in the library")


def concealed(truth: Json, windows: Windows, roll: Mapping[str, Any], loads: Json) -> AtStrength:
    """A concealed effect, in the words of the recordings' README, as one of the library.

    Parameters
    ----------
    windows
        Where it acts.
    roll
        Of a rigid body, that its accelerometer or axle follows: "gain_car" and "gain_trailer" in
        rad per m/s2, "frequency" in rad/s, "damping".
    loads
        Of a harmonic load: "harmonic", its windows with amplitude and phase, where they are known.
    """
    effect_id = truth["id"]
    if windows:
        return _in_windows(truth, windows, loads)
    values: dict[str, Callable[[float], tuple[float, ...]]] = {
        "steering_compliance": lambda s: (s / truth["stiffness_n_per_rad"],),
        "steering_free_play": lambda s: (s * truth["gap_deg"],),
        "tyre_relaxation": lambda s: (s * truth["length_m"],),
        # what a tyre loses of its force grows with the square of force over peak
        "tyre_saturation": lambda s: (truth["peak_friction"] / max(s, 1e-6) ** 0.5,),
        "tyre_load_sensitivity": lambda s: (s * truth["degression"], 1.0),
        "hitch_friction": lambda s: (s * truth["moment_nm"], 0.01),
        "hitch_damping": lambda s: (s * truth["coefficient_nms_per_rad"],),
        "trailer_aerodynamics": lambda s: (
            s * truth["side_force_coefficient"], s * truth["yaw_moment_coefficient"]
        ),
        "roll_steer": lambda s: (s * truth["coefficient"], roll["frequency"], roll["damping"]),
        "sensor_gain": lambda s: (1.0 + s * (truth["factor"] - 1.0),),
        "sensor_delay": lambda s: (s * truth["delay_s"],),
        "sensor_roll_gravity": lambda s: (
            s * truth["share_of_roll"] * roll[f"gain_{body}"], roll["frequency"], roll["damping"]
        ),
    }  # fmt: skip
    places = {
        "steering_compliance": "car_front", "steering_free_play": "steering",
        "tyre_saturation": "all", "tyre_load_sensitivity": "all", "hitch_friction": "hitch",
        "hitch_damping": "hitch", "trailer_aerodynamics": "trailer",
    }  # fmt: skip
    place = truth.get("axle") or CHANNELS.get(truth.get("channel", "")) or places[effect_id]
    body = place.partition("_")[0]
    form = FORMS[truth.get("law", "backlash")] if effect_id == "steering_free_play" else ""
    effect = _of_library(effect_id, place, form)
    return lambda s: ActiveEffect(effect, tuple(map(float, values[effect_id](s))))


def _in_windows(truth: Json, windows: Windows, loads: Json) -> AtStrength:
    effect, each = _each_window(truth, windows, loads)

    def at(s: float) -> ActiveEffect:
        values = [v for k, (_, window) in enumerate(windows) for v in (*window, *each(k, s))]
        return ActiveEffect(effect, tuple(map(float, values)), tuple(run for run, _ in windows))

    return at


def _each_window(
    truth: Json, windows: Windows, loads: Json
) -> tuple[Effect, Callable[[int, float], tuple[float, ...]]]:
    """An effect in windows, and its values in each of them at a share of its strength."""
    effect_id = truth["id"]
    if effect_id == "axle_load_harmonic" and "harmonic" in loads:
        known = [(w["amplitude_n"], np.radians(w["phase_deg"])) for w in loads["harmonic"]]
        return _of_library(effect_id, truth["axle"]), lambda k, s: (
            s * known[k][0] * np.cos(known[k][1]), s * known[k][0] * np.sin(known[k][1])
        )  # fmt: skip
    if effect_id == "axle_load_harmonic":
        of_run = [sum(1 for r, _ in windows[:k] if r == run) for k, (run, _) in enumerate(windows)]
        return generator_effect(truth["axle"]), lambda k, s: (
            s * truth["amplitude_n"][of_run[k]], truth["delay"][of_run[k]]
        )  # fmt: skip
    if effect_id == "tyre_stiffness_change":
        effect = _of_library(effect_id, truth["axle"])
        return effect, lambda _, s: (1.0 + s * (truth["factor"] - 1.0),)
    if effect_id == "crosswind_gust":
        return _of_library(effect_id, truth["body"], "box"), lambda _, s: (s * truth["force"],)
    form = "ramped_motion" if truth.get("sensing") == "motion" else "ramped"
    effect = _of_library(effect_id, "road", form)
    return effect, lambda _, s: (s * truth["angle_deg"], BANK_RISE_S)


def windows_of(terms: Sequence[ActiveEffect]) -> Windows:
    """Windows of all of these."""
    return [
        (run, (term.values[k * term.stride], term.values[k * term.stride + 1]))
        for term in terms
        for k, run in enumerate(term.window_runs)
    ]


def others(
    effects: Sequence[Effect], true: Sequence[ActiveEffect], channels: Sequence[str]
) -> dict[str, list[ActiveEffect]]:
    """What else could be claimed: by name and size, an effect for each of its free numbers.

    Effects in windows act where the true ones do, each window by itself; beside one that always
    acts they are left out. Wrong values of the file are for the caller.
    """
    windows = windows_of(true)
    found: dict[str, list[ActiveEffect]] = {}
    for effect in effects:
        if effect.id == "parameter_error" or effect.extra.get("needs_simulation"):
            continue
        if any(_same(term.effect, effect) for term in true) or (effect.windowed and not windows):
            continue
        if effect.kind == "measurement" and effect.component not in (*channels, *INPUTS):
            continue
        if not all(name in channels for name in effect.needs):
            continue
        for size in SIZES:
            some = [_moved(effect, p, size) for p in effect.parameters if not p.shapes]
            name = f"{effect.name} {effect.extra.get('form', '')}".strip()
            found[f"{name}, {size:g} of a start"] = [
                ActiveEffect(effect, (*edges, *values), runs)
                for values in some
                for runs, edges in (
                    [((run,), window) for run, window in windows] if effect.windowed else [((), ())]
                )
            ]
    return found


def _same(true: Effect, other: Effect) -> bool:
    """Of one id, and a place that is the other's or a part of it."""
    places = true.component in other.component or other.component in true.component
    return true.id == other.id and places


def _moved(effect: Effect, moved: Parameter, size: float) -> list[float]:
    """Values with one of the free numbers moved; those that only shape it as a search has them."""
    values = []
    for p in effect.parameters:
        start = p.starts[0] if p.shapes or p is moved else p.neutral
        if p is moved and p.name == "peak_friction":
            start = p.starts[0] / size
        elif p is moved:
            step = start - p.neutral
            start = p.neutral + size * (step if step != 0.0 else SCALES * p.scale)
        values.append(start)
    return values
