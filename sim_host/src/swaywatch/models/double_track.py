"""Nonlinear double-track model of a car with a trailer (tandem or single axle) or without.

Exact kinematics for any articulation, four wheels on each body, load transfer through a rolling
body, prescribed speed or longitudinal dynamics under a speed controller, and the switchable
physics of :mod:`swaywatch.models.physics`. With none of them the tyres are linear and proportional
to load, and the model's linear limit is the single track.

    trace = DoubleTrack(vehicle, physics=[Effect("hitch_friction", moment_nm=130.0)]).run(
        time_s, steering_wheel_angle_rad, speed_m_s
    )
    trace["trailer_yaw_rate"]
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from swaywatch.models.layout import (
    A_NAMES,
    BODIES,
    O_FY,
    O_FZ,
    O_SLIP,
    OUTPUT,
    P_NAMES,
    S_DRIVE,
    S_PSI,
    S_R1,
    S_R2,
    S_ROLL1,
    S_ROLL2,
    S_SLIP,
    S_THETA,
    S_VX,
    S_VY,
    S_X,
    S_Y,
    STATES,
    W_BRAKE,
    W_COLUMNS,
    W_GENERATOR,
    W_HARMONIC,
    W_UNIT,
    WHEELS,
    A,
    Array,
    P,
)
from swaywatch.models.physics import Effect
from swaywatch.models.physics._base import Arrays
from swaywatch.models.vehicle_view import GRAVITY, Body, car_of, trailer_of
from swaywatch.vehicle import Vehicle

_GENERATORS = (W_GENERATOR, W_UNIT, W_HARMONIC)


@dataclass(frozen=True)
class BodyRoll:
    """Roll and load transfer of one body: what ``vehicle.toml`` does not say.

    Attributes
    ----------
    cog_height_m, track_m : load transfer in steady cornering is m a_y h / track
    front_share : share of the front axle in the load transfer
    roll_gradient_rad_per_m_s2 : roll angle per lateral acceleration
    roll_frequency_hz, roll_damping_ratio : of the body's roll
    heave_frequency_hz, heave_damping_ratio : of the body over each axle (damper physics only)
    """

    cog_height_m: float
    track_m: float
    front_share: float
    roll_gradient_rad_per_m_s2: float
    roll_frequency_hz: float
    roll_damping_ratio: float
    heave_frequency_hz: float = 1.4
    heave_damping_ratio: float = 0.3


CAR_ROLL = BodyRoll(0.63, 1.55, 0.55, 0.0089, 2.1, 0.115)
"""A mid-size car; the load transfer is that of the practice recordings."""
TRAILER_ROLL = BodyRoll(0.9, 2.0, 0.5, 0.0075, 1.5, 0.2)
"""A caravan."""


@dataclass(frozen=True)
class SpeedControl:
    """Speed controller with feed-forward on the deceleration (Zhang 2015, 5.2.5, Eq. 5.1-5.2).

    The drive force at the front wheels is P and I on the speed error, plus the drag, plus
    ``feed_forward`` (K_a) times the combination's mass times the deceleration, behind a lag.
    """

    proportional_n_s_per_m: float = 4000.0
    integral_n_per_m: float = 800.0
    feed_forward: float = 0.9
    lag_s: float = 0.05
    force_max_n: float = 9000.0
    car_drag_area_m2: float = 0.7
    trailer_drag_area_m2: float = 1.5
    rolling_resistance: float = 0.012


@dataclass(frozen=True)
class Trace(Mapping[str, Array]):
    """A simulated drive: channel name -> (n,) array, SI units, on ``time_s``.

    Holds the channels of :mod:`swaywatch.roles` (wheel forces of the car as ``wheel_*``, of the
    trailer as ``trailer_wheel_*``) and the inner quantities named in
    :data:`swaywatch.models.layout.O_NAMES`.
    """

    time_s: Array
    channels: dict[str, Array] = field(repr=False)

    def __getitem__(self, name: str) -> Array:
        return self.channels[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.channels)

    def __len__(self) -> int:
        return len(self.channels)

    @property
    def whole(self) -> bool:
        """False if the motion left all bounds; the samples after that are NaN."""
        return bool(np.isfinite(self.channels["car_yaw_rate"][-1]))

    def lateral_acceleration(self, body: str, position_m: float = 0.0) -> Array:
        """Lateral acceleration of ``"car"`` or ``"trailer"`` in its axes, ahead of its COG.

        As an accelerometer there feels it: with the road's bank, without the body's roll.
        """
        acceleration = self.channels[f"{body}_acceleration_y"]
        felt = GRAVITY * np.sin(self.channels["bank"])
        if body == "trailer":
            felt = felt * np.cos(self.channels["articulation"])
        return acceleration + position_m * self.channels[f"{body}_yaw_acceleration"] + felt

    def axle_force(self, axle: str) -> Array:
        """Sum of the side forces of an axle, e.g. ``"car_rear"``, in wheel axes."""
        return self._axle("wheel_lateral_force", axle)

    def axle_load(self, axle: str) -> Array:
        """Vertical load of an axle."""
        return self._axle("wheel_vertical_load", axle)

    def _axle(self, quantity: str, axle: str) -> Array:
        body, end = axle.split("_")
        prefix = "" if body == "car" else "trailer_"
        left, right = ("fl", "fr") if end == "front" else ("rl", "rr")
        return (
            self.channels[f"{prefix}{quantity}_{left}"]
            + self.channels[f"{prefix}{quantity}_{right}"]
        )


class _Work:
    """Arrays of one simulation under way."""

    def __init__(self, model: DoubleTrack, p: Array, state: Array, step_s: float) -> None:
        self.p, self.axles, self.windows = p, model._axles, model._windows
        self.state = state
        delays = self.windows[np.isin(self.windows[:, 0], _GENERATORS), 5]
        length = int(float(delays.max()) / step_s) + 3 if delays.size else 1
        self.history = np.zeros((6, length))
        self.means = np.zeros((2, 5))
        self.memory = np.zeros(2)

    def run(
        self, start: float, spacing: float, sub: int, steering: Array, speed: Array, rate: Array
    ) -> Array:
        from swaywatch.models.double_track_kernel import simulate

        return simulate(
            start, spacing, sub, steering, speed, rate, self.p, self.axles, self.windows,
            self.state, self.history, self.means, self.memory,
        )  # fmt: skip


class Stepper:
    """A simulation that goes on sample by sample (:meth:`DoubleTrack.stepper`).

    Attributes
    ----------
    time_s : time of the last sample
    sample : (OUTPUTS,) array of that sample; :meth:`value` reads it by name
    """

    def __init__(
        self, work: _Work, spacing_s: float, sub: int, steering: float, speed: float
    ) -> None:
        self._work, self._spacing, self._sub = work, spacing_s, sub
        self._count = 0
        self._steering = np.full(2, steering)
        self._speed = np.full(2, speed)
        self._rate = np.zeros(2)
        work.memory[1] = steering
        one = slice(0, 1)
        self.sample: Array = work.run(
            0.0, spacing_s, sub, self._steering[one], self._speed[one], self._rate[one]
        )[0]

    @property
    def time_s(self) -> float:
        """Time of the last sample since the start."""
        return self._count * self._spacing

    def advance(self, steering_wheel_angle_rad: float, speed_m_s: float) -> Array:
        """Go on to the next sample, to which both inputs run linearly; returns its outputs."""
        self._steering[0], self._steering[1] = self._steering[1], steering_wheel_angle_rad
        self._speed[0], self._speed[1] = self._speed[1], speed_m_s
        self._rate[0] = self._rate[1]
        self._rate[1] = (self._speed[1] - self._speed[0]) / self._spacing
        self.sample = self._work.run(
            self.time_s, self._spacing, self._sub, self._steering, self._speed, self._rate
        )[1]
        self._count += 1
        return self.sample

    def value(self, name: str) -> float:
        """An output of the last sample by name (:data:`swaywatch.models.layout.OUTPUT`)."""
        return float(self.sample[OUTPUT[name]])

    def axle_force(self, axle: int) -> float:
        """Side force in N of an axle (0..3) in the last sample."""
        return float(self.sample[O_FY + 2 * axle] + self.sample[O_FY + 2 * axle + 1])

    def brake(self, body: str, force_n: float) -> None:
        """Brake a body with a force from now on; 0 releases it."""
        row = [float(W_BRAKE), float(BODIES.index(body)), self.time_s, math.inf, force_n, 0.0, 0.0]
        kept = [
            r
            for r in self._work.windows
            if not (r[0] == W_BRAKE and r[1] == row[1] and r[3] == math.inf)
        ]
        self._work.windows = np.array([*kept, row], dtype=float).reshape(-1, W_COLUMNS)


class DoubleTrack:
    """The model with its vehicle and its physics; cheap to make, made once per parameter set.

    Parameters
    ----------
    vehicle : car with trailer or without
    physics : effects that are switched on; several act together
    car_roll, trailer_roll : roll and load transfer
    car_acceleration_position_m, trailer_acceleration_position_m :
        where the roles ``*_lateral_acceleration`` are taken, ahead of the COG. The car's default
        is its rear axle.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        physics: Sequence[Effect] = (),
        *,
        car_roll: BodyRoll = CAR_ROLL,
        trailer_roll: BodyRoll = TRAILER_ROLL,
        car_acceleration_position_m: float | None = None,
        trailer_acceleration_position_m: float = 0.0,
    ) -> None:
        self.vehicle = vehicle
        self.physics = tuple(physics)
        self.car_position_m = (
            -vehicle.car.rear_axle_to_cog
            if car_acceleration_position_m is None
            else car_acceleration_position_m
        )
        self.trailer_position_m = trailer_acceleration_position_m
        arrays = _baseline(vehicle, car_roll, trailer_roll)
        for effect in self.physics:
            effect.module.apply(arrays, effect)
        self._p, self._axles = arrays.p, arrays.axles
        self._windows = np.array(arrays.windows, dtype=float).reshape(-1, W_COLUMNS)

    def run(
        self,
        time_s: Array,
        steering_wheel_angle_rad: Array,
        speed_m_s: Array | float,
        *,
        initial: Mapping[str, float] | None = None,
        speed_cutoff_hz: float | None = 0.3,
        step_s: float = 0.005,
        speed_control: SpeedControl | None = None,
    ) -> Trace:
        """Simulate.

        Parameters
        ----------
        time_s : (n,) array with even spacing
        steering_wheel_angle_rad : (n,) array, linear between samples
        speed_m_s : number or (n,) array; prescribed, or what the controller is asked to hold
        initial : any of ``car_lateral_velocity``, ``car_yaw_rate``, ``trailer_yaw_rate``,
            ``articulation``, ``car_roll``, ``trailer_roll``, ``x``, ``y``, ``yaw``; the rest is 0
        speed_cutoff_hz : a prescribed speed is low-passed there without phase, because its
            derivative acts as a force; None takes it as it is
        step_s : longest integration step
        speed_control : None prescribes the speed; else the speed is a state

        Returns
        -------
        Trace on ``time_s``; NaN after the motion left all bounds.
        """
        time_s = np.asarray(time_s, dtype=float)
        steering = _like(time_s, steering_wheel_angle_rad, "steering_wheel_angle_rad")
        spacing = _even(time_s)
        speed = _like(time_s, speed_m_s, "speed_m_s")
        if speed_cutoff_hz is not None and np.ndim(speed_m_s) > 0:
            speed = _smooth(speed, spacing, speed_cutoff_hz)
        if float(speed.min()) < 0.5:
            raise ValueError(f"speed falls to {speed.min():.2f} m/s; the model needs 0.5 m/s")
        rate = np.gradient(speed, spacing) if speed.size > 1 else np.zeros(1)
        p = self._p
        if speed_control is not None:
            p = _controlled(p, speed_control)
        sub = self._substeps(spacing, step_s, float(speed.max()))
        work = _Work(self, p, self._initial(float(speed[0]), p, initial), spacing / sub)
        work.memory[1] = steering[0]
        raw = work.run(float(time_s[0]), spacing, sub, steering, speed, rate)
        return self.trace(time_s, steering, raw)

    def stepper(
        self,
        spacing_s: float,
        speed_m_s: float,
        *,
        steering_wheel_angle_rad: float = 0.0,
        initial: Mapping[str, float] | None = None,
        step_s: float = 0.005,
        speed_control: SpeedControl | None = None,
    ) -> Stepper:
        """Simulate sample by sample, for what closes a loop: a driver, a brake, an ECU."""
        p = self._p if speed_control is None else _controlled(self._p, speed_control)
        sub = self._substeps(spacing_s, step_s, speed_m_s)
        work = _Work(self, p, self._initial(speed_m_s, p, initial), spacing_s / sub)
        return Stepper(work, spacing_s, sub, steering_wheel_angle_rad, speed_m_s)

    def _substeps(self, spacing: float, step_s: float, speed: float) -> int:
        return max(1, math.ceil(spacing / self._step(step_s, speed) - 1e-9))

    def _step(self, step_s: float, speed: float) -> float:
        lengths = self._axles[:, A["relaxation"]]
        shortest = min((float(x) for x in lengths if x > 0.02), default=math.inf)
        lag = self._p[P["suspension_lag"]] or math.inf
        return min(step_s, 1.5 * shortest / speed, 1.5 * lag)

    def _initial(self, speed: float, p: Array, initial: Mapping[str, float] | None) -> Array:
        state = np.zeros(STATES)
        state[S_VX] = speed
        if p[P["free_speed"]] > 0.0:
            weight = p[P["m1"]] + p[P["m2"]]
            state[S_DRIVE] = (
                0.5 * p[P["air_density"]] * speed**2
                * (p[P["car_drag_area"]] + p[P["trailer_drag_area"]])
                + p[P["rolling_resistance"]] * weight * GRAVITY
            )  # fmt: skip
        places = {
            "car_lateral_velocity": S_VY, "car_yaw_rate": S_R1, "trailer_yaw_rate": S_R2,
            "articulation": S_THETA, "car_roll": S_ROLL1, "trailer_roll": S_ROLL2,
            "x": S_X, "y": S_Y, "yaw": S_PSI,
        }  # fmt: skip
        for name, value in (initial or {}).items():
            if name not in places:
                raise ValueError(f"initial {name!r} is unknown; known: {', '.join(places)}")
            state[places[name]] = value
        self._settle_slips(state)
        return state

    def _settle_slips(self, state: Array) -> None:
        """Start relaxed tyres at the slip of the initial motion."""
        theta = state[S_THETA]
        hitch = state[S_VY] - self._p[P["lh1"]] * state[S_R1]
        trailer_x = math.cos(theta) * state[S_VX] + math.sin(theta) * hitch
        trailer_y = (
            math.cos(theta) * hitch
            - math.sin(theta) * state[S_VX]
            - self._p[P["lh2"]] * state[S_R2]
        )
        for axle in range(4):
            u, v, r = (
                (state[S_VX], state[S_VY], state[S_R1])
                if axle < 2
                else (trailer_x, trailer_y, state[S_R2])
            )
            slip = -math.atan2(v + r * self._axles[axle, A["x"]], u)
            state[S_SLIP + 2 * axle : S_SLIP + 2 * axle + 2] = slip

    def trace(self, time_s: Array, steering: Array, raw: Array) -> Trace:
        """Channels from rows of outputs, (n, OUTPUTS), as :class:`Stepper` gives them."""
        channels: dict[str, Array] = {"steering_wheel_angle": steering}
        has_trailer = self.vehicle.trailer is not None
        for name, column in OUTPUT.items():
            if has_trailer or not name.startswith(("trailer_", "articulation", "hitch_")):
                channels[name] = raw[:, column]
        bodies = BODIES if has_trailer else BODIES[:1]
        for number, body in enumerate(bodies):
            prefix = "" if body == "car" else "trailer_"
            for k, wheel in enumerate(WHEELS):
                column = 4 * number + k
                channels[f"{prefix}wheel_lateral_force_{wheel}"] = raw[:, O_FY + column]
                channels[f"{prefix}wheel_vertical_load_{wheel}"] = raw[:, O_FZ + column]
                channels[f"{prefix}wheel_slip_{wheel}"] = raw[:, O_SLIP + column]
        trace = Trace(time_s, channels)
        channels["car_lateral_acceleration"] = trace.lateral_acceleration(
            "car", self.car_position_m
        )
        if has_trailer:
            channels["trailer_lateral_acceleration"] = trace.lateral_acceleration(
                "trailer", self.trailer_position_m
            )
        return trace


def _like(time_s: Array, value: Any, name: str) -> Array:
    array = np.ascontiguousarray(np.broadcast_to(np.asarray(value, dtype=float), time_s.shape))
    if not np.all(np.isfinite(array)):
        index = int(np.flatnonzero(~np.isfinite(array))[0])
        raise ValueError(f"{name} is not finite at {time_s[index]:.3f} s")
    return array


def _even(time_s: Array) -> float:
    if time_s.ndim != 1 or time_s.size < 2:
        raise ValueError("time_s needs at least two samples")
    spacing = float(time_s[-1] - time_s[0]) / (time_s.size - 1)
    if spacing <= 0.0 or float(np.abs(np.diff(time_s) - spacing).max()) > 1e-3 * spacing + 1e-6:
        raise ValueError("time_s must grow with even spacing; resample the drive first")
    return spacing


def _smooth(values: Array, spacing: float, cutoff_hz: float) -> Array:
    from scipy.signal import butter, sosfiltfilt

    nyquist = 0.5 / spacing
    if cutoff_hz >= nyquist or values.size < 16 or float(np.ptp(values)) == 0.0:
        return values
    sos = butter(2, cutoff_hz / nyquist, output="sos")
    padding = min(values.size - 1, int(3.0 / (cutoff_hz * spacing)))
    return np.asarray(sosfiltfilt(sos, values, padlen=padding))


def _controlled(p: Array, control: SpeedControl) -> Array:
    p = p.copy()
    for name, value in {
        "free_speed": 1.0,
        "control_p": control.proportional_n_s_per_m,
        "control_i": control.integral_n_per_m,
        "control_feed_forward": control.feed_forward,
        "control_lag": control.lag_s,
        "drive_force_max": control.force_max_n,
        "car_drag_area": control.car_drag_area_m2,
        "trailer_drag_area": control.trailer_drag_area_m2,
        "rolling_resistance": control.rolling_resistance,
    }.items():
        p[P[name]] = value
    return p


def _baseline(vehicle: Vehicle, car_roll: BodyRoll, trailer_roll: BodyRoll) -> Arrays:
    """Arrays of the model with linear, load-proportional tyres and no further physics."""
    car, trailer = car_of(vehicle), trailer_of(vehicle)
    p = np.zeros(len(P_NAMES))
    axles = np.zeros((4, len(A_NAMES)))
    arrays = Arrays(p, axles)
    for name, value in {
        "m1": car.mass, "iz1": car.yaw_inertia, "lh1": car.hitch_to_cog,
        "steering_ratio": vehicle.car.steering_ratio, "gravity": GRAVITY,
        "hitch_friction_rate": 0.01, "air_density": 1.2, "aero_area": 5.0,
        "harmonic_mean_time": 1.0, "harmonic_level_time": 3.0,
        "saturation_shape": 1.35,
        "iz2": 1.0, "roll_gain_2": 1.0,
    }.items():  # fmt: skip
        arrays.set(name, value)
    _body(arrays, 0, car, car_roll)
    if trailer is not None:
        arrays.set("has_trailer", 1.0)
        arrays.set("m2", trailer.mass)
        arrays.set("iz2", trailer.yaw_inertia)
        arrays.set("lh2", trailer.hitch_to_cog)
        _body(arrays, 1, trailer, trailer_roll)
    return arrays


def _body(arrays: Arrays, body: int, data: Body, roll: BodyRoll) -> None:
    arrays.p[P[f"roll_gain_{body + 1}"]] = roll.roll_gradient_rad_per_m_s2
    arrays.p[P[f"roll_omega_{body + 1}"]] = 2.0 * math.pi * roll.roll_frequency_hz
    arrays.p[P[f"roll_zeta_{body + 1}"]] = roll.roll_damping_ratio
    transfer = data.mass * roll.cog_height_m / roll.track_m
    omega = 2.0 * math.pi * roll.heave_frequency_hz
    # Dampers that make the roll's damping, equal at all four wheels.
    stiffness = data.mass * roll.cog_height_m / roll.roll_gradient_rad_per_m_s2
    damping = 2.0 * roll.roll_damping_ratio * stiffness / (2.0 * math.pi * roll.roll_frequency_hz)
    damping /= 4.0 * (0.5 * roll.track_m) ** 2
    rows = (
        (2 * body, data.front_axle_to_cog, data.front_axle_load,
         data.front_cornering_stiffness, roll.front_share),
        (2 * body + 1, -data.rear_axle_to_cog, data.rear_axle_load,
         data.rear_cornering_stiffness, 1.0 - roll.front_share),
    )  # fmt: skip
    for axle, x, load, stiffness, share in rows:
        mass = load / GRAVITY
        for name, value in {
            "x": x, "half_track": 0.5 * roll.track_m, "load": load, "stiffness": stiffness,
            "transfer": share * transfer, "heave_mass": mass, "heave_omega": omega,
            "heave_zeta": roll.heave_damping_ratio,
            "damping": damping,
            "damper_left": 1.0, "damper_right": 1.0,
        }.items():  # fmt: skip
            arrays.axles[axle, A[name]] = value


__all__ = [
    "CAR_ROLL",
    "TRAILER_ROLL",
    "BodyRoll",
    "DoubleTrack",
    "SpeedControl",
    "Stepper",
    "Trace",
]
