"""Damper fade, against the user's own simulation of a body with suspension.

A weak damper at one axle moves roll moment from it to the body's other axle, in phase with the
roll rate, and damps the roll less. Weak on one side only, it lifts and drops the body at the yaw
frequency as well.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.signal import hilbert

from swaywatch.effects.effect import Act, Array, Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput

#: Axles of each place that dampers are at.
AXLES = {
    "car_front": ("car_front",), "car_rear": ("car_rear",),
    "trailer_front": ("trailer_front",), "trailer_rear": ("trailer_rear",),
    "trailer": ("trailer_front", "trailer_rear"),
}  # fmt: skip
SIDES = {"both": ("left", "right"), "left": ("left",), "right": ("right",)}


def _swinging(run: Run, body: str, *, rectified: bool) -> Array:
    """Roll rate of the body, or its size, without its mean, and its quadrature: complex, (n,)."""
    key = f"_{body}_{'rectified' if rectified else 'rolling'}"
    if key not in run.simulated:
        rate = run.simulated[f"{body}_roll_rate"]
        rate = np.abs(rate) if rectified else rate
        run.simulated[key] = hilbert(rate - rate.mean())
    return run.simulated[key]


def observe_hitch(
    place: str, side: str = "both"
) -> Callable[[dict[str, Array], Run, Values], None]:
    """The hitch's vertical force follows the heave of the body, which the plant does not say.

    At twice the frequency of the roll or, where the two sides differ, at the frequency itself.
    """
    body = place.split("_", maxsplit=1)[0]

    def observe(outputs: dict[str, Array], run: Run, values: Values) -> None:
        part = _swinging(run, body, rectified=side == "both")
        outputs["hitch_vertical_force"] = (
            outputs["hitch_vertical_force"]
            + values["hitch_in_phase_ns_rad"] * part.real
            + values["hitch_quadrature_ns_rad"] * part.imag
        )

    return observe


def side_effect(plant: PlantInput, run: Run, values: Values) -> None:
    """Stiffness of the car's rear axle under the changed loads, which the plant knows roughly."""
    constant = np.full(run.time.size, values["stiffness_share"])
    plant.add_series("stiffness_car_rear", constant)


_FACTOR = Parameter("factor", "-", 1.0, 0.0, 1.0, (0.5,), 0.02, 0.15)
#: Of the body over the axle, which a weak damper on one side lifts and drops.
_HEAVE = Parameter("heave_rad_s", "rad/s", 8.0, 4.0, 14.0, (7.0,), 0.1, 1e9)
#: How much of the roll damping an axle's dampers give is known from the simulation's motion alone:
#: in five cases of Project Chrono the loss came out 1 % too large to 25 % too small.
ASSUMED_SHARE = 0.3
#: What a change of a suspension does beside that the plant knows only roughly: fitted with it.
ASIDE = (
    Parameter("hitch_in_phase_ns_rad", "N s/rad", 0.0, -2e4, 2e4, (0.0,), 20.0, 1e9),
    Parameter("hitch_quadrature_ns_rad", "N s/rad", 0.0, -2e4, 2e4, (0.0,), 20.0, 1e9),
    Parameter("stiffness_share", "-", 0.0, -0.03, 0.03, (0.0,), 0.001, 1e9),
)


def _act(place: str, side: str) -> Act:
    slots = [f"damper_lost_{wheel}_{axle}" for wheel in SIDES[side] for axle in AXLES[place]]
    heave = "trailer" if place.startswith("trailer") else place

    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del windows
        for slot in slots:
            plant.scalar(slot, plant.get(slot) + 1.0 - values["factor"])
        if side != "both":
            plant.scalar(f"heave_frequency_{heave}", values["heave_rad_s"])
        side_effect(plant, run, values)

    return act


def _report(values: Values) -> dict[str, float]:
    return {"factor": values["factor"]}


EFFECTS = [
    Effect(
        id="damper_fade",
        component=place,
        kind="physics",
        equation="the dampers' roll moment falls to factor; the body's other axle takes it over",
        source="Table 6-1; balance of roll moments",
        parameters=(_FACTOR, *ASIDE) if side == "both" else (_FACTOR, *ASIDE, _HEAVE),
        act=_act(place, side),
        observe=observe_hitch(place, side),
        lines=("f", "2f"),
        decided_by="damper force or suspension travel",
        report=_report,
        extra={
            "needs_simulation": True,
            "needs_springs": True,
            "form": side,
            "side": side,
            "assumed_share": ASSUMED_SHARE,
        },
    )
    for place in AXLES
    for side in SIDES
]
