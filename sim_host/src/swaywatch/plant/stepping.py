"""One simulation of the plant that goes on a few samples at a time, with all that drives it.

A fit prescribes what a recording says; a simulator closes loops: a driver, a speed controller, an
ECU that brakes, an axle load that the motion itself makes. It steps the same compiled plant with
what only it needs switched on (`lanes.AXLE`, `lanes.DRIVE`, outputs `lanes.BEYOND`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from swaywatch.plant._plant import ffi, lib
from swaywatch.plant.lanes import (
    AXLE,
    BEYOND,
    DRIVE,
    OUTPUT,
    SCALARS,
    SERIES,
    SHAPE,
    STATES,
)

Array = NDArray[np.float64]

COLUMNS = (*OUTPUT, *BEYOND)
"""Columns of what a step gives."""
REFERENCES = 6
"""Rows of the generator's history: yaw rate as it is, the same normalised, the four axles."""


@dataclass
class Generator:
    """Axle loads at twice the yaw frequency that the motion makes (Eq. 6.1-6.2).

    Attributes
    ----------
    windows
        Rows of reference (row of the history), axle, start and stop in s, N per unit, delay in s.
    longest_s
        Longest delay.
    mean_time_s, level_time_s
        Of the high-pass and of the level that normalises it.
    """

    windows: Array
    longest_s: float
    mean_time_s: float
    level_time_s: float


@dataclass
class Setup:
    """What stays while the simulation goes on.

    Attributes
    ----------
    body, scalars
        As of `plant.lanes.PlantInput`.
    axles, drive
        Shapes (4, len(AXLE)) and (len(DRIVE),).
    generator
        Or None.
    state
        At the start, shape (STATES,).
    """

    body: Array
    scalars: Array = field(default_factory=lambda: np.zeros(len(SCALARS)))
    axles: Array = field(default_factory=lambda: np.zeros((4, len(AXLE))))
    drive: Array = field(default_factory=lambda: np.zeros(len(DRIVE)))
    generator: Generator | None = None
    state: Array = field(default_factory=lambda: np.zeros(STATES))

    def scalar(self, name: str, value: float) -> None:
        """Set a scalar slot."""
        self.scalars[SCALARS.index(name)] = value

    def driven(self, name: str, value: float) -> None:
        """Set a value of `plant.lanes.DRIVE`."""
        self.drive[DRIVE.index(name)] = value


class Stepping:
    """The plant under way.

    Parameters
    ----------
    setup
        Vehicle and physics.
    step_s
        Integration step, and the spacing of the inputs.
    start_s
        Time of the first sample.
    """

    def __init__(self, setup: Setup, step_s: float, start_s: float = 0.0) -> None:
        self._step, self._time = step_s, start_s
        self._held: list[object] = []
        self._whole = ffi.new("plant_whole_t *")
        drive = setup.drive.copy()
        if drive[DRIVE.index("shape")] == 0.0:
            drive[DRIVE.index("shape")] = SHAPE
        self._whole.drive = drive.tolist()
        self._whole.generator = self._generator(setup.generator)
        self._lane = ffi.new("plant_lane_t *")
        self._lane.whole = self._whole
        self._lane.axles = self._pointer(setup.axles)
        self._lane.body = self._pointer(setup.body)
        self._lane.scalars = self._pointer(setup.scalars)
        self._lane.state = setup.state.tolist()
        self._lane.columns = len(COLUMNS)
        self._lane.column[0 : len(COLUMNS)] = list(range(len(COLUMNS)))
        self.lost = False

    def _pointer(self, value: Array) -> object:
        buffer = ffi.from_buffer("double[]", np.ascontiguousarray(value, dtype=float).copy())
        self._held.append(buffer)
        return buffer

    def _generator(self, given: Generator | None) -> object:
        if given is None:
            return ffi.NULL
        found = ffi.new("plant_generator_t *")
        self._held.append(found)
        found.windows, found.count = self._pointer(given.windows), given.windows.shape[0]
        found.length = int(given.longest_s / self._step) + 3
        history = ffi.new("double[]", REFERENCES * found.length)
        self._held.append(history)
        found.history = history
        found.mean_time_s, found.level_time_s = given.mean_time_s, given.level_time_s
        return found

    def advance(
        self, speed: Array, acceleration: Array, steer: Array, series: Mapping[str, Array]
    ) -> Array:
        """Go on over samples of which the first is the last one of the call before.

        Parameters
        ----------
        speed, acceleration, steer
            Speed that is prescribed (or asked for), its derivative, road-wheel angle; shape (n,),
            linear between samples.
        series
            Time-function slots, shape (n,).

        Returns
        -------
        Outputs at the samples, shape (n, len(COLUMNS)); NaN once the motion has left all bounds.
        """
        n = speed.size
        out = np.full((n, len(COLUMNS)), np.nan)
        if self.lost:
            return out
        lane, held = self._lane, []

        def pointer(value: Array) -> object:
            buffer = ffi.from_buffer("double[]", np.ascontiguousarray(value, dtype=float))
            held.append(buffer)
            return buffer

        lane.first, lane.stop = 0, n
        lane.speed, lane.acceleration = pointer(speed), pointer(acceleration)
        lane.steer = pointer(steer)
        for index, name in enumerate(SERIES):
            lane.series[index] = pointer(series[name]) if name in series else ffi.NULL
        lane.output = ffi.from_buffer("double[]", out, require_writable=True)
        self._whole.start_s = self._time
        lib.plant_lanes(lane, 1, self._step, 1)
        self._time += (n - 1) * self._step
        self._bounds(out)
        return out

    def _bounds(self, out: Array) -> None:
        """NaN from the first sample that no vehicle reaches; a divergence left zeros."""
        left = (np.abs(out[:, 3]) < 20.0) & (np.abs(out[:, 0]) < 200.0) & (np.abs(out[:, 2]) < 3.2)
        if self._lane.diverged:
            left[self._lane.at :] = False
        if not left.all():
            self.lost = True
            out[int(np.argmin(left)) :] = np.nan
