"""Free play of the steering: the front wheels lie against one side of the gap."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from swaywatch.effects.effect import Array, Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput


def play(angle: Array, half_gap: float) -> Array:
    """Backlash operator: output follows where the input leaves the gap. Shapes (n,)."""
    out = np.empty_like(angle)
    y = angle[0]
    for i, x in enumerate(angle):
        y = min(max(y, x - half_gap), x + half_gap)
        out[i] = y
    return out


def dead_zone(angle: Array, half_gap: float) -> Array:
    """No motion inside the gap around straight ahead. Shapes (n,)."""
    return np.sign(angle) * np.maximum(np.abs(angle) - half_gap, 0.0)


def _against_force(plant: PlantInput, run: Run, v: Values, windows: Sequence[Window]) -> None:
    del windows
    plant.scalar("free_play", np.radians(0.5 * v["gap_deg"]) / run.steering_ratio)


def _backlash(plant: PlantInput, run: Run, v: Values, windows: Sequence[Window]) -> None:
    del windows
    plant.steer = play(plant.steer, np.radians(0.5 * v["gap_deg"]) / run.steering_ratio)


def _dead(plant: PlantInput, run: Run, v: Values, windows: Sequence[Window]) -> None:
    del windows
    plant.steer = dead_zone(plant.steer, np.radians(0.5 * v["gap_deg"]) / run.steering_ratio)


LEAST_DEG = 0.3
"""Three steps of a usual steering angle sensor: less swallows its noise, with play or without."""
_GAP = Parameter("gap_deg", "deg", 0.0, 0.0, 30.0, (0.6, 2.0, 5.0), 0.1, LEAST_DEG)

EFFECTS = [
    Effect(
        id="steering_free_play",
        component="steering",
        kind="physics",
        equation=equation,
        source="reference dissertation leaves it open",
        parameters=(_GAP,),
        act=act,
        lines=("f", "3f"),
        decided_by="road-wheel angle measured at the wheel",
        extra={"form": form, "imitated_on_springs": True},
    )
    for form, act, equation in (
        ("backlash", _backlash, "play operator of width gap on the steering-wheel angle"),
        ("against_force", _against_force, "delta = delta_wheel/i_s - gap/2 sign(F_yf)"),
        ("dead_zone", _dead, "no road-wheel motion within the gap around straight ahead"),
    )
]
