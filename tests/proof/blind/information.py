"""How many standard deviations an effect leaves in its recordings, and beside the best wrong one.

An effect changes the recorded channels by d, in units of their noise. What is believed of vehicle
and sensors may move within its tolerance and takes a part of d away, at the price of its prior;
offsets of the sensors and of the steering and start values are free. What is left,

    detect^2 = min over z, n of |d - J z - N n|^2 + |roots z|^2,

is a generalised likelihood ratio (J, N: derivatives of the channels to beliefs and to what is
free; roots: of the prior). `name` is the least that is left when another effect, at whatever place
and of whatever size, may take its part too: the best wrong one. All is linearised at the truth;
noise counts as white at 50 Hz, as in the limits that the road recordings state.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swaywatch.effects.runs import BLOCK, RATE_HZ

Array = NDArray[np.float64]

NAMEABLE = 10.0
"""Standard deviations beside the best wrong effect from which on a name is asked for (issue 14)."""
NOISE_RATE_HZ = 50.0
#: Standard deviation of a mean of `BLOCK` samples over that of a sample of the noise.
BLOCK_NOISE = (BLOCK / RATE_HZ * NOISE_RATE_HZ) ** -0.5
#: Singular values, over the largest, and lengths, over what they were, that are rounding.
ROUNDING, GONE = 1e-9, 1e-6


@dataclass(frozen=True)
class Limit:
    """Of one concealed effect.

    Attributes
    ----------
    detect
        Standard deviations left.
    name
        The same beside the best wrong effect.
    best_wrong
        That effect.
    """

    detect: float
    name: float
    best_wrong: str


@dataclass(frozen=True)
class Wrong:
    """Directions of another explanation, shape (rows, parameters)."""

    name: str
    directions: Array


def basis(directions: Array) -> Array:
    """Orthonormal columns that span the directions, shape (rows, rank)."""
    size = np.linalg.norm(directions, axis=0)
    kept = directions[:, size > 0.0] / size[size > 0.0]
    if not kept.shape[1]:
        return np.zeros((directions.shape[0], 0))
    left, singular, _ = np.linalg.svd(kept, full_matrices=False)
    return np.asarray(left[:, singular > ROUNDING * singular[0]])


def beside(span: Array, vectors: Array) -> Array:
    """What is left of vectors beside a span; twice, for what rounding leaves."""
    for _ in range(2):
        vectors = vectors - span @ (span.T @ vectors)
    return np.asarray(vectors)


def with_prior(directions: Array, prior: Array) -> Array:
    """Rows of the prior below directions; its columns belong to the first of them."""
    below = np.zeros((prior.shape[0], directions.shape[1]))
    below[:, : prior.shape[1]] = prior
    return np.vstack([directions, below])


def limit_of(change: Array, nuisance: Array, wrong: Sequence[Wrong]) -> Limit:
    """Limit of one effect.

    Parameters
    ----------
    change
        What it makes of channels and priors, over their standard deviations, shape (rows,).
    nuisance
        Directions that take a part of it, priced by the rows of the prior, shape (rows, k).
    wrong
        The other explanations.
    """
    span = basis(nuisance)
    left = beside(span, change[:, np.newaxis])
    detect = float(np.linalg.norm(left))
    name, best = detect, ""
    usable = [w for w in wrong if np.isfinite(np.linalg.norm(w.directions))]
    columns = [w.directions / np.linalg.norm(w.directions, axis=0).clip(1e-300) for w in usable]
    all_left = beside(span, np.hstack(columns)) if columns else np.zeros((change.size, 0))
    first = 0
    for other, own in zip(usable, columns, strict=True):
        part = all_left[:, first : first + own.shape[1]]
        first += own.shape[1]
        part = part[:, np.linalg.norm(part, axis=0) > GONE]  # what the beliefs cannot do already
        size = float(np.linalg.norm(beside(basis(part), left)))
        if size < name:
            name, best = size, other.name
    return Limit(detect, name, best)
