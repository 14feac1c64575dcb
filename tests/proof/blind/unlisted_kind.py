"""What every kind of physics that no library lists is drawn as."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from effects import Draw

from swaywatch.models.multibody_vehicle import GRAVITY, Combination, Physics


def _without_rack(whole: Combination, mass_kg: float) -> Combination:
    """The combination less a mass above the ball, whose weight goes on resting on the car."""
    car = whole.car
    rest = car.mass_kg - mass_kg
    ahead = mass_kg * car.hitch_to_cog_m / rest  # of the COG of what is left
    inertia = car.yaw_inertia_kgm2 - mass_kg * car.hitch_to_cog_m * (car.hitch_to_cog_m + ahead)
    lighter = replace(
        car, mass_kg=rest, yaw_inertia_kgm2=inertia, hitch_to_cog_m=car.hitch_to_cog_m + ahead,
        front=replace(car.front, to_cog_m=car.front.to_cog_m - ahead),
        rear=replace(car.rear, to_cog_m=car.rear.to_cog_m - ahead),
    )  # fmt: skip
    return replace(whole, car=lighter, nose_load_n=whole.nose_load_n + mass_kg * GRAVITY)


def named(name: str, size: float, places: str, variables: str, **more: float) -> Draw:
    """A kind of `Physics.more`; places and variables are words with blanks between."""
    settings: dict[str, Any] = {"more": name, "more_size": size} | more

    def combination(whole: Combination) -> Combination:
        car, trailer = whole.car, whole.trailer
        if name == "roof_load":
            return replace(whole, car=replace(car, mass_kg=car.mass_kg - size))
        if name in ("turning_load", "unlocked_slew"):
            rest = trailer.yaw_inertia_kgm2 - size
            return replace(whole, trailer=replace(trailer, yaw_inertia_kgm2=rest))
        if name == "two_tanks":
            rest = trailer.yaw_inertia_kgm2 - size * more["slosh_position_m"] ** 2
            return replace(whole, trailer=replace(trailer, yaw_inertia_kgm2=rest))
        tail = name in ("rear_rack", "tailgate_crate")
        return _without_rack(whole, size) if tail else whole

    def physics(healthy: Physics) -> Physics:
        return replace(healthy, **settings)

    return Draw(
        {"id": name, **settings, "places": places.split(), "variables": variables.split()},
        places.partition(" ")[0],
        physics=physics,
        combination=combination,
        outside=True,
        value=size,
    )
