"""Axle loads of a vehicle's file as measurements: with masses and lengths they must balance.

Nobody weighs a vehicle that drives; but everybody who knows a mass has it from axle scales. What
the scales say binds both masses and both centres of gravity more closely than each is known alone.

Static balance, hitch load N = m_2 g - F_2 with F_2 on all axles of the trailer:
    F_2 (L + x) = m_2 g L,              x the (middle) axle behind the trailer's centre of gravity,
    F_f (l_f + l_r) = m_1 g l_r - N (l_h - l_r),    F_r = m_1 g + N - F_f.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.fit.beliefs import Belief, Beliefs, Weighing, moved
from swaywatch.plant.lanes import BODY, GRAVITY
from swaywatch.vehicle import Vehicle

Array = NDArray[np.float64]

#: One standard deviation of a stated axle load: axle scales, fuel and load after the weighing.
TOLERANCE = 0.01
#: Misfit of all stated loads, in squares of what the tolerances allow, beyond which they are not of
#: this vehicle.
FOREIGN = 16.0
#: The same up to which they are, with another mass.
FITTING = 9.0
MASSES = ("car.mass", "trailer.mass")
LIGHTEST = 0.3  # of the file's mass
_INDEX = {name: index for index, name in enumerate(BODY)}


def static_loads(body: Array) -> Array:
    """Front, rear and trailer axle load in N from masses and lengths, shape (3,).

    The two axles of a trailer share their load as the file says.
    """
    m1, lf, lr, lh = (
        body[_INDEX[f"car.{key}"]]
        for key in ("mass", "front_axle_to_cog", "rear_axle_to_cog", "hitch_to_cog")
    )
    m2, length, ahead, behind, own_front, own_rear = (
        body[_INDEX[f"trailer.{key}"]]
        for key in (
            "mass", "hitch_to_cog", "front_axle_to_cog", "rear_axle_to_cog", "front_axle_load",
            "rear_axle_load",
        )
    )  # fmt: skip
    front = own_front / max(own_front + own_rear, 1.0)
    middle = (1.0 - front) * behind - front * ahead
    trailer = m2 * GRAVITY * length / (length + middle)
    hitch = m2 * GRAVITY - trailer
    first = (m1 * GRAVITY * lr - hitch * (lh - lr)) / (lf + lr)
    return np.array([first, m1 * GRAVITY + hitch - first, trailer])


def _stated(vehicle: Vehicle) -> list[tuple[int, str, float]]:
    """Loads that the file itself states: place in `static_loads`, name, N."""
    car, trailer = vehicle.car, vehicle.trailer
    found = [
        (0, "car.front_axle_load", car.front_axle_load),
        (1, "car.rear_axle_load", car.rear_axle_load),
    ]
    if trailer is not None:
        single = trailer.front_axle_to_cog is None
        parts = [trailer.rear_axle_load, *([] if single else [trailer.front_axle_load])]
        if all(part is not None for part in parts):
            found.append((2, "trailer axle loads", sum(part or 0.0 for part in parts)))
    return [(at, name, value) for at, name, value in found if value is not None]


@dataclass(frozen=True)
class Weighed:
    """Beliefs with the stated axle loads as measurements.

    Attributes
    ----------
    beliefs
        Without the loads where these cannot belong to this vehicle.
    wrong
        Sentences on what is wrong with the loads.
    otherwise
        Beliefs with the loads and one mass far from the file's that they fit, and a sentence; None
        where no single mass makes them fit.
    """

    beliefs: Beliefs
    wrong: tuple[str, ...] = ()
    otherwise: tuple[Beliefs, str] | None = None


def weighed(beliefs: Beliefs, body: Array, vehicle: Vehicle) -> Weighed:
    """Beliefs with the stated axle loads as measurements, and what is wrong with these.

    Parameters
    ----------
    beliefs
        Of masses and lengths.
    body
        Constants in the order of `plant.lanes.BODY`.
    vehicle
        The file, whose axle loads may be left out.
    """
    stated = _stated(vehicle)
    if not stated or vehicle.trailer is None:
        return Weighed(beliefs)
    base = static_loads(body)
    found = []
    for at, name, value in stated:
        error = TOLERANCE * value
        row = []
        for belief in beliefs.items:
            if belief.kind == "vehicle" and not belief.name.endswith("steering_ratio"):
                change = float(static_loads(_after(body, belief))[at] - base[at])
                if change != 0.0:
                    row.append((belief.name, change / error))
        found.append(Weighing(name, float(value - base[at]) / error, tuple(row)))
    bound = replace(beliefs, weighings=tuple(found))
    if _foreign(beliefs, found)[0] <= FOREIGN:
        return Weighed(bound)
    worst = max(found, key=lambda w: abs(w.off))
    at, _, value = next(s for s in stated if s[1] == worst.name)
    wrong = (
        f"axle loads of the vehicle's file do not fit its masses and lengths: {worst.name} is "
        f"{value:.0f} N, masses and lengths make {base[at]:.0f} N"
    )
    return Weighed(beliefs, (f"{wrong}; the loads are left out",), _with_a_mass(bound, body, wrong))


def _with_a_mass(bound: Beliefs, body: Array, wrong: str) -> tuple[Beliefs, str] | None:
    """The beliefs with the one mass elsewhere that makes the loads fit best, and a sentence."""
    each = [(*_foreign(bound, bound.weighings, name), name) for name in MASSES]
    left, z, name = min(each)
    belief = bound.items[bound.at["vehicle", name]]
    factor = 1.0 + z * belief.tolerance
    if left > FITTING or factor < LIGHTEST:
        return None
    items = tuple(replace(b, centre=z) if b is belief else b for b in bound.items)
    mass = factor * body[_INDEX[name]]
    return replace(bound, items=items), (
        f"{wrong}; they fit {name} = {mass:.0f} kg, and so does the recording: "
        f"{factor:.3f} times the file's"
    )


def _after(body: Array, belief: Belief) -> Array:
    """Constants with a belief one tolerance off."""
    changed = body.copy()
    moved(changed, belief.name, belief.tolerance)
    return changed


def _foreign(
    beliefs: Beliefs, weighings: Sequence[Weighing], free: str = ""
) -> tuple[float, float]:
    """How far the loads are off, over what tolerances of values and scales allow, squared.

    With the value `free` wherever the loads put it, in tolerances: the second number.
    """
    place = {b.name: i for i, b in enumerate(beliefs.items) if b.kind == "vehicle"}
    rows = np.zeros((len(weighings), len(beliefs)))
    for i, weighing in enumerate(weighings):
        for name, slope in weighing.slopes:
            rows[i, place[name]] = slope
    off = np.array([w.off for w in weighings])
    spread = rows @ rows.T + np.eye(off.size)
    misfit = float(off @ np.linalg.solve(spread, off))
    if not free:
        return misfit, 0.0
    along = rows[:, place[free]]
    toward = np.linalg.solve(spread, along)
    power = float(along @ toward)
    z = float(toward @ off) / power if power > 0.0 else 0.0
    return misfit - z**2 * power, z
