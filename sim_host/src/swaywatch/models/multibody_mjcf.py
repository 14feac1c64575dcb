"""The MuJoCo model of the combination: bodies and joints, no geometry, no contacts.

All forces but gravity and inertia come from :mod:`swaywatch.models.multibody_kernel`.
Frame of the car: on the ground below its centre of gravity. Frame of the trailer: in the ball.
"""

from __future__ import annotations

from swaywatch.models.multibody_vehicle import GRAVITY, Body, Combination

_HEAD = (
    '<mujoco><option timestep="0.002" gravity="0 0 {gravity}">'
    '<flag contact="disable" constraint="disable" limit="disable" warmstart="disable"/>'
    "</option><worldbody>"
)


def _inertial(place: tuple[float, float, float], mass: float, inertia: tuple[float, ...]) -> str:
    text = " ".join(f"{value:.9g}" for value in place)
    diagonal = " ".join(f"{value:.9g}" for value in inertia)
    return f'<inertial pos="{text}" mass="{mass:.9g}" diaginertia="{diagonal}"/>'


def _planar(combination: Combination, slosh_kg: float, elastic_drawbar: bool) -> str:
    car, trailer = combination.car, combination.trailer
    parts = [
        _HEAD.format(gravity="0"),
        '<body name="car"><joint name="x" type="slide" axis="1 0 0"/>',
        '<joint name="y" type="slide" axis="0 1 0"/><joint name="yaw" type="hinge" axis="0 0 1"/>',
        _inertial((0, 0, 0), car.mass_kg, (car.yaw_inertia_kgm2,) * 3),
        f'<body name="trailer" pos="{-car.hitch_to_cog_m:.9g} 0 0">',
        '<joint name="hitch" type="hinge" axis="0 0 1"/>',
        '<joint name="drawbar" type="slide" axis="0 1 0"/>' if elastic_drawbar else "",
        _inertial(
            (-trailer.hitch_to_cog_m, 0, 0),
            trailer.mass_kg - slosh_kg,
            (trailer.yaw_inertia_kgm2,) * 3,
        ),
        "</body></body></worldbody></mujoco>",
    ]
    return "".join(parts)


def _sprung(
    body: Body, slosh_kg: float, radius: float
) -> tuple[float, float, float, tuple[float, ...]]:
    """Mass, COG (ahead of the whole body's, above the road) and inertias without the wheels."""
    wheels = [
        (axle.to_cog_m, axle.track_m / 2, axle.unsprung_mass_kg) for axle in (body.front, body.rear)
    ]
    unsprung = 2 * sum(m for _, _, m in wheels)
    mass = body.mass_kg - slosh_kg - unsprung
    ahead = -2 * sum(m * x for x, _, m in wheels) / mass
    up = (body.mass_kg * body.cog_height_m - unsprung * radius) / (mass + slosh_kg)
    yaw = body.yaw_inertia_kgm2 - 2 * sum(m * (x * x + y * y) for x, y, m in wheels)
    yaw -= mass * ahead * ahead
    roll = body.roll_inertia_kgm2 - 2 * sum(m * y * y for _, y, m in wheels)
    pitch = body.pitch_inertia_kgm2 - 2 * sum(m * x * x for x, _, m in wheels)
    return mass, ahead, up, (roll, pitch, yaw)


def _carriers(
    body: Body, prefix: str, origin_x: float, origin_z: float, radius: float
) -> list[str]:
    """Four wheel carriers sliding along the body's vertical; the frame's origin is given."""
    parts = []
    for name, axle in (("f", body.front), ("r", body.rear)):
        for side, sign in (("l", 1), ("r", -1)):
            x, y = axle.to_cog_m - origin_x, sign * axle.track_m / 2
            m = axle.unsprung_mass_kg
            parts.append(
                f'<body name="{prefix}{name}{side}" pos="{x:.9g} {y:.9g} {radius - origin_z:.9g}">'
                f'<joint name="{prefix}{name}{side}" type="slide" axis="0 0 1"/>'
                + _inertial((0, 0, 0), m, (1e-3, 1e-3, 1e-3))
                + "</body>"
            )
    return parts


def _full(combination: Combination, slosh_kg: float) -> str:
    car, trailer = combination.car, combination.trailer
    height, radius = combination.ball_height_m, combination.wheel_radius_m
    mass, ahead, up, inertia = _sprung(car, 0.0, radius)
    parts = [
        _HEAD.format(gravity=-GRAVITY),
        '<body name="car"><freejoint name="car"/>',
        _inertial((ahead, 0, up), mass, inertia),
        *_carriers(car, "c", 0.0, 0.0, radius),
        f'<body name="trailer" pos="{-car.hitch_to_cog_m:.9g} 0 {height:.9g}">',
        '<joint name="hitch" type="hinge" axis="0 0 1"/>',
        '<joint name="hitch_pitch" type="hinge" axis="0 1 0"/>',
        '<joint name="hitch_roll" type="hinge" axis="1 0 0"/>',
    ]
    mass, ahead, up, inertia = _sprung(trailer, slosh_kg, radius)
    lever = trailer.hitch_to_cog_m
    parts += [
        _inertial((ahead - lever, 0, up - height), mass, inertia),
        *_carriers(trailer, "t", lever, height, radius),
        "</body></body></worldbody></mujoco>",
    ]
    return "".join(parts)


def mjcf(
    combination: Combination, *, full: bool, slosh_kg: float = 0.0, elastic_drawbar: bool = False
) -> str:
    """MJCF of the combination.

    Parameters
    ----------
    combination : what to build.
    full : bodies with heave, pitch, roll and suspensions; else 4 planar degrees of freedom.
    slosh_kg : mass of the trailer that the kernel moves on its own.
    elastic_drawbar : a planar trailer moves sideways at the ball too.
    """
    if full:
        return _full(combination, slosh_kg)
    return _planar(combination, slosh_kg, elastic_drawbar)
