#!/usr/bin/env python3
"""plant_table.py VEHICLE.toml OUT.h: the numbers of a combination and the FMU's names, as C.

The numbers are those with which `swaywatch.models.double_track` starts the plant of this vehicle on
springs (`swaywatch.plant.sprung`), so the FMU is the same plant.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from pathlib import Path

from swaywatch.models.double_track import DoubleTrack, SpeedControl, channel_columns
from swaywatch.plant.lanes import AXLE, AXLES, BODY, DRIVE, SCALARS
from swaywatch.plant.sprung import BELIEFS, defaults
from swaywatch.plant.stepping import COLUMNS, Setup
from swaywatch.plant.vehicle_view import constants_of
from swaywatch.vehicle import Vehicle
from swaywatch.vehicle_file import load_vehicle

HEAD = "/* Made by plant_table.py from {}. */\n"
BODY_UNITS = {
    "mass": ("kg", 1.0), "inertia": ("kg.m2", 1.0), "cornering_stiffness": ("N/rad", 0.0),
    "axle_load": ("N", 0.0), "to_cog": ("m", -20.0),
}  # fmt: skip
"""Word in the name of a constant -> its unit, its least value."""
AXLE_PARAMETERS = (
    ("relaxation_length", "m", "relaxation", False),
    ("peak_friction", "", "peak_friction_inverse", True),
    ("load_degression", "", "degression", False),
    ("roll_steer", "", "roll_steer", False),
)
SCALAR_PARAMETERS = (
    ("hitch.friction", "N.m", "hitch_friction", False),
    ("hitch.damping", "N.m.s/rad", "hitch_damping", False),
    ("steering.stiffness", "N/rad", "steering_flexibility", True),
    ("drag.car_area", "m2", "drag_area_car", False),
    ("drag.trailer_area", "m2", "drag_area_trailer", False),
)
DRIVE_PARAMETERS = (
    ("speed_control", "", "free_speed"),
    ("rolling_resistance", "", "rolling_resistance"),
)  # fmt: skip
UNITS = {
    "speed": "m/s", "lateral_velocity": "m/s", "rate": "rad/s", "articulation": "rad",
    "roll": "rad", "yaw_acceleration": "rad/s2", "acceleration": "m/s2", "force": "N",
    "load": "N", "moment": "N.m", "angle": "rad", "sideslip": "rad", "slip": "rad", "yaw": "rad",
    "bank": "rad", "x": "m", "y": "m",
}  # fmt: skip
"""End of an output's name, without axis and wheel -> its unit."""


def unit_of_output(name: str) -> str:
    """Unit of an output by the last words of its name."""
    if name in UNITS:
        return UNITS[name]
    bare = re.sub(r"_(fl|fr|rl|rr|x|y)$", "", name)
    return next(unit for end, unit in UNITS.items() if bare == end or bare.endswith(f"_{end}"))


def array(name: str, count: str, values: Iterable[float]) -> str:
    """A constant array of doubles."""
    rows = "".join(f"    {float(value)!r},\n" for value in values)
    return f"static const double {name}[{count}] = {{\n{rows}}};\n"


def parameters(vehicle: Vehicle, setup: Setup) -> list[str]:
    """Rows of name, unit, room, index, inverse, least value, start."""
    found = []

    def add(
        name: str, unit: str, room: str, index: object, start: float, low: float = 0.0,
        inverse: bool = False,
    ) -> None:  # fmt: skip
        found.append(f'{{"{name}", "{unit}", {room}, {index}, {str(inverse).lower()}, '
                     f"{low!r}, {float(start)!r}}}")  # fmt: skip

    for index, name in enumerate(BODY):
        unit, low = next(rule for word, rule in BODY_UNITS.items() if word in name)
        add(name, unit, "TO_BODY", index, setup.body[index], low)
    add("car.steering_ratio", "", "TO_OWN", "OWN_STEERING_RATIO", vehicle.car.steering_ratio, 0.1)
    rear = -vehicle.car.rear_axle_to_cog
    for body, place in (("car", rear), ("trailer", 0.0)):
        own = f"OWN_POSITION_{body.upper()}"
        add(f"{body}.lateral_acceleration_position", "m", "TO_OWN", own, place, -20.0)
    for belief in BELIEFS:
        if not belief.name.startswith("sens"):  # the outputs are those of an ideal sensor
            unit = belief.unit.replace(" ", ".").removesuffix("1")
            index = SCALARS.index(belief.name)
            add(f"sprung.{belief.name}", unit, "TO_SCALAR", index, setup.scalars[index])
    for name, unit, slot, inverse in SCALAR_PARAMETERS:
        index = SCALARS.index(slot)
        start = 0.0 if inverse else setup.scalars[index]
        add(name, unit, "TO_SCALAR", index, start, 0.0, inverse)
    for axle, axle_name in enumerate(AXLES):
        for name, unit, slot, inverse in AXLE_PARAMETERS:
            index = axle * len(AXLE) + AXLE.index(slot)
            low = -1.0 if slot == "roll_steer" else 0.0
            add(f"{axle_name}.{name}", unit, "TO_AXLE", index, 0.0, low, inverse)
    for name, unit, slot in DRIVE_PARAMETERS:
        index = DRIVE.index(slot)
        add(name, unit, "TO_DRIVE", index, setup.drive[index])
    return found


def outputs() -> list[str]:
    """Rows of name, unit, column, body."""
    found = [
        f'{{"{name}", "{unit_of_output(name)}", {column}, -1}}'
        for name, column in channel_columns(True).items()
    ]
    for body, name in enumerate(("car", "trailer")):
        column = COLUMNS.index(f"{name}_acceleration")
        found.append(f'{{"{name}_lateral_acceleration", "m/s2", {column}, {body}}}')
    return found


def main(vehicle_file: str, out: str) -> None:
    """Write the header."""
    vehicle = load_vehicle(Path(vehicle_file))
    if vehicle.trailer is None:
        sys.exit(f"{vehicle_file}: no [trailer]: the plant's FMU is a car with a trailer")
    model = DoubleTrack(vehicle, sprung=defaults(constants_of(vehicle)))
    setup = model.setup(25.0, None, SpeedControl())
    text = HEAD.format(Path(vehicle_file).name)
    text += array("base_body", "PLANT_BODY", setup.body)
    text += array("base_scalars", "PLANT_SCALARS", setup.scalars)
    text += array("base_axles", "4 * PLANT_AXLE", setup.axles.ravel())
    text += array("base_drive", "PLANT_DRIVE", setup.drive)
    for kind, rows in (("parameter", parameters(vehicle, setup)), ("output", outputs())):
        body = "".join(f"    {row},\n" for row in rows)
        text += f"static const {kind}_t {kind}s[] = {{\n{body}}};\n"
    Path(out).write_text(text)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
