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
        if "roll_frequency_rad_s" in values:
            plant.scalar("roll_frequency_trailer", values["roll_frequency_rad_s"])
            plant.scalar("roll_damping_trailer", values["roll_damping"])

    return act


_COEFFICIENT = Parameter("coefficient", "rad/rad", 0.0, -1.0, 1.0, (0.05, -0.05), 0.005, 0.01)
#: The trailer's roll is not seen in any load: its frequency and damping are fitted.
_ROLL = (
    Parameter("roll_frequency_rad_s", "rad/s", 13.0, 4.0, 40.0, (10.0,), 0.2, 1e9),
    Parameter("roll_damping", "-", 0.112, 0.03, 1.5, (0.3,), 0.02, 1e9),
)

EFFECTS = [
    Effect(
        id="roll_steer",
        component=axle,
        kind="physics",
        equation="alpha' = alpha + coefficient x roll",
        source="suspension kinematics",
        parameters=(_COEFFICIENT, *_ROLL) if axle == "trailer" else (_COEFFICIENT,),
        act=_act(f"roll_steer_{axle}"),
        decided_by="roll angle, and slip stiffness at two speeds",
    )
    for axle in ("car_front", "car_rear", "trailer")
]
