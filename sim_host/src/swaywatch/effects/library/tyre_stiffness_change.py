"""The stiffness of an axle changes for a time with no change of load (pressure, road surface)."""

from __future__ import annotations

from collections.abc import Sequence

from swaywatch.effects.effect import Act, Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput


def _act(slots: Sequence[str]) -> Act:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del values
        for window in windows:
            for slot in slots:
                plant.add_series(slot, (window.values["factor"] - 1.0) * window.mask(run.time))

    return act


EFFECTS = [
    Effect(
        id="tyre_stiffness_change",
        component=axle,
        kind="physics",
        equation="C = factor x C_0 within the windows",
        source="stiffness at unchanged load",
        parameters=(Parameter("factor", "-", 1.0, 0.2, 3.0, (0.9,), 0.01, 0.005),),
        act=_act(slots),
        windowed=True,
        decided_by="wheel loads: they do not change with it",
    )
    for axle, slots in (
        ("car_front", ("stiffness_car_front",)),
        ("car_rear", ("stiffness_car_rear",)),
        ("trailer", ("stiffness_trailer_front", "stiffness_trailer_rear")),
        ("trailer_front", ("stiffness_trailer_front",)),
        ("trailer_rear", ("stiffness_trailer_rear",)),
    )
]
