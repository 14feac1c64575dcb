"""A rigid-body plant of the car-trailer combination on MuJoCo.

It makes recordings whose cause is known, to judge the rest of the package by, and therefore
shares no code with the other models or with the diagnosis. Bodies: the car on four
suspensions, the trailer on four, joined in the ball. Tyres, dampers, air and driver are our own
forces (:mod:`swaywatch.models.multibody_kernel`); what can be switched on is listed, with
equation and source, in :class:`swaywatch.models.multibody_vehicle.Physics`.

With the default physics the linear limit is the single-track model of the reference (golden
values there): damping and frequency within 1 %.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swaywatch.models import multibody_kernel as k
from swaywatch.models import multibody_tables as col
from swaywatch.models.multibody_mjcf import mjcf
from swaywatch.models.multibody_vehicle import (
    AXLES,
    DAMPER_KINDS,
    GRAVITY,
    MORE,
    TYRE_LAWS,
    Axle,
    Combination,
    Inputs,
    Physics,
    static_loads,
)

STEP_S = 0.002
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """What a run of the plant gives, all over `time_s` (every 2 ms); SI, ISO 8855.

    Accelerations are of the point's motion in the plane, along the body's lateral axis, without
    gravity: rear axle of the car, COG of the trailer. Hitch forces act on the car, car axes.
    Wheel arrays have shape (8, n): FL FR RL RR of the car, then of the trailer.
    """

    time_s: Array
    steering_wheel_rad: Array
    road_wheel_rad: Array
    speed_m_s: Array
    yaw_rad: Array
    trailer_yaw_rad: Array
    yaw_rate_rad_s: Array
    trailer_yaw_rate_rad_s: Array
    roll_rad: Array
    trailer_roll_rad: Array
    car_acceleration_m_s2: Array
    rear_acceleration_m_s2: Array
    trailer_acceleration_m_s2: Array
    hitch_x_n: Array
    hitch_y_n: Array
    hitch_z_n: Array
    wheel_fy_n: Array
    wheel_fz_n: Array
    wheel_slip_rad: Array
    damper_travel_m: Array
    damper_n: Array
    harmonic_n: Array

    def resample(self, time_s: Array) -> Motion:
        """Linear interpolation of every signal at other times."""

        def at(values: Array) -> Array:
            if values.ndim == 1:
                return np.interp(time_s, self.time_s, values)
            return np.stack([np.interp(time_s, self.time_s, row) for row in values])

        return Motion(**{f.name: at(getattr(self, f.name)) for f in fields(self)})


@cache
def _library() -> tuple[Any, ctypes.CDLL]:
    import mujoco

    found = sorted(Path(mujoco.__file__).parent.glob("libmujoco*"))
    if not found:
        raise RuntimeError("the mujoco package has no libmujoco beside its Python files")
    return mujoco, ctypes.CDLL(str(found[0]))


def _wheel_rows(combination: Combination, physics: Physics) -> Array:
    """Table of the wheels, shape (8, W_SIZE)."""
    rows = np.zeros((8, col.W_SIZE))
    loads = static_loads(combination)
    bodies = (combination.car, combination.trailer)
    for i in range(8):
        number, left = i // 2, i % 2 == 0
        body = bodies[i // 4]
        axle = body.front if number % 2 == 0 else body.rear
        origin = 0.0 if i < 4 else -body.hitch_to_cog_m
        _place(rows[i], i, axle, origin, left, physics.full, combination)
        rows[i, col.W_AXLE] = number
        rows[i, col.W_LOAD] = loads[number] / 2
        rows[i, col.W_STIFFNESS] = axle.cornering_stiffness_n_rad / 2
        rows[i, col.W_STEERED] = 1.0 if i < 2 else 0.0
        rows[i, col.W_RELAXATION] = physics.relaxation_m[number]
        rows[i, col.W_ROLL_STEER] = physics.roll_steer[number]
        share = body.front_share if number % 2 == 0 else 1.0 - body.front_share
        rows[i, col.W_TRANSFER] = share * body.mass_kg * body.cog_height_m / axle.track_m
        rows[i, col.W_FADE] = physics.damper_factor[i]
    rows[5, col.W_DRAG] = physics.wheel_drag_n
    return rows


def _place(
    row: Array, i: int, axle: Axle, origin: float, left: bool, full: bool, combination: Combination
) -> None:
    """Place of the contact point in its body's frame, and the suspension."""
    side = 1.0 if left else -1.0
    row[col.W_SIDE] = side
    if full:
        row[col.W_BODY] = 2 + i if i < 4 else 3 + i
        row[col.W_DOF] = 6 + i if i < 4 else 9 + i
        row[col.W_Z] = -combination.wheel_radius_m
    else:
        row[col.W_BODY] = col.CAR if i < 4 else col.TRAILER_PLANAR
        row[col.W_X], row[col.W_Y] = origin + axle.to_cog_m, side * axle.track_m / 2
    damper = axle.damper
    row[col.W_SPRING], row[col.W_BAR] = axle.spring_n_m, axle.roll_bar_n_m
    row[col.W_TYRE_SPRING] = axle.tyre_vertical_stiffness_n_m
    row[col.W_TYRE_DAMPER] = axle.tyre_vertical_damping_ns_m
    row[col.W_UNSPRUNG] = axle.unsprung_mass_kg
    row[col.W_DAMPER_KIND] = DAMPER_KINDS.index(damper.kind)
    row[col.W_DAMPER], row[col.W_RATIO] = damper.coefficient_ns_m, damper.ratio
    row[col.W_KNEE], row[col.W_DEGRESSION] = damper.knee_m_s, damper.degression
    row[col.W_LOST], row[col.W_LOST_FACTOR] = damper.lost_travel_m, damper.lost_factor


def _scalars(combination: Combination, physics: Physics) -> Array:
    """Table of scalars, shape (G_SIZE,)."""
    car, trailer = combination.car, combination.trailer
    g = np.zeros(col.G_SIZE)
    g[col.G_FULL] = physics.full
    g[col.G_LAW], g[col.G_SHAPE] = TYRE_LAWS.index(physics.tyre_law), physics.shape
    g[col.G_FRICTION], g[col.G_LOAD_DEGRESSION] = physics.peak_friction, physics.load_degression
    g[col.G_RATIO], g[col.G_COMPLIANCE] = (
        combination.steering_ratio,
        physics.steering_stiffness_n_rad,
    )
    g[col.G_PLAY], g[col.G_PLAY_LAW] = physics.free_play_rad, physics.free_play_law == "aligned"
    if physics.free_play_rad == 0.0:
        g[col.G_PLAY_LAW] = 0.0
    g[col.G_HITCH_FRICTION] = physics.hitch_friction_nm
    g[col.G_HITCH_DAMPING] = physics.hitch_damping_nms_rad
    g[col.G_HITCH_SPRING] = physics.hitch_spring_nm_rad
    g[col.G_AIR_SIDE] = physics.side_force_coefficient
    g[col.G_AIR_YAW] = physics.yaw_moment_coefficient
    g[col.G_DRAG_CAR], g[col.G_DRAG_TRAILER] = physics.drag_area_m2
    g[col.G_CAR_MASS], g[col.G_TRAILER_MASS] = car.mass_kg, trailer.mass_kg
    for start, body in ((col.G_CAR_ROLL_GAIN, car), (col.G_TRAILER_ROLL_GAIN, trailer)):
        g[start] = body.roll_gain_rad_m_s2
        g[start + 1] = 2 * np.pi * body.roll_frequency_hz
        g[start + 2] = body.roll_damping_ratio
    g[col.G_HARMONIC_AXLE] = (
        -1 if physics.axle_load is None else AXLES.index(physics.axle_load.axle)
    )
    g[col.G_SLOSH_MASS], g[col.G_SLOSH_X] = physics.slosh_mass_kg, physics.slosh_position_m
    g[col.G_SLOSH_OMEGA] = 2 * np.pi * physics.slosh_frequency_hz
    g[col.G_SLOSH_ZETA] = physics.slosh_damping
    if physics.more:
        g[col.G_MORE] = MORE.index(physics.more) + 1
        g[col.G_MORE_SIZE], g[col.G_MORE_AT] = physics.more_size, physics.more_at
        g[col.G_MORE_HZ] = 2 * np.pi * physics.more_frequency_hz
    g[col.G_YAW_CONTROL] = physics.yaw_moment_nms_rad
    g[col.G_CAR_LEVER], g[col.G_TRAILER_LEVER] = car.hitch_to_cog_m, trailer.hitch_to_cog_m
    g[col.G_BALL], g[col.G_RADIUS] = combination.ball_height_m, combination.wheel_radius_m
    g[col.G_CAR_HEIGHT], g[col.G_TRAILER_HEIGHT] = car.cog_height_m, trailer.cog_height_m
    g[col.G_HITCH_DOF] = 10 if physics.full else 3
    g[col.G_REAR_X] = car.rear.to_cog_m
    return g


def _input_rows(inputs: Inputs) -> tuple[Array, Array]:
    """Times every `STEP_S` and the table of inputs, shape (n, U_SIZE)."""
    given = np.asarray(inputs.time_s, dtype=float)
    time = np.arange(given[0], given[-1] + STEP_S / 2, STEP_S)
    rows = np.zeros((time.size, col.U_SIZE))
    rows[:, col.U_FRICTION] = 1.0
    rows[:, col.U_STIFFNESS : col.U_STIFFNESS + 4] = 1.0
    rows[:, col.U_FADE] = 1.0
    columns: dict[int, object] = {
        col.U_STEER: inputs.steering_wheel_rad,
        col.U_SPEED: inputs.speed_m_s,
        col.U_GUST_CAR: inputs.car_side_force_n,
        col.U_GUST_TRAILER: inputs.trailer_side_force_n,
        col.U_BANK: inputs.bank_rad,
        col.U_FRICTION: inputs.friction_factor,
        col.U_HARMONIC: inputs.harmonic_n,
        col.U_DELAY: inputs.harmonic_delay_s,
        col.U_FADE: inputs.damper_fade,
    }
    for axle, factor in inputs.stiffness_factor.items():
        columns[col.U_STIFFNESS + AXLES.index(axle)] = factor
    for column, values in columns.items():
        if values is not None:
            rows[:, column] = np.interp(time, given, np.asarray(values, dtype=float))
    rows[:, col.U_ACCELERATION] = np.gradient(rows[:, col.U_SPEED], STEP_S)
    return time, rows


class Multibody:
    """The plant: build once, run often.

    Parameters
    ----------
    combination : vehicle, tyres and suspensions.
    physics : what is switched on.
    """

    def __init__(self, combination: Combination, physics: Physics | None = None) -> None:
        self.combination = combination
        self.physics = physics or Physics()
        mujoco, library = _library()
        text = mjcf(
            combination,
            full=self.physics.full,
            slosh_kg=self.physics.slosh_mass_kg,
            elastic_drawbar=self.physics.more
            in ("elastic_drawbar", "ball_rattle", "slipping_neck", "open_crack"),
        )
        self._model = mujoco.MjModel.from_xml_string(text)
        self._data = mujoco.MjData(self._model)
        names = (
            "mj_fwdPosition",
            "mj_fwdVelocity",
            "mj_fwdActuation",
            "mj_fwdAcceleration",
            "mj_fwdConstraint",
            "mj_integratePos",
        )
        found = (ctypes.cast(getattr(library, name), ctypes.c_void_p).value for name in names)
        self._calls = k.Calls(
            self._model._address, self._data._address, *(int(a or 0) for a in found)
        )
        d = self._data
        self._view = k.View(
            d.xpos, d.xmat, d.xipos, d.cvel, d.subtree_com, d.xfrc_applied, d.qfrc_applied,
            d.qpos, d.qvel, d.qacc, self._model.body_mass.copy(),
        )  # fmt: skip
        self._wheels = _wheel_rows(combination, self.physics)
        self._scalars = _scalars(combination, self.physics)
        moved = combination.trailer.mass_kg - self.physics.slosh_mass_kg
        self._weight = moved * GRAVITY if self.physics.full else -combination.nose_load_n

    def _drag_speed(self, speed: float) -> float:
        """Integral of the speed controller that holds the speed against air drag, m."""
        area = sum(self.physics.drag_area_m2)
        mass = self.combination.car.mass_kg + self.combination.trailer.mass_kg
        force = 0.5 * col.AIR_DENSITY * area * speed**2 + self.physics.wheel_drag_n
        return float(force / (col.INTEGRAL_GAIN * mass))

    def run(self, inputs: Inputs) -> Motion:
        """Drive the combination from straight running.

        Parameters
        ----------
        inputs : see :class:`Inputs`; `time_s` gives start and end.

        Returns
        -------
        Motion
            Every 2 ms. Raises ``FloatingPointError`` when the motion has no finite solution.
        """
        time, rows = _input_rows(inputs)
        shortest = float(rows[:, col.U_SPEED].max()) * STEP_S / 2.5
        if any(0.0 < length < shortest for length in self.physics.relaxation_m):
            raise ValueError(f"relaxation lengths below {shortest:.3f} m need a shorter step")
        mujoco, _ = _library()
        mujoco.mj_resetData(self._model, self._data)
        self._data.qvel[0] = rows[0, col.U_SPEED]
        states = np.zeros(col.Z_SIZE)
        states[col.Z_SPEED] = self._drag_speed(float(rows[0, col.U_SPEED]))
        log = np.zeros((time.size, col.O_SIZE))
        k.run(self._scalars, self._wheels, rows, STEP_S, self._view, self._calls, states, log)
        if not np.all(np.isfinite(log)):
            raise FloatingPointError("the combination has left its valid range (overturned?)")
        return _motion(time, rows, log, self._weight)


def _slope(values: Array) -> Array:
    return np.asarray(np.gradient(values, STEP_S, axis=0, edge_order=2))


def _motion(time: Array, rows: Array, log: Array, weight_n: float) -> Motion:
    """Signals of a run from its log: accelerations and hitch forces from velocities, momenta."""
    yaw1, yaw2 = np.unwrap(log[:, col.O_YAW1]), np.unwrap(log[:, col.O_YAW2])

    def across(column: int, yaw: Array) -> Array:
        a = _slope(log[:, column : column + 2])
        return np.asarray(-np.sin(yaw) * a[:, 0] + np.cos(yaw) * a[:, 1])

    gap = log[:, col.O_FORCE_X : col.O_FORCE_X + 3] - _slope(
        log[:, col.O_MOMENTUM_X : col.O_MOMENTUM_X + 3]
    )
    c, s = np.cos(yaw1), np.sin(yaw1)
    wheels = {
        name: np.ascontiguousarray(log[:, start : start + 8].T)
        for name, start in (
            ("wheel_fy_n", col.O_FY),
            ("wheel_fz_n", col.O_FZ),
            ("wheel_slip_rad", col.O_SLIP),
            ("damper_travel_m", col.O_TRAVEL),
            ("damper_n", col.O_DAMPER),
        )
    }
    return Motion(
        time_s=time,
        steering_wheel_rad=rows[:, col.U_STEER].copy(),
        road_wheel_rad=log[:, col.O_STEER].copy(),
        speed_m_s=log[:, col.O_SPEED].copy(),
        yaw_rad=yaw1,
        trailer_yaw_rad=yaw2,
        yaw_rate_rad_s=log[:, col.O_RATE1].copy(),
        trailer_yaw_rate_rad_s=log[:, col.O_RATE2].copy(),
        roll_rad=log[:, col.O_ROLL1].copy(),
        trailer_roll_rad=log[:, col.O_ROLL2].copy(),
        car_acceleration_m_s2=across(col.O_CAR_VX, yaw1),
        rear_acceleration_m_s2=across(col.O_REAR_VX, yaw1),
        trailer_acceleration_m_s2=across(col.O_TRAILER_VX, yaw2),
        hitch_x_n=c * gap[:, 0] + s * gap[:, 1],
        hitch_y_n=-s * gap[:, 0] + c * gap[:, 1],
        hitch_z_n=gap[:, 2] - weight_n,
        harmonic_n=log[:, col.O_HARMONIC].copy(),
        **wheels,
    )
