"""A generated combination in the words of the package's plant, for those who know the truth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swaywatch.models.multibody_vehicle import Combination, Physics, static_loads

Array = NDArray[np.float64]


def constants(whole: Combination) -> Array:
    """Constants in the order of `plant.lanes.BODY`; a trailer with two axles."""
    rows = []
    for body in (whole.car, whole.trailer):
        rows += [
            body.mass_kg, body.yaw_inertia_kgm2, body.front.to_cog_m, -body.rear.to_cog_m,
            body.hitch_to_cog_m, body.front.cornering_stiffness_n_rad,
            body.rear.cornering_stiffness_n_rad,
        ]  # fmt: skip
    return np.array([*rows, *static_loads(whole)])


def rigid(whole: Combination) -> dict[str, float]:
    """Slots of bodies in the plane: load transfer and a roll that carries no inertia."""
    values = {}
    for name, body in (("car", whole.car), ("trailer", whole.trailer)):
        omega, damping = 2.0 * np.pi * body.roll_frequency_hz, body.roll_damping_ratio
        moment = body.mass_kg * body.cog_height_m
        values |= {
            f"transfer_{name}_front": body.front_share * moment / body.front.track_m,
            f"transfer_{name}_rear": (1.0 - body.front_share) * moment / body.rear.track_m,
            f"roll_gain_{name}": body.roll_gain_rad_m_s2,
            f"roll_frequency_{name}": omega,
            f"roll_damping_{name}": damping,
        }
    return values


def springs(whole: Combination) -> dict[str, float]:
    """Values of the sprung plant: spring and bar in series with the tyre; roll axis on the road.

    The wheels slide along the body's own vertical, so they tilt with it: all of the mass rolls.
    """
    values = {
        "wheel_radius": whole.wheel_radius_m,
        "track_car_front": whole.car.front.track_m, "track_car_rear": whole.car.rear.track_m,
        "track_trailer": whole.trailer.front.track_m,
    }  # fmt: skip
    for name, body in (("car", whole.car), ("trailer", whole.trailer)):
        stiffness, damping, carried = [], [], 0.0
        for axle in (body.front, body.rear):
            half = 0.5 * axle.track_m**2
            spring = axle.spring_n_m + 2.0 * axle.roll_bar_n_m
            share = axle.tyre_vertical_stiffness_n_m / (axle.tyre_vertical_stiffness_n_m + spring)
            stiffness.append(half * spring * share)
            damping.append(half * axle.damper.coefficient_ns_m * share**2)
            carried += half * axle.unsprung_mass_kg
        values |= {
            f"sprung_mass_{name}": body.mass_kg,
            f"sprung_height_{name}": body.cog_height_m,
            f"ball_height_{name}": whole.ball_height_m,
            f"roll_inertia_{name}": body.roll_inertia_kgm2 - carried,
            f"roll_stiffness_{name}": sum(stiffness),
            f"roll_damping_rate_{name}": sum(damping),
            f"roll_damping_share_{name}": damping[0] / sum(damping),
            f"roll_axis_height_{name}": 0.0,
            f"roll_front_share_{name}": stiffness[0] / sum(stiffness),
            f"sensor_height_{name}": body.cog_height_m,
        }
    return values


def bounce(whole: Combination) -> dict[str, float]:
    """Slots of bodies that their dampers and the lean of their wheels lift and drop."""
    loads = static_loads(whole)
    values = {}
    for number, (name, body) in enumerate((("car", whole.car), ("trailer", whole.trailer))):
        omega = []
        for axle, load in zip((body.front, body.rear), loads[2 * number :], strict=False):
            tyre = axle.tyre_vertical_stiffness_n_m
            spring = 2.0 * axle.spring_n_m * tyre / (axle.spring_n_m + tyre)
            omega.append(float(np.sqrt(spring * 9.81 / load)))
        damper = body.front.damper
        both_axles = damper.coefficient_ns_m + body.rear.damper.coefficient_ns_m
        values |= {
            f"damper_asymmetry_{name}": (damper.ratio - 1.0) / (damper.ratio + 1.0),
            f"heave_damping_{name}": both_axles / (float(np.mean(omega)) * body.mass_kg),
            f"jacking_{name}": 1.0,
        }
        if name == "car":
            values["heave_frequency_car_front"], values["heave_frequency_car_rear"] = omega
        else:
            values["heave_frequency_trailer"] = float(np.mean(omega))
    return values


def tyres(physics: Physics) -> dict[str, float]:
    """Slots of the tyres and of the air that every combination on springs has."""
    front, rear, trailer, _ = physics.relaxation_m
    return {
        "relaxation_car_front": front,
        "relaxation_car_rear": rear,
        "relaxation_trailer": trailer,
        "peak_friction_inverse": 1.0 / physics.peak_friction,
        "degression": physics.load_degression,
        "drag_area_car": physics.drag_area_m2[0],
        "drag_area_trailer": physics.drag_area_m2[1],
    }
