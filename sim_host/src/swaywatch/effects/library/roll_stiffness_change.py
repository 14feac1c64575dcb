"""Roll stiffness of a body differs from the user's simulation.

A stiffer body rolls less and earlier. Three things follow: the load transfer changes with the
roll's dynamics, load moves between the axles where one end became stiffer than the other, and the
wheels, which the roll carries sideways under the roll centre, slip otherwise.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.signal import hilbert

from swaywatch.effects.effect import Act, Array, Effect, Parameter, Values, Window
from swaywatch.effects.library.damper_fade import ASIDE, side_effect
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput


def _act(body: str) -> Act:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del windows
        stiffness, share = f"roll_stiffness_{body}", f"roll_front_share_{body}"
        plant.scalar(stiffness, plant.get(stiffness) * values["factor"])
        plant.scalar(share, plant.get(share) + values["moved_share"])
        side_effect(plant, run, values)

    return act


def _observe(body: str) -> Callable[[dict[str, Array], Run, Values], None]:
    """The hitch's vertical force follows the heave of the rolling body, at twice its frequency."""

    def observe(outputs: dict[str, Array], run: Run, values: Values) -> None:
        key = f"_squared_{body}"
        if key not in run.simulated:
            roll = run.simulated[f"{body}_roll"]
            squared = roll**2 / (float(np.max(np.abs(roll))) + 1e-9)
            run.simulated[key] = hilbert(squared - squared.mean())
        part = run.simulated[key]
        outputs["hitch_vertical_force"] = (
            outputs["hitch_vertical_force"]
            + values["hitch_in_phase_n_rad"] * part.real
            + values["hitch_quadrature_n_rad"] * part.imag
        )

    return observe


#: At the frequencies of sway only (1 - 1 / factor) / roll frequency squared is seen well: which way
#: the stiffness changed is sure, the size is not, for the roll frequency is known to some 30 %.
ASSUMED_SHARE = 0.9

#: Roll stiffness of the suspension over that of the tyres below it, which springs in series.
TYRE_SHARE = {"car": 0.23, "trailer": 0.15}


def _report(body: str) -> Callable[[Values], dict[str, float]]:
    def report(values: Values) -> dict[str, float]:
        share = TYRE_SHARE[body]
        rest = (1.0 + share) / values["factor"] - share
        return {"factor": 1.0 / max(rest, 0.05)}

    return report


EFFECTS = [
    Effect(
        id="roll_stiffness_change",
        component=body,
        kind="physics",
        equation="phi'' + 2 z w phi' + factor w^2 phi = M: load transfer and slip follow the roll",
        source="balance of roll moments",
        parameters=(
            Parameter("factor", "-", 1.0, 0.1, 4.0, (1.2, 0.85), 0.02, 0.02),
            Parameter("hitch_in_phase_n_rad", "N/rad", 0.0, -1e5, 1e5, (0.0,), 100.0, 1e9),
            Parameter("hitch_quadrature_n_rad", "N/rad", 0.0, -1e5, 1e5, (0.0,), 100.0, 1e9),
            ASIDE[-1],
            Parameter("moved_share", "-", 0.0, -0.9, 0.9, (0.0,), 0.002, 1e9),
        ),
        act=_act(body),
        observe=_observe(body),
        decided_by="roll angle of the body",
        report=_report(body),
        extra={"needs_simulation": True, "needs_springs": True, "assumed_share": ASSUMED_SHARE},
    )
    for body in ("car", "trailer")
]
