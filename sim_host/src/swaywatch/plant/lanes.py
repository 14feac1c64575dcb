"""The car-trailer plant: exact large-angle kinematics, bodies on springs, wheel by wheel.

One compiled function (plant_step.h) holds every place ("slot") where physics can enter. An effect
enters by filling slots of a `PlantInput`: a number (`SCALARS`), or a function of time (`SERIES`:
a force, a factor on a stiffness, a wheel load, a slip angle); it needs no change here. Speed is
prescribed; there is no driver and no sensor: a diagnosis evaluates the plant ten thousand times.

Axes ISO 8855; articulation is psi_trailer - psi_car; hitch force is that of the trailer on the car
in car axes; roll is positive to the right, to the outside of a left turn. Equations: Newton-Euler
of two rigid bodies with a common point, Eq. 3.1-3.12 of the reference dissertation without its
small-angle steps. A body with a `sprung_mass` rolls about its roll axis: the five accelerations
(lateral, two yaws, two rolls) are coupled by a symmetric mass matrix, the ball's height over the
roll axes included; wheel loads come from springs, bars and dampers (roll, roll rate) and directly
through the roll axis (side force). `swaywatch.plant.sprung` has values and their tolerances. A
trailer of mass 0 is none: the car is alone. An axle without load is not there.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

try:
    from swaywatch.plant._plant import ffi, lib
except ImportError as missing:  # the package was not installed
    raise ImportError(
        "swaywatch's plant is not built; run `make setup-run` at the top of the repository"
    ) from missing

Array = NDArray[np.float64]

GRAVITY = 9.81
SHAPE = 1.35  # of the saturating characteristic, Pacejka's C
BLOCK = int(lib.PLANT_BLOCK)  # samples of one sum of the outputs
LANES = int(lib.PLANT_LANES)  # simulations side by side
AHEAD = 6  # rows of lanes that are begun before their outcomes are taken

#: Constants of the combination, in the order the kernel reads them.
BODY = (
    "car.mass", "car.yaw_inertia", "car.front_axle_to_cog", "car.rear_axle_to_cog",
    "car.hitch_to_cog", "car.front_cornering_stiffness", "car.rear_cornering_stiffness",
    "trailer.mass", "trailer.yaw_inertia", "trailer.front_axle_to_cog",
    "trailer.rear_axle_to_cog", "trailer.hitch_to_cog", "trailer.front_cornering_stiffness",
    "trailer.rear_cornering_stiffness", "car.front_axle_load", "car.rear_axle_load",
    "trailer.front_axle_load", "trailer.rear_axle_load",
)  # fmt: skip
AXLES = ("car_front", "car_rear", "trailer_front", "trailer_rear")

#: What a law can depend on: rad, rad/s; side-slip angles at the centres of gravity; the trailer's
#: heading from the start; slip angles of tyres.
LAW_OF = (
    "articulation", "articulation_rate", "yaw_rate_car", "yaw_rate_trailer", "sideslip_car",
    "sideslip_trailer", "steer", "roll_car", "roll_trailer", "heading", "slip_car_front",
    "slip_car_rear", "slip_trailer",
)  # fmt: skip
#: What it can depend on that is known only once the motion is solved, and so comes late by its lag:
#: lateral accelerations of the centres of gravity, m/s2; the trailer's side force on the ball, N.
LAW_FELT = ("lateral_acceleration_car", "lateral_acceleration_trailer", "hitch_force")
#: Where it can act: moment at the ball on the car (its opposite on the trailer), forces and moments
#: on the bodies, steering angles of axles.
LAW_TO = (
    "hitch", "force_car", "force_trailer", "moment_car", "moment_trailer", "slip_car_front",
    "slip_car_rear", "slip_trailer",
)  # fmt: skip
#: Scalar slots of missing physics, zero (or infinite, see `neutral`) in the baseline.
SCALARS = (
    "steering_flexibility",  # rad/N, road-wheel angle per front lateral force (Eq. 5.3)
    "free_play",  # rad at the road wheel, half gap, lost against the lateral force
    "hitch_friction",  # Nm
    "hitch_sticking",  # rad/s, articulation rate below which dry friction is not yet full
    "hitch_damping",  # Nms/rad
    "aero_side",  # -
    "aero_yaw",  # -
    "peak_friction_inverse",  # -, 0: tyre linear
    "degression",  # -
    "relaxation_car_front", "relaxation_car_rear", "relaxation_trailer",  # m
    "roll_steer_car_front", "roll_steer_car_rear", "roll_steer_trailer",  # rad/rad
    "transfer_car_front", "transfer_car_rear",  # N per m/s2, wheel load per side
    "transfer_trailer_front", "transfer_trailer_rear",
    "roll_gain_car", "roll_gain_trailer",  # rad per m/s2
    "roll_frequency_car", "roll_damping_car",  # rad/s, -
    "roll_frequency_trailer", "roll_damping_trailer",
    "steer_frequency_car", "steer_damping_car", "steer_frequency_trailer", "steer_damping_trailer",
    "observer_car", "observer_trailer",  # 1/s, pull of a yaw rate to the measured one (0: none)
    "bank_unsensed",  # 1: the accelerations are those of the motion, without gravity's part
    "sprung_mass_car", "sprung_mass_trailer",  # kg, 0: the body does not roll
    "sprung_height_car", "sprung_height_trailer",  # m, its centre of gravity over the roll axis
    "roll_inertia_car", "roll_inertia_trailer",  # kg m2, about that centre of gravity
    "roll_stiffness_car", "roll_stiffness_trailer",  # Nm/rad, springs and bars of both axles
    "roll_damping_rate_car", "roll_damping_rate_trailer",  # Nms/rad
    "roll_axis_height_car", "roll_axis_height_trailer",  # m over the road
    "roll_front_share_car", "roll_front_share_trailer",  # of the stiffness
    "roll_damping_share_car", "roll_damping_share_trailer",  # of the damping, at the front axle
    "track_car_front", "track_car_rear", "track_trailer",  # m
    "ball_height_car", "ball_height_trailer",  # m, ball over the roll axis
    "wheel_radius",  # m
    "sensed_roll_car", "sensed_roll_trailer",  # share of g sin(roll) in the accelerations
    "sensor_height_car", "sensor_height_trailer",  # m, accelerometer over the roll axis
    "wind_height_car", "wind_height_trailer",  # m, centre of the wind's side force over it
    "trail_car_front", "trail_car_rear", "trail_trailer",  # m, pneumatic trail without slip
    # a law: N, Nm or rad per unit of what it depends on, at 25 m/s; 0: there is none
    "law_gain",
    "law_shape",  # as in discover/grammar.py
    "law_bend",  # what it depends on, where it saturates or the dead zone ends
    # a free curve: its slope at nothing, what is added to either side of that, and how its slope
    # changes beyond each fifth of the bend, to the right and to the left
    "law_line", "law_of_size",
    *(f"law_{side}_{fifth}" for side in ("right", "left") for fifth in (1, 2, 3, 4, 5)),
    "law_speed_power",  # -1, 0, 1 or 2
    "law_lag",  # s
    # 1: of what it depends on only what has changed within the lag counts; 2: as a spring that
    # has the shape of the law makes a damper give way; 3: what it depends on is felt, and late; 4:
    # an oscillator follows it, of one over the lag in rad/s and the bend as its damping ratio
    "law_transient",
    *(f"law_of_{name}" for name in (*LAW_OF, *LAW_FELT)),  # weights of what it depends on
    "law_by",  # place, from 1 on, among all these of what multiplies it by its size; 0: nothing
    # above or below nothing: it does not multiply, but the law acts only while it is positive or
    # negative; one over what it takes to be
    "law_by_side",
    # above nothing: the size at which half of the law acts, all of it far beyond; below: less the
    # size from which on that multiplies
    "law_by_bend",
    *(f"law_to_{name}" for name in LAW_TO),  # where it acts
    "law_drag_trailer",  # 1/m, drag of the trailer's wheels for each Nm of a moment on it; 0: none
    "mode_mass_car", "mode_mass_trailer",  # kg, what swings sideways beside the body's own mass
    "mode_frequency_car", "mode_frequency_trailer",  # rad/s, the body held
    "mode_damping_car", "mode_damping_trailer",  # 1
    "mode_gap_car", "mode_gap_trailer",  # m either way, within which it is held less, ...
    "mode_within_car", "mode_within_trailer",  # by this share of the stiffness beyond; 0: free
    # stiffness to the right over that to the left, less one
    "mode_other_side_car", "mode_other_side_trailer",
    "mode_drag_car", "mode_drag_trailer",  # 1/m, its deceleration over the square of its rate
    "mode_friction_car", "mode_friction_trailer",  # m/s2, what friction on the floor takes
    # share of its stiffness that is friction, which slips after so many metres
    "mode_rubbing_car", "mode_rubbing_trailer", "mode_slips_car", "mode_slips_trailer",
    "mode_place_car", "mode_place_trailer",  # m ahead of the centre of gravity of the rest
    "sensor_ahead_car", "sensor_ahead_trailer",  # m, "centre of gravity" of the accelerations
    "drawbar_compliance",  # m/N, sideways at the ball; 0: rigid
    "drawbar_play",  # m either way, within which nothing holds the ball there
    "drawbar_friction",  # N, against its motion there
    "drawbar_other_side",  # stiffness to the right over that to the left, less one
    "drag_area_car", "drag_area_trailer",  # m2, drag coefficient times frontal area
    "front_drive",  # share of the drive that acts at the front wheels, along where they point
    "pitch_transfer",  # share of the moments of drag and drive that the axle loads carry
    # (rebound - compression) / (rebound + compression) of the dampers; 0: the body does not heave
    "damper_asymmetry_car", "damper_asymmetry_trailer",
    # share of the damping that the dampers on one side of an axle have lost, and what is added to
    # the asymmetry of an axle's dampers
    *(f"damper_{change}_{axle}" for change in ("lost_left", "lost_right", "changed")
      for axle in ("car_front", "car_rear", "trailer_front", "trailer_rear")),
    "heave_frequency_car_front", "heave_frequency_car_rear", "heave_frequency_trailer",  # rad/s
    "heave_damping_car", "heave_damping_trailer",  # 1
    "jacking_car", "jacking_trailer",  # of side force times roll, what lifts the body
    "load_by_struts",  # share of an extra axle load that lifts the body over it, where it heaves
)  # fmt: skip

#: Slots that are functions of time.
SERIES = (
    "stiffness_car_front", "stiffness_car_rear", "stiffness_trailer_front",
    "stiffness_trailer_rear",  # factor on the stiffness at unchanged load
    "load_car_front", "load_car_rear", "load_trailer_front", "load_trailer_rear",  # N
    "force_car", "moment_car", "force_trailer", "moment_trailer", "bank",  # N, Nm, rad
    "shift_car_front", "shift_car_rear", "shift_trailer_front", "shift_trailer_rear",  # N to right
    "heave_car_front", "heave_car_rear", "heave_trailer_front", "heave_trailer_rear",  # N, both
    "friction",  # factor - 1 on the peak friction
    "measured_car", "measured_trailer",  # rad/s, yaw rates for the observer
    "slip_car_front", "slip_car_rear", "slip_trailer_front", "slip_trailer_rear",  # rad
    "roll_moment_car", "roll_moment_trailer",  # Nm about the roll axis
    "brake_car", "brake_trailer",  # N, where the whole is simulated
    "law",  # factor - 1 on what a law makes, or on what holds a mass that swings
)  # fmt: skip

#: Columns of the result.
OUTPUT = (
    "lateral_velocity", "car_yaw_rate", "articulation", "trailer_yaw_rate",
    "lateral_fl", "lateral_fr", "lateral_rl", "lateral_rr", "lateral_tf", "lateral_tr",
    "vertical_fl", "vertical_fr", "vertical_rl", "vertical_rr",
    "hitch_x", "hitch_y", "car_acceleration", "trailer_acceleration",
    "car_yaw_acceleration", "trailer_yaw_acceleration", "car_roll", "trailer_roll",
    "slip_f", "slip_r", "slip_tf", "slip_tr",
    "trailer_lateral_fl", "trailer_lateral_fr", "trailer_lateral_rl", "trailer_lateral_rr",
    "trailer_vertical_fl", "trailer_vertical_fr", "trailer_vertical_rl", "trailer_vertical_rr",
    "car_roll_rate", "trailer_roll_rate",
)  # fmt: skip
#: Columns beyond `OUTPUT` of a simulation of the whole (`Whole`).
BEYOND = (
    "speed", "car_acceleration_x", "trailer_acceleration_x", "hitch_moment", "drive_force",
    "road_wheel_angle", "path_x", "path_y", "heading", "trailer_sideslip", "bank",
    "slip_angle_f", "slip_angle_r", "slip_angle_tf", "slip_angle_tr",
)  # fmt: skip
#: Values of each axle of the whole, in the order car front, car rear, trailer front, rear.
AXLE = (
    "relaxation", "peak_friction_inverse", "degression", "roll_steer", "half_track",
    "softening",  # 1, stiffness over sqrt(1 + softening (force / load)^2)
    "damper",  # Ns/m of one damper at the wheel
    "damper_left", "damper_right",  # what is left of them, 1
    "damper_asymmetry",  # (rebound - compression) / (rebound + compression)
    "heave_mass", "heave_omega", "heave_zeta",  # kg (0: no heave), rad/s, 1
)  # fmt: skip
#: Values of the whole beside its axles: drive, drag, what no fit needs.
DRIVE = (
    "free_speed",  # 1: the speed is a state under the controller, 0: prescribed
    "control_p", "control_i", "feed_forward", "control_lag",  # N s/m, N/m, 1, s
    "force_max", "rolling_resistance",  # N, 1
    "suspension_lag", "shape",  # s; Pacejka's C
)  # fmt: skip
ALL = tuple(range(len(OUTPUT)))
STATES = int(lib.PLANT_STATES)
_DOUBLES = ffi.typeof("double[]")
_SCALARS = {name: index for index, name in enumerate(SCALARS)}
_SERIES = {name: index for index, name in enumerate(SERIES)}
_RELAXATION = [index for name, index in _SCALARS.items() if name.startswith("relaxation")]
_ALONE = (
    "hitch_friction", "peak_friction_inverse", "law_gain", "law_of_roll_car", "law_of_roll_trailer",
    "mode_mass_car", "mode_mass_trailer", "drawbar_compliance",
)  # fmt: skip
_BEGIN = (
    "relaxation", "roll_steer", "aero", "steering_flex", "free_play", "sprung_mass", "trail_",
    "damper_",
)  # fmt: skip
#: Slots that the kernel calculates only where a simulation uses them.
_FEATURES = [index for name, index in _SCALARS.items() if name.startswith(_BEGIN) or name in _ALONE]
SHORT_RELAXATION_M = 0.4  # below it two samples are too long a step


#: What vehicle.toml does not say: load transfer and roll of a mid-size car (frequency and damping
#: as the wheel loads of the practice recordings show them; roll gain from these, a roll radius of
#: gyration of 0.57 m and a track of 1.55 m: m h / (I omega^2)) and of a caravan, 8.4 deg per g.
_TYPICAL = {
    "hitch_sticking": 0.01,
    "transfer_car_front": 435.0, "transfer_car_rear": 356.0,
    "transfer_trailer_front": 420.0, "transfer_trailer_rear": 390.0,
    "roll_gain_car": 0.0115, "roll_gain_trailer": 0.0150,
    "roll_frequency_car": 13.0, "roll_damping_car": 0.112,
    "roll_frequency_trailer": 13.0, "roll_damping_trailer": 0.112,
    "steer_frequency_car": 13.0, "steer_damping_car": 0.112,
    "steer_frequency_trailer": 9.0, "steer_damping_trailer": 0.3,
}  # fmt: skip


_NEUTRAL = np.array([_TYPICAL.get(name, 0.0) for name in SCALARS])


def neutral() -> Array:
    """Scalar slots of the baseline: nothing missing, typical load transfer."""
    return _NEUTRAL.copy()


@dataclass
class PlantInput:
    """What one simulation needs. All arrays of shape (n,), SI units.

    Attributes
    ----------
    period_s
        Grid period.
    speed, acceleration
        Prescribed longitudinal speed of the car's centre of gravity and its derivative.
    steer
        Road-wheel angle, rad.
    body
        Constants in the order of `BODY`.
    scalars
        Scalar slots in the order of `SCALARS`.
    series
        Time-function slots by name; absent ones are neutral.
    axles
        Values of `AXLE` for each axle, shape (4, len(AXLE)), in the place of the scalar slots for
        relaxation, peak friction, degression and roll steer; None: those slots.
    initial
        Lateral velocity, car yaw rate, articulation, trailer yaw rate at the first sample.
    """

    period_s: float
    speed: Array
    acceleration: Array
    steer: Array
    body: Array
    scalars: Array = field(default_factory=neutral)
    series: dict[str, Array] = field(default_factory=dict)
    axles: Array | None = None
    initial: Array = field(default_factory=lambda: np.zeros(4))

    def copy(self) -> PlantInput:
        """Another one that can be changed without this one."""
        return replace(
            self, body=self.body.copy(), scalars=self.scalars.copy(), series=dict(self.series)
        )

    def get(self, name: str) -> float:
        """A scalar slot."""
        return float(self.scalars[_SCALARS[name]])

    def scalar(self, name: str, value: float) -> None:
        """Set a scalar slot."""
        self.scalars[_SCALARS[name]] = value

    def add_series(self, name: str, value: Array) -> None:
        """Add to a time-function slot (factors are added as factor - 1)."""
        self.series[name] = self.series.get(name, 0.0) + value


_Kind = tuple[int, bool, bytes]  # stride, and what the kernel must calculate


@cache
def _cores(process: int) -> ThreadPoolExecutor:
    """Two rows of lanes at a time run without the interpreter's lock; no thread outlives a fork."""
    return ThreadPoolExecutor(2, f"plant-{process}")


@dataclass
class Job:
    """One simulation among several.

    Attributes
    ----------
    plant
        What is simulated.
    span
        First sample (a multiple of `BLOCK`) and the one after the last; None: all.
    state
        At the first sample, shape (states,); None: that of `plant.initial`.
    columns
        Outputs wanted at every sample beside the sums, by their index.
    states
        Whether the states are wanted too.
    """

    plant: PlantInput
    span: tuple[int, int] | None = None
    state: Array | None = None
    columns: tuple[int, ...] = ()
    states: bool = False


@dataclass
class Outcome:
    """What a simulation gave, indexed by the samples of the run; zeros where it did not go.

    Attributes
    ----------
    blocks
        Sums of the outputs over `BLOCK` samples each, shape (ceil(n / BLOCK), len(OUTPUT)).
    columns, output
        The wanted outputs at every sample, shape (n, columns), if any.
    states
        Shape (n, states), if wanted.
    """

    blocks: Array
    columns: tuple[int, ...]
    output: Array | None
    states: Array | None


def simulate(plant: PlantInput, *, fine: bool = True) -> Array:
    """Run the plant. Result of shape (n, len(OUTPUT)); zeros after a divergence.

    Not `fine` takes steps of two samples: half the time, up to 0.1 % off near the critical speed.
    """
    found = run_jobs([Job(plant, columns=ALL)], fine=fine)[0]
    assert found.output is not None
    return found.output


_Row = list[tuple[int, Job]]


def run_jobs(jobs: Sequence[Job], *, fine: bool = True) -> list[Outcome]:
    """Run several simulations side by side; the results are in the order of the jobs.

    What a simulation gives does not depend on the others.
    """
    found = dict(run_along(jobs, fine=fine))
    return [found[index] for index in range(len(jobs))]


def run_along(jobs: Iterable[Job], *, fine: bool = True) -> Iterator[tuple[int, Outcome]]:
    """Run simulations while further ones are being put together.

    Place and outcome of each, as they end: whoever makes the jobs and uses the outcomes does so
    while others run. `AHEAD` rows of lanes at the most are begun before their outcomes are taken.
    """
    rows: dict[tuple[int, _Kind], _Row] = {}
    begun: deque[tuple[_Row, Future[list[Outcome]]]] = deque()
    pool = _cores(os.getpid())

    def begin(stride: int, row: _Row) -> None:
        begun.append((row, pool.submit(_run, [job for _, job in row], stride)))

    def ended() -> Iterator[tuple[int, Outcome]]:
        row, outcomes = begun.popleft()
        yield from zip((index for index, _ in row), outcomes.result(), strict=True)

    for index, job in enumerate(jobs):
        kind = (_length(job), _kind(job, fine))
        row = rows.setdefault(kind, [])
        row.append((index, job))
        if len(row) == LANES:
            begin(kind[1][0], rows.pop(kind))
        if len(begun) > AHEAD:
            yield from ended()
    left: dict[_Kind, _Row] = {}
    for (_, kind_of_it), row in sorted(rows.items(), key=lambda item: -item[0][0]):
        left.setdefault(kind_of_it, []).extend(row)  # of unlike lengths, the longest together
    for kind_of_it, row in left.items():
        for at in range(0, len(row), LANES):
            begin(kind_of_it[0], row[at : at + LANES])
    while begun:
        yield from ended()


def _length(job: Job) -> int:
    """Samples."""
    return job.plant.speed.size if job.span is None else job.span[1] - job.span[0]


def _kind(job: Job, fine: bool) -> _Kind:
    """Stride, and what the kernel must calculate: jobs of one kind share its lanes."""
    scalars = job.plant.scalars
    axles = job.plant.axles
    found = scalars[_RELAXATION] if axles is None else axles[:, AXLE.index("relaxation")]
    lengths = [value for value in found.tolist() if value > 0.0]
    stride = 1 if fine or (lengths and min(lengths) < SHORT_RELAXATION_M) else 2
    used = (scalars[_FEATURES] != 0.0).tobytes()
    if axles is not None:
        used += np.any(axles != 0.0, axis=0).tobytes()
    return stride, bool(job.columns), used


def _run(jobs: Sequence[Job], stride: int) -> list[Outcome]:
    lanes = ffi.new("plant_lane_t[]", len(jobs))
    held: list[object] = []  # what the lanes point to

    def pointer(value: Array) -> object:
        buffer = ffi.from_buffer(_DOUBLES, np.ascontiguousarray(value, dtype=float))
        held.append(buffer)
        return buffer

    def room(rows: int, columns: int) -> tuple[Array, object]:
        array = np.zeros((rows, columns))
        buffer = ffi.from_buffer(_DOUBLES, array, require_writable=True)
        held.append(buffer)
        return array, buffer

    found = []
    for lane, job in zip(lanes, jobs, strict=True):
        plant = job.plant
        n = plant.speed.size
        lane.first, lane.stop = (0, n) if job.span is None else job.span
        lane.speed, lane.acceleration = (
            pointer(plant.speed),
            pointer(plant.acceleration),
        )
        lane.steer = pointer(plant.steer)
        lane.body, lane.scalars = pointer(plant.body), pointer(plant.scalars)
        if plant.axles is not None:
            lane.axles = pointer(plant.axles)
        for name, value in plant.series.items():
            whole = value if np.shape(value) == (n,) else np.broadcast_to(value, (n,))
            lane.series[_SERIES[name]] = pointer(whole)
        state = np.zeros(STATES)
        state[:4] = plant.initial
        lane.state = (state if job.state is None else job.state).tolist()
        blocks, lane.blocks = room(-(-n // BLOCK), len(OUTPUT))
        output = states = None
        if job.columns:
            output, lane.output = room(n, len(job.columns))
            lane.columns = len(job.columns)
            lane.column[0 : len(job.columns)] = list(job.columns)
        if job.states:
            states, lane.states = room(n, STATES)
        found.append(Outcome(blocks, job.columns, output, states))
    lib.plant_lanes(lanes, len(jobs), jobs[0].plant.period_s, stride)
    return found
