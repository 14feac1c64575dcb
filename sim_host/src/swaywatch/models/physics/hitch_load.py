"""Static ball load other than that behind the given axle loads."""

from __future__ import annotations

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter
from swaywatch.plant.layout import A, P


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    force = effect.values["force_n"]
    axles = arrays.axles
    front, rear = float(axles[0, A["x"]]), -float(axles[1, A["x"]])
    base = front + rear
    behind = float(arrays.p[P["lh1"]]) - rear
    changes = [-force * behind / base, force * (base + behind) / base]
    trailer_load = float(axles[2, A["load"]] + axles[3, A["load"]])
    if trailer_load > 0.0:
        changes += [-force * float(axles[k, A["load"]]) / trailer_load for k in (2, 3)]
    for axle, change in enumerate(changes):
        load = float(axles[axle, A["load"]])
        if load > 0.0:
            axles[axle, A["stiffness"]] *= (load + change) / load
            axles[axle, A["load"]] = load + change


MODULE = Module(
    id="hitch_load",
    title="Static ball load changed",
    equation="dF_z,r1 = F (l_1 + l_hr1)/l_1, dF_z,f1 = -F l_hr1/l_1, trailer axles share -F; "
    "stiffness follows the load",
    source="Zhang 2015, outlook (hitch load 0 to 500 N raised v_crit by about 20 km/h)",
    enters="static axle loads and, proportionally, axle cornering stiffness",
    parameters=(
        PhysicsParameter(
            "force_n", "N", -1500.0, 1500.0, 250.0, meaning="more load on the car's ball"
        ),
    ),
    apply=_apply,
)
