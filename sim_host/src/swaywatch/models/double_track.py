"""The plant as a simulator drives it: a car with a trailer (tandem or single axle) or without.

A front end of the compiled plant (`plant.lanes`, plant_step.h): it puts vehicle and switchable
physics (:mod:`swaywatch.models.physics`) into the plant's slots, prescribes the speed or leaves it
to a speed controller, and names what comes out. With no physics the tyres are linear and
proportional to load, roll does not act back on the motion, and the linear limit is the single
track; with ``sprung`` the bodies roll on springs.

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

from swaywatch.models.physics import PhysicsEffect
from swaywatch.models.physics._base import Arrays
from swaywatch.models.physics.steering_free_play import follow
from swaywatch.plant._plant import lib
from swaywatch.plant.lanes import AXLE, STATES
from swaywatch.plant.layout import (
    A_NAMES,
    BODIES,
    P_NAMES,
    W_BANK,
    W_BRAKE,
    W_COLUMNS,
    W_FRICTION,
    W_GENERATOR,
    W_GUST,
    W_HARMONIC,
    W_STIFFNESS,
    W_UNIT,
    WHEELS,
    A,
    Array,
    P,
)
from swaywatch.plant.stepping import COLUMNS, Generator, Setup, Stepping
from swaywatch.plant.vehicle_view import GRAVITY, BodyView, car_of, trailer_of
from swaywatch.vehicle import Vehicle

_REFERENCE = {W_GENERATOR: 0, W_UNIT: 1}
_COLUMN = {name: index for index, name in enumerate(COLUMNS)}
_CHANNELS = {
    "speed": "speed", "car_lateral_velocity": "lateral_velocity", "car_yaw_rate": "car_yaw_rate",
    "trailer_yaw_rate": "trailer_yaw_rate", "articulation": "articulation",
    "car_roll": "car_roll", "car_roll_rate": "car_roll_rate",
    "trailer_roll": "trailer_roll", "trailer_roll_rate": "trailer_roll_rate",
    "car_acceleration_x": "car_acceleration_x", "car_acceleration_y": "car_acceleration",
    "car_yaw_acceleration": "car_yaw_acceleration",
    "trailer_acceleration_x": "trailer_acceleration_x",
    "trailer_acceleration_y": "trailer_acceleration",
    "trailer_yaw_acceleration": "trailer_yaw_acceleration",
    "hitch_longitudinal_force": "hitch_x", "hitch_lateral_force": "hitch_y",
    "hitch_moment": "hitch_moment", "drive_force": "drive_force",
    "road_wheel_angle": "road_wheel_angle", "x": "path_x", "y": "path_y", "yaw": "heading",
    "trailer_sideslip": "trailer_sideslip", "bank": "bank",
}  # fmt: skip
"""Channel of a trace -> column of the plant."""
AIR_DENSITY = 1.2
SHORT_RELAXATION_M = 0.02  # below it none acts
_SLIP_ANGLES = ("slip_angle_f", "slip_angle_r", "slip_angle_tf", "slip_angle_tr")


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
    trailer as ``trailer_wheel_*``) and inner quantities such as ``road_wheel_angle``.
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
        if body == "trailer" and "articulation" in self.channels:
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
    """One simulation under way: time windows, free play and the plant itself."""

    def __init__(self, model: DoubleTrack, setup: Setup, step_s: float, steering: float) -> None:
        self.windows = model._windows
        self._p, self._step = model._p, step_s
        self._stepping = Stepping(setup, step_s)
        self._angle = steering

    def run(self, time: Array, steering: Array, speed: Array, rate: Array) -> Array:
        """Rows of outputs at fine times, `step_s` apart; the first is where it stands."""
        steer = self._behind_the_play(steering) / self._p[P["steering_ratio"]]
        return self._stepping.advance(speed, rate, steer, series_of(self.windows, time))

    def _behind_the_play(self, steering: Array) -> Array:
        gap, law = float(self._p[P["steering_gap"]]), float(self._p[P["steering_gap_law"]])
        if gap == 0.0 or law == 2.0:
            return steering
        out = np.empty(steering.size)
        for k, angle in enumerate(steering.tolist()):
            self._angle = follow(self._angle, angle, gap, law)
            out[k] = self._angle
        return out


def series_of(windows: Array, time: Array) -> dict[str, Array]:
    """Time-function slots of the plant from windows (`plant.layout`) at some times."""
    found: dict[str, Array] = {}

    def add(name: str, value: Array) -> None:
        found[name] = found.get(name, np.zeros(time.size)) + value

    def scale(name: str, factor: Array) -> None:
        found[name] = (1.0 + found.get(name, np.zeros(time.size))) * factor - 1.0

    for kind, number, start, stop, a, b, rise in windows:
        target = int(number)
        inside = (time >= start) & (time < stop)
        if kind == W_STIFFNESS:
            axle = ("car_front", "car_rear", "trailer_front", "trailer_rear")[target]
            scale(f"stiffness_{axle}", np.where(inside, a, 1.0))
        elif kind == W_FRICTION:
            scale("friction", np.where(inside, a, 1.0))
        elif kind == W_GUST:
            share = ramp(time, start, stop, rise)
            add(f"force_{BODIES[target]}", a * share)
            add(f"moment_{BODIES[target]}", b * share)
        elif kind == W_BANK:
            add("bank", a * ramp(time, start, stop, rise))
        elif kind == W_BRAKE:
            add(f"brake_{BODIES[target]}", a * ramp(time, start, stop, rise))
    return found


def ramp(time: Array, start: float, stop: float, rise: float) -> Array:
    """0 outside a window, 1 inside, cosine flanks of length ``rise`` inside it."""
    inside = (time >= start) & (time < stop)
    if rise <= 0.0:
        return inside.astype(float)
    edge = np.clip(np.minimum(time - start, stop - time) / rise, 0.0, 1.0)
    return np.where(inside, 0.5 - 0.5 * np.cos(np.pi * edge), 0.0)


def channel_columns(has_trailer: bool) -> dict[str, int]:
    """Channel of a trace -> column of what the plant gives; accelerations by place are made."""
    found = {
        name: _COLUMN[column]
        for name, column in _CHANNELS.items()
        if has_trailer or not name.startswith(("trailer_", "articulation", "hitch_"))
    }
    for axle in range(4 if has_trailer else 2):
        prefix = "" if axle < 2 else "trailer_"
        for side in range(2):
            wheel = WHEELS[2 * (axle % 2) + side]
            for channel, quantity in (("lateral_force", "lateral"), ("vertical_load", "vertical")):
                column = _COLUMN[_wheel(axle, quantity)] + side
                found[f"{prefix}wheel_{channel}_{wheel}"] = column
            found[f"{prefix}wheel_slip_{wheel}"] = _COLUMN[_SLIP_ANGLES[axle]]
    return found


class Stepper:
    """A simulation that goes on sample by sample (:meth:`DoubleTrack.stepper`).

    Attributes
    ----------
    time_s : time of the last sample
    sample : (len(COLUMNS),) array of that sample; :meth:`value` reads it by name
    """

    def __init__(
        self, model: DoubleTrack, work: _Work, spacing_s: float, sub: int, steering: float,
        speed: float,
    ) -> None:  # fmt: skip
        self._model, self._work, self._spacing = model, work, spacing_s
        self._part = np.arange(sub + 1) / sub
        self._count = 0
        self._steering, self._speed, self._rate = steering, speed, 0.0
        self.sample: Array = work.run(
            np.zeros(1), np.array([steering]), np.array([speed]), np.zeros(1)
        )[0]

    @property
    def time_s(self) -> float:
        """Time of the last sample since the start."""
        return self._count * self._spacing

    def advance(self, steering_wheel_angle_rad: float, speed_m_s: float) -> Array:
        """Go on to the next sample, to which both inputs run linearly; returns its outputs."""
        rate = (speed_m_s - self._speed) / self._spacing

        def between(old: float, new: float) -> Array:
            return old + (new - old) * self._part

        self.sample = self._work.run(
            self.time_s + self._spacing * self._part,
            between(self._steering, steering_wheel_angle_rad),
            between(self._speed, speed_m_s),
            between(self._rate, rate),
        )[-1]
        self._steering, self._speed, self._rate = steering_wheel_angle_rad, speed_m_s, rate
        self._count += 1
        return self.sample

    @property
    def is_whole(self) -> bool:
        """False once the motion has left all bounds."""
        return bool(np.isfinite(self.sample[0]))

    def trace(self, steering_rad: float) -> Trace:
        """The last sample's channels; `steering_rad` is the steering-wheel angle there."""
        return self._model.trace(
            np.array([self.time_s]), np.array([steering_rad]), self.sample[None, :]
        )

    def close(self) -> None:
        """Nothing is held."""

    def value(self, name: str) -> float:
        """A quantity of the last sample by the name of its channel."""
        return float(self.sample[_COLUMN[_CHANNELS[name]]])

    def axle_force(self, axle: int) -> float:
        """Side force in N of an axle (0..3) in the last sample."""
        left = _COLUMN[_wheel(axle, "lateral")]
        return float(self.sample[left] + self.sample[left + 1])

    def brake(self, body: str, force_n: float) -> None:
        """Brake a body with a force from now on; 0 releases it."""
        row = [float(W_BRAKE), float(BODIES.index(body)), self.time_s, math.inf, force_n, 0.0, 0.0]
        kept = [
            r
            for r in self._work.windows
            if not (r[0] == W_BRAKE and r[1] == row[1] and r[3] == math.inf)
        ]
        self._work.windows = np.array([*kept, row], dtype=float).reshape(-1, W_COLUMNS)


def _wheel(axle: int, quantity: str) -> str:
    """Column of the left wheel of an axle."""
    return f"{'' if axle < 2 else 'trailer_'}{quantity}_{'fl' if axle % 2 == 0 else 'rl'}"


class DoubleTrack:
    """The model with its vehicle and its physics; cheap to make, made once per parameter set.

    Parameters
    ----------
    vehicle : car with trailer or without
    physics : effects that are switched on; several act together
    car_roll, trailer_roll : roll and load transfer
    sprung : values of the sprung plant (`plant.sprung.defaults`); without them roll and load
        transfer follow the lateral acceleration as lags and do not act back on the motion
    car_acceleration_position_m, trailer_acceleration_position_m :
        where the roles ``*_lateral_acceleration`` are taken, ahead of the COG. The car's default
        is its rear axle.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        physics: Sequence[PhysicsEffect] = (),
        *,
        car_roll: BodyRoll = CAR_ROLL,
        trailer_roll: BodyRoll = TRAILER_ROLL,
        sprung: Mapping[str, float] | None = None,
        car_acceleration_position_m: float | None = None,
        trailer_acceleration_position_m: float = 0.0,
    ) -> None:
        self.vehicle = vehicle
        self.physics = tuple(physics)
        self.sprung = dict(sprung) if sprung else None
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
        sub = self._substeps(spacing, step_s, float(speed.max()))
        setup = self.setup(float(speed[0]), initial, speed_control)
        work = _Work(self, setup, spacing / sub, float(steering[0]))
        fine = np.arange((time_s.size - 1) * sub + 1) / sub
        whole = np.arange(time_s.size)
        raw = work.run(
            time_s[0] + fine * spacing,
            *(np.interp(fine, whole, values) for values in (steering, speed, rate)),
        )
        return self.trace(time_s, steering, raw[::sub])

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
        sub = self._substeps(spacing_s, step_s, speed_m_s)
        setup = self.setup(speed_m_s, initial, speed_control)
        work = _Work(self, setup, spacing_s / sub, steering_wheel_angle_rad)
        return Stepper(self, work, spacing_s, sub, steering_wheel_angle_rad, speed_m_s)

    def _substeps(self, spacing: float, step_s: float, speed: float) -> int:
        return max(1, math.ceil(spacing / self._step(step_s, speed) - 1e-9))

    def _step(self, step_s: float, speed: float) -> float:
        lengths = self._axles[:, A["relaxation"]]
        shortest = min((max(float(x), 0.15) for x in lengths if x > 0.0), default=math.inf)
        lag = self._p[P["suspension_lag"]] or math.inf
        return min(step_s, 1.5 * shortest / speed, 1.5 * lag)

    def setup(
        self,
        speed: float,
        initial: Mapping[str, float] | None = None,
        control: SpeedControl | None = None,
    ) -> Setup:
        """The plant's numbers for this vehicle with its physics, as :meth:`stepper` starts it."""
        p, axles = self._p, self._axles
        setup = Setup(_body_constants(p, axles))
        for name, value in _scalars(p, axles).items():
            setup.scalar(name, value)
        for k in range(4):
            for name in AXLE:
                setup.axles[k, AXLE.index(name)] = _axle_value(p, axles[k], name)
        self._springs(setup)
        setup.driven("suspension_lag", float(p[P["suspension_lag"]]))
        setup.driven("shape", float(p[P["saturation_shape"]]))
        if control is not None:
            setup.scalar("drag_area_car", control.car_drag_area_m2)
            setup.scalar("drag_area_trailer", control.trailer_drag_area_m2)
            for name, value in _control(control).items():
                setup.driven(name, value)
        setup.generator = self._generator()
        setup.state = self._initial(speed, initial, control)
        return setup

    def _springs(self, setup: Setup) -> None:
        """Values of the sprung plant; the dampers of its wheels make the damping of its roll."""
        if self.sprung is None:
            return
        for name, value in self.sprung.items():
            # sensors stand apart from the plant here (`simulate.sensors`)
            setup.scalar(name, 0.0 if name.startswith("sens") else value)
        tracks = ("track_car_front", "track_car_rear", "track_trailer", "track_trailer")
        for k, track in enumerate(tracks):
            body, half = BODIES[k // 2], 0.5 * self.sprung[track]
            front = self.sprung[f"roll_damping_share_{body}"]
            share = front if k % 2 == 0 else 1.0 - front
            setup.axles[k, AXLE.index("half_track")] = half
            if self._p[P["heave"]] > 0.0:
                rate = share * self.sprung[f"roll_damping_rate_{body}"] / (2.0 * half**2)
                setup.axles[k, AXLE.index("damper")] = rate

    def _generator(self) -> Generator | None:
        rows = [
            [_REFERENCE.get(int(w[0]), 2.0 + w[1]), w[1], w[2], w[3], w[4], w[5]]
            for w in self._windows
            if w[0] in (W_GENERATOR, W_UNIT, W_HARMONIC)
        ]
        if not rows:
            return None
        windows = np.array(rows, dtype=float)
        return Generator(
            windows, float(windows[:, 5].max()),
            float(self._p[P["harmonic_mean_time"]]), float(self._p[P["harmonic_level_time"]]),
        )  # fmt: skip

    def _initial(
        self, speed: float, initial: Mapping[str, float] | None, control: SpeedControl | None
    ) -> Array:
        state = np.zeros(STATES)
        state[lib.X_SPEED] = speed
        if control is not None:
            weight = (self._p[P["m1"]] + self._p[P["m2"]]) * GRAVITY
            area = control.car_drag_area_m2 + control.trailer_drag_area_m2
            state[lib.X_DRIVE] = (
                0.5 * AIR_DENSITY * speed**2 * area + control.rolling_resistance * weight
            )
        places = {
            "car_lateral_velocity": (lib.X_SIDE, 1.0), "car_yaw_rate": (lib.X_YAW_1, 1.0),
            "trailer_yaw_rate": (lib.X_YAW_2, 1.0), "articulation": (lib.X_ARTICULATION, 1.0),
            "car_roll": self._roll_state(0), "trailer_roll": self._roll_state(1),
            "x": (lib.X_PLACE, 1.0), "y": (lib.X_PLACE + 1, 1.0), "yaw": (lib.X_HEADING, 1.0),
        }  # fmt: skip
        for name, value in (initial or {}).items():
            if name not in places:
                raise ValueError(f"initial {name!r} is unknown; known: {', '.join(places)}")
            place, factor = places[name]
            state[place] = factor * value
        self._settle_slips(state)
        return state

    def _roll_state(self, body: int) -> tuple[int, float]:
        """State that holds a body's roll, and its value per rad."""
        if self.sprung:
            return lib.X_ROLL + body, 1.0
        return lib.X_TRANSFER + body, 1.0 / float(self._p[P[f"roll_gain_{body + 1}"]])

    def _settle_slips(self, state: Array) -> None:
        """Start relaxed tyres at the slip of the initial motion."""
        speed, side, yaw = state[lib.X_SPEED], state[lib.X_SIDE], state[lib.X_YAW_1]
        theta = state[lib.X_ARTICULATION]
        hitch = side - self._p[P["lh1"]] * yaw
        trailer_x = math.cos(theta) * speed + math.sin(theta) * hitch
        trailer_y = (
            math.cos(theta) * hitch
            - math.sin(theta) * speed
            - self._p[P["lh2"]] * state[lib.X_YAW_2]
        )
        for axle in range(4):
            u, v, r = (speed, side, yaw) if axle < 2 else (trailer_x, trailer_y, state[lib.X_YAW_2])
            state[lib.X_SLIP + axle] = -math.atan2(v + r * self._axles[axle, A["x"]], u)

    def trace(self, time_s: Array, steering: Array, raw: Array) -> Trace:
        """Channels from rows of outputs, (n, len(COLUMNS)), as :class:`Stepper` gives them."""
        channels: dict[str, Array] = {"steering_wheel_angle": steering}
        has_trailer = self.vehicle.trailer is not None
        for name, column in channel_columns(has_trailer).items():
            channels[name] = raw[:, column]
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


def _control(control: SpeedControl) -> dict[str, float]:
    return {
        "free_speed": 1.0,
        "control_p": control.proportional_n_s_per_m,
        "control_i": control.integral_n_per_m,
        "feed_forward": control.feed_forward,
        "control_lag": control.lag_s,
        "force_max": control.force_max_n,
        "rolling_resistance": control.rolling_resistance,
    }


def _body_constants(p: Array, axles: Array) -> Array:
    """Constants of the combination in the order of `plant.lanes.BODY`."""
    rows = []
    for body in range(2):
        front, rear = axles[2 * body], axles[2 * body + 1]
        names = (f"m{body + 1}", f"iz{body + 1}")
        rows += [float(p[P[name]]) for name in names]
        rows += [front[A["x"]], -rear[A["x"]], float(p[P[f"lh{body + 1}"]])]
        rows += [front[A["stiffness"]], rear[A["stiffness"]]]
    return np.array([*rows, *axles[:, A["load"]]])


def _scalars(p: Array, axles: Array) -> dict[str, float]:
    """Scalar slots of the plant."""
    stiffness = float(p[P["steering_stiffness"]])
    drawbar = float(p[P["drawbar_stiffness"]])
    castors = p[P["steering_gap_law"]] == 2.0
    found = {
        "steering_flexibility": 1.0 / stiffness if stiffness > 0.0 else 0.0,
        "free_play": 0.5 * p[P["steering_gap"]] / p[P["steering_ratio"]] if castors else 0.0,
        "hitch_friction": p[P["hitch_friction"]],
        "hitch_sticking": p[P["hitch_friction_rate"]],
        "hitch_damping": p[P["hitch_damping"]],
        "drawbar_compliance": 1.0 / drawbar if drawbar > 0.0 else 0.0,
        "aero_side": p[P["aero_side_force"]], "aero_yaw": p[P["aero_yaw_moment"]],
        "bank_unsensed": 1.0,
    }  # fmt: skip
    for number, axle in enumerate(("car_front", "car_rear", "trailer_front", "trailer_rear")):
        found[f"transfer_{axle}"] = axles[number, A["transfer"]]
    for number, body in enumerate(BODIES, start=1):
        found[f"roll_gain_{body}"] = p[P[f"roll_gain_{number}"]]
        found[f"roll_frequency_{body}"] = p[P[f"roll_omega_{number}"]]
        found[f"roll_damping_{body}"] = p[P[f"roll_zeta_{number}"]]
    return {name: float(value) for name, value in found.items()}


def _axle_value(p: Array, axle: Array, name: str) -> float:
    """A value of `plant.lanes.AXLE`."""
    if name == "relaxation":
        length = float(axle[A["relaxation"]])
        return length if length > SHORT_RELAXATION_M else 0.0
    if name == "peak_friction_inverse":
        peak = float(axle[A["peak_friction"]])
        return 1.0 / peak if peak > 0.0 else 0.0
    if name.startswith(("heave", "damper")) and p[P["heave"]] == 0.0:
        return 0.0
    return float(axle[A[name]])


def _baseline(vehicle: Vehicle, car_roll: BodyRoll, trailer_roll: BodyRoll) -> Arrays:
    """Arrays of the model with linear, load-proportional tyres and no further physics."""
    car, trailer = car_of(vehicle), trailer_of(vehicle)
    p = np.zeros(len(P_NAMES))
    axles = np.zeros((4, len(A_NAMES)))
    arrays = Arrays(p, axles)
    for name, value in {
        "m1": car.mass, "iz1": car.yaw_inertia, "lh1": car.hitch_to_cog,
        "steering_ratio": vehicle.car.steering_ratio, "hitch_friction_rate": 0.01,
        "harmonic_mean_time": 1.0, "harmonic_level_time": 3.0,
        "saturation_shape": 1.35, "roll_gain_2": 1.0,
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


def _body(arrays: Arrays, body: int, data: BodyView, roll: BodyRoll) -> None:
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
            "damper": damping,
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
