"""Eigenvalues of the plant about straight running, whatever physics its slots hold.

The plant is stepped once from the equilibrium with each state moved a little both ways, all side
by side in its lanes; the logarithms of the eigenvalues of that transition are those of the motion
(Eq. 3.38-3.43 of the reference dissertation without the single track's limits). Dry friction and
free play have no linear limit: they act here as for the smallest of motions, which they hold.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from swaywatch.models.single_track import Mode
from swaywatch.plant.lanes import STATES, Job, PlantInput, run_jobs

Array = NDArray[np.float64]

STEP_S = 0.002  # fastest state: relaxation of 0.15 m at 50 m/s
MOVED = 1e-6  # rad, rad/s, m/s
SLOWEST_M_S, FASTEST_M_S, SPACING_M_S = 4.0, 84.0, 5.0
CLOSE_M_S = 1e-4


def transitions(plants: Sequence[PlantInput], speeds: Sequence[float]) -> list[Array]:
    """Transition matrix over `STEP_S` of each plant at its speed, shape (states, states).

    Scalar slots and constants of the plants count; their courses in time do not.
    """
    jobs: list[Job] = []
    for plant, speed in zip(plants, speeds, strict=True):
        still = PlantInput(
            STEP_S, np.full(3, speed), np.zeros(3), np.zeros(3), plant.body, plant.scalars
        )
        both = np.vstack([MOVED * np.eye(STATES), -MOVED * np.eye(STATES)])
        jobs += [Job(still, state=moved, states=True) for moved in both]
    found = [outcome.states for outcome in run_jobs(jobs)]
    after = np.array([states[1] for states in found if states is not None])
    after = after.reshape(len(plants), 2, STATES, STATES)
    return [np.asarray((plus - minus).T / (2.0 * MOVED)) for plus, minus in after]


def eigenvalues(plants: Sequence[PlantInput], speeds: Sequence[float]) -> list[Array]:
    """Eigenvalues in 1/s of each plant at its speed; states that never move are left out."""
    found = []
    for matrix in transitions(plants, speeds):
        moves = ~np.all(matrix == np.eye(matrix.shape[0]), axis=1)
        part = matrix[np.ix_(moves, moves)].astype(complex)
        found.append(np.log(np.linalg.eigvals(part)) / STEP_S)
    return found


def modes(plant: PlantInput, speed_m_s: float) -> list[Mode]:
    """Modes of the plant at a speed, least damped first; of a conjugate pair the upper one."""
    return _sorted(eigenvalues([plant], [speed_m_s])[0])


def _sorted(values: Array) -> list[Mode]:
    upper = [complex(s) for s in values if s.imag >= -1e-9]
    found = []
    for s in sorted(upper, key=lambda s: -s.real / max(abs(s), 1e-12)):
        size = max(abs(s), 1e-12)
        found.append(Mode(s, -s.real / size, s.imag / (2.0 * np.pi)))
    return found


def _growth(plants: Sequence[PlantInput], speeds: Sequence[float]) -> Array:
    return np.array([float(values.real.max()) for values in eigenvalues(plants, speeds)])


def critical_speeds(plants: Sequence[PlantInput]) -> list[float]:
    """Lowest speed of each plant at which a mode does not decay, m/s; inf: none up to 84 m/s.

    All plants and speeds go through the lanes together.
    """
    grid = np.arange(SLOWEST_M_S, FASTEST_M_S + 1e-9, SPACING_M_S)
    every = [plant for plant in plants for _ in grid]
    growth = _growth(every, np.tile(grid, len(plants)).tolist()).reshape(len(plants), -1)
    first = [int(np.argmax(row > 0.0)) if (row > 0.0).any() else -1 for row in growth]
    low = np.array([grid[max(k - 1, 0)] for k in first])
    high = np.array([grid[k] for k in first])
    open_ = [k for k, index in enumerate(first) if index > 0]
    while open_ and float(np.max((high - low)[open_])) > CLOSE_M_S:
        middle = 0.5 * (low + high)
        unstable = _growth([plants[k] for k in open_], [float(middle[k]) for k in open_]) > 0.0
        for k, above in zip(open_, unstable, strict=True):
            (high if above else low)[k] = middle[k]
    return [
        float(0.5 * (low[k] + high[k])) if index > 0 else (SLOWEST_M_S if index == 0 else np.inf)
        for k, index in enumerate(first)
    ]


def critical_speed(plant: PlantInput) -> float:
    """Critical speed of one plant, see :func:`critical_speeds`."""
    return critical_speeds([plant])[0]
