"""``vehicle.toml``, read and checked."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from swaywatch.ecu.core import core_vehicle, vehicle_ranges
from swaywatch.errors import VehicleError
from swaywatch.nearest import with_known
from swaywatch.toml_file import load_toml, refuse_other_kind
from swaywatch.vehicle import UNKNOWNS, Car, Trailer, Vehicle

_UNITS = {
    "mass": "kg",
    "yaw_inertia": "kg m2",
    "front_axle_to_cog": "m",
    "rear_axle_to_cog": "m",
    "hitch_to_cog": "m",
    "steering_ratio": "-",
    "front_cornering_stiffness": "N/rad",
    "rear_cornering_stiffness": "N/rad",
    "front_axle_load": "N",
    "rear_axle_load": "N",
}


def _range(table: str, key: str) -> tuple[float, float, str]:
    """Lowest and highest value, the core's own (none accepts what another refuses), and unit."""
    return (*vehicle_ranges()[f"{table}.{key}"], _UNITS[key])


def load_vehicle(path: Path | str) -> Vehicle:
    """Read and check a ``vehicle.toml``.

    Raises
    ------
    VehicleError
        Names file, key, value and the range or unit that would be right.
    """
    path = Path(path)
    content = load_toml(path, VehicleError, "vehicle.toml")
    refuse_other_kind(path, content, VehicleError, "vehicle.toml")
    tables = ("car", "trailer", "tolerance")
    unknown = sorted(set(content) - set(tables))
    if unknown:
        hint = with_known(unknown[0], tables)
        raise VehicleError(f"{path}: unknown table [{unknown[0]}]{hint}")
    if not isinstance(content.get("car"), dict):
        raise VehicleError(f"{path}: no [car] table; it needs at least mass, yaw_inertia, ...")
    car = Car(**_table(path, "car", content["car"], Car))
    trailer = None
    if "trailer" in content:
        trailer = _trailer(path, content["trailer"], car)
        if car.hitch_to_cog is None:
            raise VehicleError(
                f"{path}: [car] hitch_to_cog is missing; it is required with a trailer (m)"
            )
    vehicle = Vehicle(car, trailer, path, _tolerances(path, content.get("tolerance", {})))
    _check_sense(path, vehicle)
    core_vehicle(vehicle)  # refuses what the core and the daemon would
    return vehicle


TOLERATED = (
    "mass", "yaw_inertia", "front_cornering_stiffness", "rear_cornering_stiffness", "cog",
    "hitch_to_cog",
)  # fmt: skip
"""Values that may carry a tolerance of their own; `cog` shifts the centre of gravity lengthwise."""
TIGHTEST, LOOSEST = 1e-4, 0.5

TYPICAL_MASS_SHARE = 0.8
"""Mass of a trailer over that of its car."""
TYPICAL_LENGTH_M = 4.3
"""Hitch to COG."""
TYPICAL_AXLE_M = 0.18
"""Axle behind the COG: 4 % of the mass on the ball."""
TYPICAL_GYRATION = 0.22
"""Yaw inertia over mass times squared distance of the hitch."""


def _trailer(path: Path, table: Any, car: Car) -> Trailer:
    """A [trailer] with what is known; typical values, named in `assumed`, for the rest."""
    if not isinstance(table, dict):
        raise VehicleError(f"{path}: [trailer] must be a table")
    given = dict(table)
    assumed = []
    to_axle = given.pop("hitch_to_axle", None)
    _check_values(path, "trailer", given, _fields(Trailer))
    if to_axle is not None and not (isinstance(to_axle, (int, float)) and 0.5 <= to_axle <= 20.0):
        raise VehicleError(
            f"{path}: [trailer] hitch_to_axle = {to_axle!r} must be a number from 0.5 to 20 m"
        )
    if to_axle is not None and "hitch_to_cog" in given:
        raise VehicleError(
            f"{path}: [trailer] gives hitch_to_axle and hitch_to_cog; one of them is enough "
            "(rear_axle_to_cog is the rest)"
        )
    if to_axle is not None:
        given["hitch_to_cog"] = to_axle - given.get("rear_axle_to_cog", TYPICAL_AXLE_M)
    elif "hitch_to_cog" not in given:
        given["hitch_to_cog"] = TYPICAL_LENGTH_M
        assumed.append("hitch_to_cog")
    if "mass" not in given:
        given["mass"] = TYPICAL_MASS_SHARE * car.mass
        assumed.append("mass")
    if "rear_axle_to_cog" not in given:
        given["rear_axle_to_cog"] = TYPICAL_AXLE_M
        assumed.append("axle")
    if "yaw_inertia" not in given:
        given["yaw_inertia"] = TYPICAL_GYRATION * given["mass"] * given["hitch_to_cog"] ** 2
        assumed.append("yaw_inertia")
    if "rear_cornering_stiffness" not in given:
        assumed.append("stiffness")
    values = _table(path, "trailer", given, Trailer)
    return Trailer(**values, assumed=tuple(name for name in UNKNOWNS if name in assumed))


def _fields(kind: type[Any]) -> dict[str, Any]:
    return {field.name: field for field in dataclasses.fields(kind) if field.name != "assumed"}


def _table(path: Path, name: str, table: Any, kind: type[Any]) -> dict[str, float]:
    if not isinstance(table, dict):
        raise VehicleError(f"{path}: [{name}] must be a table")
    fields = _fields(kind)
    _check_keys(path, name, table, fields)
    for key, field in fields.items():
        if key not in table and field.default is dataclasses.MISSING:
            low, high, unit = _range(name, key)
            raise VehicleError(
                f"{path}: [{name}] {key} is missing; expected {low:g} to {high:g} {unit}"
            )
    _check_values(path, name, table, fields)
    return {key: float(value) for key, value in table.items()}


def _check_keys(path: Path, name: str, table: Any, fields: Iterable[str]) -> None:
    """Refuse keys that are not known: before missing ones, which they are mostly meant to be."""
    for key in table:
        if key not in fields:
            extra = ("hitch_to_axle",) if name == "trailer" else ()
            hint = with_known(key, sorted((*fields, *extra)))
            raise VehicleError(f"{path}: [{name}] {key} is not known{hint}")


def _check_values(path: Path, name: str, table: Any, fields: dict[str, Any]) -> None:
    """Refuse keys that are not known, and values that are no numbers in their range."""
    _check_keys(path, name, table, fields)
    for key, value in table.items():
        low, high, unit = _range(name, key)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise VehicleError(f"{path}: [{name}] {key} = {value!r} must be a number in {unit}")
        if not low <= value <= high:
            shown = f"{value:g}" if abs(value) < 1e300 else str(value)[:20] + "..."
            raise VehicleError(
                f"{path}: [{name}] {key} = {shown} {unit} is out of range; expected "
                f"{low:g} to {high:g} {unit}"
            )


def _tolerances(path: Path, table: Any) -> dict[str, float]:
    """[tolerance.car] and [tolerance.trailer] as one dictionary."""
    found: dict[str, float] = {}
    parts = table.items() if isinstance(table, dict) else [("", table)]
    for part, values in parts:
        if part not in ("car", "trailer") or not isinstance(values, dict):
            raise VehicleError(
                f"{path}: [tolerance] has {part!r}; known: [tolerance.car], [tolerance.trailer]"
            )
        known = [*TOLERATED, *(["steering_ratio"] if part == "car" else [])]
        for key, value in values.items():
            if key not in known:
                hint = with_known(key, known)
                raise VehicleError(f"{path}: [tolerance.{part}] {key} is not known{hint}")
            right = isinstance(value, (int, float)) and not isinstance(value, bool)
            if not right or not TIGHTEST <= value <= LOOSEST:
                unit = "m" if key in ("cog", "hitch_to_cog") else "(0.02 is 2 %)"
                raise VehicleError(
                    f"{path}: [tolerance.{part}] {key} = {value!r} must be a number from "
                    f"{TIGHTEST:g} to {LOOSEST:g} {unit}"
                )
            found[f"{part}.{key}"] = float(value)
    return found


def _check_sense(path: Path, vehicle: Vehicle) -> None:
    """Refuse combinations of values that no vehicle has."""
    car, trailer = vehicle.car, vehicle.trailer
    if car.wheelbase < 1.0:
        raise VehicleError(
            f"{path}: [car] the axles are {car.wheelbase:g} m apart; check front_axle_to_cog "
            "(positive ahead of the COG) and rear_axle_to_cog (positive behind it)"
        )
    radius = (car.yaw_inertia / car.mass) ** 0.5
    if not 0.2 <= radius <= 5.0:
        raise VehicleError(
            f"{path}: [car] yaw_inertia = {car.yaw_inertia:g} kg m2 gives a radius of gyration of "
            f"{radius:.2f} m with mass = {car.mass:g} kg; expected 0.2 to 5 m"
        )
    if trailer is None:
        return
    radius = (trailer.yaw_inertia / trailer.mass) ** 0.5
    if not 0.2 <= radius <= 6.0:
        raise VehicleError(
            f"{path}: [trailer] yaw_inertia = {trailer.yaw_inertia:g} kg m2 gives a radius of "
            f"gyration of {radius:.2f} m with mass = {trailer.mass:g} kg; expected 0.2 to 6 m"
        )
    if trailer.front_axle_to_cog is not None:
        spacing = trailer.front_axle_to_cog + trailer.rear_axle_to_cog
        if spacing <= 0.0:
            raise VehicleError(
                f"{path}: [trailer] the front axle lies {-spacing:g} m behind the rear axle; check "
                "the signs of front_axle_to_cog (positive ahead) and rear_axle_to_cog"
            )
    if trailer.hitch_to_cog + trailer.rear_axle_to_cog <= 0.3:
        raise VehicleError(f"{path}: [trailer] the hitch must lie ahead of the axles")
