"""A gust pushes one body sideways for a time, where its side area and the flow put it."""

from __future__ import annotations

from collections.abc import Sequence

from swaywatch.effects.effect import RISE, Act, Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput

#: A force from outside acts on its own, not through the motion: shorter pulses show where it is.
PULSE_S = 0.5
SHAPES = {
    "box": Window.mask,
    "half_sine": Window.half_sine,
    "one_minus_cosine": Window.one_minus_cosine,
    "ramped": Window.ramped,
}


def ramp(shape: str) -> tuple[Parameter, ...]:
    """What a form has to fit beside the size."""
    return (RISE,) if shape == "ramped" else ()


LEAST_N = 150.0  # a breeze of 4 m/s on the side of a caravan (12 m2), which every road has
#: Centre of pressure ahead of the centre of gravity: nobody knows it, and a trailer's axle, close
#: behind its centre of gravity, holds a force there without much yaw.
ARM = Parameter("arm_m", "m", 0.0, -2.5, 2.5, (0.0,), 0.1, 1e9)


def _act(body: str, shape: str) -> Act:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del values
        for window in windows:
            force = window.values["force_n"] * SHAPES[shape](window, run.time)
            plant.add_series(f"force_{body}", force)
            plant.add_series(f"moment_{body}", window.values.get("arm_m", 0.0) * force)

    return act


EFFECTS = [
    Effect(
        id="crosswind_gust",
        component=body,
        kind="physics",
        equation=f"side force at the centre of pressure, {shape.replace('_', ' ')} in time",
        source="external force",
        parameters=(
            Parameter("force_n", "N", 0.0, -2e4, 2e4, (300.0,), 10.0, LEAST_N),
            *ramp(shape),
            *((ARM,) if shape != "box" else ()),
        ),
        act=_act(body, shape),
        windowed=True,
        lines=("broadband",),
        decided_by="wind speed measured at the car",
        extra={"form": shape, "pulse_s": PULSE_S},
    )
    for body in ("car", "trailer")
    for shape in SHAPES
]
