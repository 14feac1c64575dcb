"""Roll stiffness of a body differs from the user's simulation.

A stiffer body rolls less and earlier. Three things follow: the load transfer changes with the
roll's dynamics, load moves between the axles where one end became stiffer than the other, and the
wheels, which the roll carries sideways under the roll centre, slip otherwise.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.signal import bilinear, hilbert, lfilter

from swaywatch.diagnose.effect import Array, Effect, Parameter, Values, Window
from swaywatch.diagnose.modules.damper_fade import STIFFNESS, side_effect
from swaywatch.diagnose.plant import PlantInput
from swaywatch.diagnose.runs import RATE_HZ, Run


def changes(shift: Array, values: Values) -> tuple[Array, Array]:
    """Change of the load transfer and of the roll (in newtons of static transfer). Shapes (n,).

    With s^2 + 2 z w s + w^2 = 0 the body's roll, its transfer is that of spring and damper,
    (2 z w s + w^2) roll; the moment that rolls the body is the same before and after.
    """
    w, z = values["roll_frequency_rad_s"], values["roll_damping"]
    old = np.array([1.0, 2.0 * z * w, w * w])
    new = np.array([1.0, 2.0 * z * w, values["factor"] * w * w])
    below = np.polymul(new, old[1:])
    transfer = lfilter(*bilinear(np.polymul(new[1:], old), below, RATE_HZ), shift) - shift
    rolled = lfilter(*bilinear(w * w * old, below, RATE_HZ), shift)
    before = lfilter(*bilinear([w * w], old[1:], RATE_HZ), shift)
    return np.asarray(transfer), np.asarray(rolled - before)


def _act(body: str) -> Callable[[PlantInput, Run, Values, Sequence[Window]], None]:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del windows
        shift = run.simulated.get(f"shift_{body}", np.zeros(run.time.size))
        transfer, roll = changes(shift, values)
        moved = values["moved_share"] * shift
        plant.add_series(f"shift_{body}_front", 0.25 * transfer + 0.5 * moved)
        plant.add_series(f"shift_{body}_rear", 0.25 * transfer - 0.5 * moved)
        rate = np.gradient(roll) * RATE_HZ / run.speed
        plant.add_series(f"slip_{body}_front", values["sideways_m_per_n"] * rate)
        plant.add_series(f"slip_{body}_rear", values["sideways_m_per_n"] * rate)
        side_effect(plant, run, values)

    return act


def _observe(body: str) -> Callable[[dict[str, Array], Run, Values], None]:
    """The hitch's vertical force follows the heave of the rolling body, at twice its frequency."""

    def observe(outputs: dict[str, Array], run: Run, values: Values) -> None:
        key = f"_squared_{body}"
        if key not in run.simulated:
            shift = run.simulated.get(f"shift_{body}", np.zeros(run.time.size))
            squared = shift**2 / (float(np.max(np.abs(shift))) + 1e-9)
            run.simulated[key] = hilbert(squared - squared.mean())
        part = run.simulated[key]
        outputs["hitch_vertical_force"] = (
            outputs["hitch_vertical_force"]
            + values["hitch_in_phase"] * part.real
            + values["hitch_quadrature"] * part.imag
        )

    return observe


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
            Parameter("factor", "-", 1.0, 0.3, 4.0, (1.2, 0.85), 0.02, 0.05),
            Parameter("moved_share", "-", 0.0, -0.9, 0.9, (0.0,), 0.002, 1e9),
            Parameter("sideways_m_per_n", "m/N", 0.0, -1e-4, 1e-4, (0.0,), 1e-6, 1e9),
            Parameter("roll_frequency_rad_s", "rad/s", 11.0, 6.0, 20.0, (11.0,), 0.2, 1e9),
            Parameter("roll_damping", "-", 0.25, 0.05, 0.8, (0.25,), 0.02, 1e9),
            Parameter("hitch_in_phase", "-", 0.0, -1.0, 1.0, (0.0,), 1e-3, 1e9),
            Parameter("hitch_quadrature", "-", 0.0, -1.0, 1.0, (0.0,), 1e-3, 1e9),
            STIFFNESS,
        ),
        observe=_observe(body),
        act=_act(body),
        needs=("wheel_vertical_load_fl", "trailer_wheel_vertical_load_fl"),
        decided_by="roll angle of the body",
        report=_report(body),
        extra={"needs_simulation": True},
    )
    for body in ("car", "trailer")
]
