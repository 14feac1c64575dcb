"""Roll steer: an axle steers with the roll of its body."""

from __future__ import annotations

from collections.abc import Sequence

from swaywatch.effects.effect import Act, Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput


def _act(axle: str) -> Act:
    body = axle.split("_", maxsplit=1)[0]

    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del run, windows
        plant.scalar(f"roll_steer_{axle}", values["coefficient"])
        plant.scalar(f"steer_frequency_{body}", values["roll_frequency_rad_s"])
        plant.scalar(f"steer_damping_{body}", values["roll_damping"])

    return act


def _report(values: Values) -> dict[str, float]:
    return {"coefficient": values["coefficient"]}


#: What is seen is coefficient times roll; the roll per lateral acceleration is a typical one
#: (`plant.neutral`), and cars and caravans of one class differ by so much.
ASSUMED_SHARE = 0.35

#: Roll is not recorded: its frequency and damping are fitted with the coefficient.
_PARAMETERS = (
    Parameter("coefficient", "rad/rad", 0.0, -1.0, 1.0, (0.05, -0.05), 0.005, 0.002),
    Parameter("roll_frequency_rad_s", "rad/s", 13.0, 4.0, 40.0, (12.0,), 0.2, 1e9),
    Parameter("roll_damping", "-", 0.112, 0.03, 1.5, (0.3,), 0.02, 1e9),
)

EFFECTS = [
    Effect(
        id="roll_steer",
        component=axle,
        kind="physics",
        equation="alpha' = alpha + coefficient x roll",
        source="suspension kinematics",
        parameters=_PARAMETERS,
        act=_act(axle),
        report=_report,
        extra={"assumed_share": ASSUMED_SHARE},
        decided_by="roll angle, and slip stiffness at two speeds",
    )
    for axle in ("car_front", "car_rear", "trailer")
]
