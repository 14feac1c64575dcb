"""Damper fade, against the user's own simulation of a body with suspension.

A weak damper at one axle moves roll moment from it to the body's other axle, in phase with the
roll rate. Weak on one side only, it lifts and drops the axle's sum at the yaw frequency as well:
the body heaves until its springs carry what the damper no longer does, and below the frequency of
heave the axle's sum is the inertia of that heave, against the force that was lost.
How much load a whole damper pair carries per rate of load transfer (`ROLL_DAMPING_S`) was taken
from the practice case with a known fade.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.signal import hilbert

from swaywatch.effects.effect import Act, Array, Effect, Parameter, Values, Window
from swaywatch.effects.roll import ROLL_PARAMETERS, carried, changes
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput

#: Load moved by the dampers of one axle over the rate of the body's whole load transfer.
ROLL_DAMPING_S = 0.0076
OTHER = {
    "car_front": "car_rear", "car_rear": "car_front",
    "trailer_front": "trailer_rear", "trailer_rear": "trailer_front",
}  # fmt: skip
SIDES = {"both": 0.0, "left": -1.0, "right": 1.0}


def rate_of(run: Run, axle: str) -> Array:
    """Rate of the load transfer of the axle's body in the simulation, N/s, shape (n,)."""
    body = axle.split("_", maxsplit=1)[0]
    return run.simulated.get(f"shift_rate_{body}", np.zeros(run.time.size))


def rectified(run: Run, axle: str) -> Array:
    """Absolute roll rate without its mean, and its quadrature: complex, shape (n,)."""
    key = f"_rectified_{axle}"
    if key not in run.simulated:
        value = np.abs(rate_of(run, axle))
        run.simulated[key] = hilbert(value - value.mean())
    return run.simulated[key]


def side_effect(plant: PlantInput, run: Run, values: Values) -> None:
    """Stiffness of the car's rear axle under the changed loads, which the plant knows roughly."""
    constant = np.full(run.time.size, values["stiffness_share"])
    plant.add_series("stiffness_car_rear", constant)


def _act(axle: str, side: float) -> Act:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del windows
        lost = (1.0 - values["factor"]) * ROLL_DAMPING_S * rate_of(run, axle)
        share = 1.0 if side == 0.0 else 0.5
        plant.add_series(f"shift_{axle}", -0.5 * share * lost)
        plant.add_series(f"shift_{OTHER[axle]}", 0.5 * share * lost)
        side_effect(plant, run, values)
        if side:
            plant.add_series(f"heave_{axle}", side * values["heave"] * lost)

    return act


def _observe(axle: str) -> Callable[[dict[str, Array], Run, Values], None]:
    def observe(outputs: dict[str, Array], run: Run, values: Values) -> None:
        part = rectified(run, axle)
        outputs["hitch_vertical_force"] = (
            outputs["hitch_vertical_force"]
            + values["hitch_in_phase_s"] * part.real
            + values["hitch_quadrature_s"] * part.imag
        )

    return observe


def _act_whole(side: float) -> Act:
    """Dampers of all wheels of the trailer: its roll itself is damped less."""

    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del windows
        shift = run.simulated.get("shift_trailer", np.zeros(run.time.size))
        share = 1.0 if side == 0.0 else 0.5
        left = 1.0 - share * (1.0 - values["factor"])
        transfer, roll = changes(shift, values, damping=left)
        lost = (1.0 - values["factor"]) * ROLL_DAMPING_S * rate_of(run, "trailer")
        for end in ("front", "rear"):
            plant.add_series(f"shift_trailer_{end}", 0.25 * transfer)
            plant.add_series(f"slip_trailer_{end}", carried(roll, run.speed, values))
            if side:
                plant.add_series(f"heave_trailer_{end}", 0.5 * side * values["heave"] * lost)
        side_effect(plant, run, values)

    return act


def _report(values: Values) -> dict[str, float]:
    return {"factor": values["factor"]}


_FACTOR = Parameter("factor", "-", 1.0, 0.0, 1.0, (0.5,), 0.02, 0.15)
STIFFNESS = Parameter("stiffness_share", "-", 0.0, -0.03, 0.03, (0.0,), 0.001, 1e9)
_HITCH = (
    Parameter("hitch_in_phase_s", "s", 0.0, -0.1, 0.1, (0.0,), 1e-4, 1e9),
    Parameter("hitch_quadrature_s", "s", 0.0, -0.1, 0.1, (0.0,), 1e-4, 1e9),
    STIFFNESS,
)
_HEAVE = Parameter("heave", "-", 0.0, 0.05, 1.0, (0.2,), 0.02, 1e9)

EFFECTS = [
    Effect(
        id="damper_fade",
        component=axle,
        kind="physics",
        equation="roll moment of the axle's dampers falls to factor; the other axle takes it over",
        source="Table 6-1; balance of roll moments",
        parameters=(_FACTOR, *_HITCH) if side == "both" else (_FACTOR, *_HITCH, _HEAVE),
        act=_act(axle, SIDES[side]),
        observe=_observe(axle),
        lines=("f", "2f"),
        needs=("wheel_vertical_load_fl", "hitch_vertical_force"),
        decided_by="damper force or suspension travel",
        report=_report,
        extra={"needs_simulation": True, "follows_motion": True, "form": side, "side": side},
    )
    for axle in OTHER
    for side in SIDES
] + [
    Effect(
        id="damper_fade",
        component="trailer",
        kind="physics",
        equation="phi'' + factor 2 z w phi' + w^2 phi = M: load transfer and slip follow the roll",
        source="Table 6-1; balance of roll moments",
        parameters=(
            (_FACTOR, *_HITCH, *ROLL_PARAMETERS)
            if side == "both"
            else (_FACTOR, *_HITCH, *ROLL_PARAMETERS, _HEAVE)
        ),
        act=_act_whole(SIDES[side]),
        observe=_observe("trailer"),
        lines=("f", "2f"),
        needs=("wheel_vertical_load_fl", "hitch_vertical_force"),
        decided_by="damper force or suspension travel",
        report=_report,
        extra={"needs_simulation": True, "follows_motion": True, "form": side, "side": side},
    )
    for side in SIDES
]
