"""Roll steer: an axle steers with the roll of its body."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from swaywatch.diagnose.effect import Effect, Parameter, Values, Window
from swaywatch.diagnose.plant import PlantInput
from swaywatch.diagnose.runs import Run


def _act(slot: str) -> Callable[[PlantInput, Run, Values, Sequence[Window]], None]:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del run, windows
        plant.scalar(slot, values["coefficient"])

    return act


EFFECTS = [
    Effect(
        id="roll_steer",
        component=axle,
        kind="physics",
        equation="alpha' = alpha + coefficient x roll",
        source="suspension kinematics",
        parameters=(Parameter("coefficient", "rad/rad", 0.0, -1.0, 1.0, (0.05, -0.05), 0.005, 0.01),),
        act=_act(f"roll_steer_{axle}"),
        decided_by="roll angle, and slip stiffness at two speeds",
    )
    for axle in ("car_front", "car_rear", "trailer")
]
