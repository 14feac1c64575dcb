"""Roles: what a signal of a recording means, in which unit, with which sign.

A ``signals.toml`` maps signals to roles::

    dbc = "../measurement.dbc"
    [signals]
    speed = "VehicleSpeed"
    car_lateral_acceleration = { signal = "LatAccRear1", position = -1.383 }
    wheel_lateral_force = ["FyFL", "FyFR", "FyRL", "FyRR"]

A role of four wheels becomes the four channels ``<role>_fl``, ``_fr``, ``_rl``, ``_rr``.
"""

from __future__ import annotations

from dataclasses import dataclass

WHEELS = ("fl", "fr", "rl", "rr")


@dataclass(frozen=True)
class ChannelKind:
    """One channel: its name, SI unit, range, the core's input and integer scale, its meaning."""

    name: str
    unit: str
    low: float
    high: float
    core_input: str | None
    core_scale: float
    meaning: str


def _kinds() -> dict[str, ChannelKind]:
    rows: list[ChannelKind] = [
        ChannelKind(
            "steering_wheel_angle",
            "rad",
            -12.6,
            12.6,
            "SWAY_INPUT_STEERING_WHEEL_ANGLE",
            1e6,
            "steering wheel angle, positive left",
        ),
        ChannelKind("speed", "m/s", 0.0, 120.0, "SWAY_INPUT_SPEED", 1e3, "speed over ground"),
        ChannelKind(
            "car_yaw_rate",
            "rad/s",
            -5.3,
            5.3,
            "SWAY_INPUT_CAR_YAW_RATE",
            1e6,
            "yaw rate of the car, positive counter-clockwise from above",
        ),
        ChannelKind(
            "car_lateral_acceleration",
            "m/s2",
            -40.0,
            40.0,
            "SWAY_INPUT_CAR_LATERAL_ACC",
            1e6,
            "lateral acceleration of the car at `position` m ahead of its COG, positive left",
        ),
        ChannelKind(
            "trailer_yaw_rate",
            "rad/s",
            -5.3,
            5.3,
            "SWAY_INPUT_TRAILER_YAW_RATE",
            1e6,
            "yaw rate of the trailer, positive counter-clockwise from above",
        ),
        ChannelKind(
            "trailer_lateral_acceleration",
            "m/s2",
            -40.0,
            40.0,
            "SWAY_INPUT_TRAILER_LATERAL_ACC",
            1e6,
            "lateral acceleration of the trailer (its axes) at `position` m ahead of its COG",
        ),
        ChannelKind(
            "articulation",
            "rad",
            -1.6,
            1.6,
            "SWAY_INPUT_ARTICULATION",
            1e6,
            "articulation angle psi_trailer - psi_car",
        ),
        ChannelKind(
            "hitch_longitudinal_force",
            "N",
            -50e3,
            50e3,
            "SWAY_INPUT_HITCH_FX",
            1e3,
            "force of the trailer on the car at the ball, car axes, positive forward",
        ),
        ChannelKind(
            "hitch_lateral_force",
            "N",
            -50e3,
            50e3,
            "SWAY_INPUT_HITCH_FY",
            1e3,
            "force of the trailer on the car at the ball, car axes, positive left",
        ),
        ChannelKind(
            "hitch_vertical_force",
            "N",
            -50e3,
            50e3,
            None,
            1e3,
            "force of the trailer on the car at the ball, positive up (nose weight: negative)",
        ),
    ]
    rows += [
        ChannelKind(
            f"wheel_speed_{wheel}",
            "m/s",
            0.0,
            120.0,
            None,
            1e3,
            f"car wheel {wheel.upper()}: circumferential speed, a check of the yaw rate",
        )
        for wheel in WHEELS
    ]
    bodies = (("", "CAR", "car"), ("trailer_", "TRAILER", "trailer"))
    for prefix, body, text in bodies:
        for quantity, symbol, low, meaning in (
            ("wheel_lateral_force", "FY", -50e3, "lateral force, wheel axes, positive left"),
            ("wheel_vertical_load", "FZ", -1e3, "vertical load, road on wheel, positive up"),
        ):
            rows += [
                ChannelKind(
                    f"{prefix}{quantity}_{wheel}",
                    "N",
                    low,
                    50e3,
                    f"SWAY_INPUT_{body}_{symbol}_{wheel.upper()}",
                    1e3,
                    f"{text} wheel {wheel.upper()}: {meaning}",
                )
                for wheel in WHEELS
            ]
    return {row.name: row for row in rows}


CHANNELS: dict[str, ChannelKind] = _kinds()
"""Every channel by name, in a fixed order."""

WHEEL_ROLES = (
    "wheel_speed",
    "wheel_lateral_force",
    "wheel_vertical_load",
    "trailer_wheel_lateral_force",
    "trailer_wheel_vertical_load",
)
"""Roles that take a list of four signals [FL, FR, RL, RR]."""

SINGLE_ROLES = tuple(
    name for name in CHANNELS if not any(name.startswith(role + "_") for role in WHEEL_ROLES)
)
"""Roles that take one signal."""
