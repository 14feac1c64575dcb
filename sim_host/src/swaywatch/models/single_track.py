"""Linear single-track model of a car with a tandem-axle trailer, and its stability.

Source: N. Zhang, *Stability Investigation of Car-trailer Combinations based on Time-Frequency
Analysis*, TU Darmstadt 2015, Eq. 3.1-3.17, 3.38-3.44 and App. A.2 with two corrections: ``d21``
holds ``l_f1 + l_h1`` (printed: ``l_f1 + l_h2``), and the hitch angle is ``psi_2 - psi_1`` (Eq. 3.10
has the opposite sign, with which the printed matrices do not agree).

State ``x = [v_y1, psi_dot_1, theta_dot, theta]``, input: steering-wheel angle, all SI. A vehicle
without a trailer has the two states ``[v_y1, psi_dot_1]``. A single-axle trailer is a tandem
whose second axle has no stiffness.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swaywatch.plant.vehicle_view import car_of, trailer_of
from swaywatch.vehicle import Vehicle

Matrix = NDArray[np.float64]

PARAMETERS = (
    "m1", "m2", "iz1", "iz2", "lf1", "lr1", "lh1", "lf2", "lr2", "lh2",
    "cf1", "cr1", "cf2", "cr2",
)  # fmt: skip
"""Parameters of the sensitivity study (Eq. 3.44), in the order of Fig. 3-6."""


@dataclass(frozen=True)
class Mode:
    """One eigenvalue (or the upper one of a conjugate pair).

    Attributes
    ----------
    eigenvalue : complex
        1/s.
    damping_ratio : float
        -Re/|eigenvalue|; 1 for a stable real eigenvalue, -1 for an unstable one.
    frequency_hz : float
        Damped frequency Im/(2 pi).
    """

    eigenvalue: complex
    damping_ratio: float
    frequency_hz: float


@dataclass(frozen=True)
class SingleTrack:
    """Parameters in SI units, names as in Tables A and B of the source."""

    m1: float
    iz1: float
    lf1: float
    lr1: float
    lh1: float
    cf1: float
    cr1: float
    steering_ratio: float
    m2: float = 0.0
    iz2: float = 0.0
    lf2: float = 0.0
    lr2: float = 0.0
    lh2: float = 0.0
    cf2: float = 0.0
    cr2: float = 0.0
    has_trailer: bool = True

    @classmethod
    def of(cls, vehicle: Vehicle) -> SingleTrack:
        """Take the parameters of a vehicle as read by :mod:`swaywatch.vehicle`."""
        car, trailer = car_of(vehicle), trailer_of(vehicle)
        base = cls(
            m1=car.mass, iz1=car.yaw_inertia, lf1=car.front_axle_to_cog,
            lr1=car.rear_axle_to_cog, lh1=car.hitch_to_cog,
            cf1=car.front_cornering_stiffness, cr1=car.rear_cornering_stiffness,
            steering_ratio=vehicle.car.steering_ratio, has_trailer=False,
        )  # fmt: skip
        if trailer is None:
            return base
        return dataclasses.replace(
            base, m2=trailer.mass, iz2=trailer.yaw_inertia, lf2=trailer.front_axle_to_cog,
            lr2=trailer.rear_axle_to_cog, lh2=trailer.hitch_to_cog,
            cf2=trailer.front_cornering_stiffness, cr2=trailer.rear_cornering_stiffness,
            has_trailer=True,
        )  # fmt: skip

    def matrices(self, speed_m_s: float) -> tuple[Matrix, Matrix, Matrix]:
        """Matrices of ``M x' = D x + E u`` (Eq. 3.14, App. A.2 corrected).

        Returns
        -------
        M, D : (4, 4) arrays (2 x 2 without a trailer)
        E : (4,) array per rad of steering-wheel angle
        """
        v = speed_m_s
        if v <= 0.0:
            raise ValueError(f"speed {v} m/s: the single-track model needs a speed above zero")
        if not self.has_trailer:
            return self._car_matrices(v)
        cf1, cr1, cf2, cr2 = self.cf1, self.cr1, self.cf2, self.cr2
        front2, rear2 = self.lh2 - self.lf2, self.lh2 + self.lr2
        m = np.array([
            [self.m1 + self.m2, -self.m2 * (self.lh1 + self.lh2), -self.m2 * self.lh2, 0.0],
            [self.m1 * self.lh1, self.iz1, 0.0, 0.0],
            [
                -self.m2 * self.lh2,
                self.iz2 + self.m2 * self.lh2 * (self.lh1 + self.lh2),
                self.iz2 + self.m2 * self.lh2**2,
                0.0,
            ],
            [0.0, 0.0, 0.0, 1.0],
        ])  # fmt: skip
        both = cf2 * front2 + cr2 * rear2
        d = np.zeros((4, 4))
        d[0, 0] = -(cf1 + cr1 + cf2 + cr2) / v
        d[1, 0] = -(cf1 * (self.lf1 + self.lh1) + cr1 * (self.lh1 - self.lr1)) / v
        d[2, 0] = both / v
        d[0, 1] = (
            -cf1 * self.lf1 + cr1 * self.lr1
            + cf2 * (self.lh1 + front2) + cr2 * (self.lh1 + rear2)
            - (self.m1 + self.m2) * v**2
        ) / v  # fmt: skip
        d[1, 1] = (
            -cf1 * self.lf1 * (self.lf1 + self.lh1)
            + cr1 * self.lr1 * (self.lh1 - self.lr1)
            - self.m1 * self.lh1 * v**2
        ) / v
        d[2, 1] = (
            -cf2 * front2 * (self.lh1 + front2)
            - cr2 * rear2 * (self.lh1 + rear2)
            + self.m2 * self.lh2 * v**2
        ) / v
        d[0, 2] = both / v
        d[2, 2] = -(cf2 * front2**2 + cr2 * rear2**2) / v
        d[0, 3] = cf2 + cr2
        d[2, 3] = -both
        d[3, 2] = 1.0
        e = np.array([cf1, cf1 * (self.lf1 + self.lh1), 0.0, 0.0]) / self.steering_ratio
        return m, d, e

    def _car_matrices(self, v: float) -> tuple[Matrix, Matrix, Matrix]:
        cf, cr, lf, lr = self.cf1, self.cr1, self.lf1, self.lr1
        m = np.diag([self.m1, self.iz1])
        d = np.array([
            [-(cf + cr) / v, (cr * lr - cf * lf) / v - self.m1 * v],
            [(cr * lr - cf * lf) / v, -(cf * lf**2 + cr * lr**2) / v],
        ])  # fmt: skip
        return m, d, np.array([cf, cf * lf]) / self.steering_ratio

    def state_space(self, speed_m_s: float) -> tuple[Matrix, Matrix]:
        """``A`` (n, n) and ``B`` (n,) of Eq. 3.16-3.17."""
        m, d, e = self.matrices(speed_m_s)
        return np.asarray(np.linalg.solve(m, d), float), np.asarray(np.linalg.solve(m, e), float)

    def modes(self, speed_m_s: float) -> list[Mode]:
        """Modes, the least damped first (Eq. 3.38-3.42); a pair counts once."""
        eigenvalues = np.linalg.eigvals(self.state_space(speed_m_s)[0])
        upper = [complex(s) for s in eigenvalues if s.imag >= 0.0]
        modes = [Mode(s, -s.real / abs(s), s.imag / (2.0 * np.pi)) for s in upper]
        return sorted(modes, key=lambda mode: mode.damping_ratio)

    def critical_speed(self, low_m_s: float = 3.0, high_m_s: float = 120.0) -> float:
        """Speed in m/s at which the least damped mode has no damping left; inf if there is none."""
        if self.modes(low_m_s)[0].damping_ratio <= 0.0:
            raise ValueError(f"unstable already at {low_m_s} m/s")
        grid = np.linspace(low_m_s, high_m_s, 235)
        above = next((float(v) for v in grid if self.modes(v)[0].damping_ratio <= 0.0), None)
        if above is None:
            return float("inf")
        below, step = above - float(grid[1] - grid[0]), 1.0
        while step > 1e-9:
            middle = 0.5 * (below + above)
            if self.modes(middle)[0].damping_ratio > 0.0:
                below = middle
            else:
                above = middle
            step = above - below
        return 0.5 * (below + above)

    def sensitivity(self, name: str, relative: float = 0.01) -> float:
        """Change of critical speed in m/s when a parameter grows by ``relative`` (Eq. 3.44)."""
        grown = dataclasses.replace(self, **{name: getattr(self, name) * (1.0 + relative)})
        return grown.critical_speed() - self.critical_speed()

    def steady_state(self, speed_m_s: float) -> Matrix:
        """State per rad of *road-wheel* angle in steady cornering, ``-A^-1 B`` (Eq. 3.26-3.35)."""
        a, b = self.state_space(speed_m_s)
        return np.asarray(-np.linalg.solve(a, b) * self.steering_ratio)

    def root_locus(self, speeds_m_s: Sequence[float]) -> NDArray[np.complex128]:
        """All eigenvalues, shape (speeds, states), each row sorted by real part (Fig. 3-4)."""
        rows = [np.linalg.eigvals(self.state_space(v)[0]).astype(complex) for v in speeds_m_s]
        return np.array([row[np.argsort(row.real)] for row in rows])

    def run(
        self,
        time_s: Matrix,
        steering_wheel_angle_rad: Matrix,
        speed_m_s: float,
        initial: Sequence[float] | None = None,
    ) -> dict[str, Matrix]:
        """Exact response at constant speed to a steering angle that is linear between samples.

        Parameters
        ----------
        time_s : (n,) array, even
        steering_wheel_angle_rad : (n,) array
        initial : state at ``time_s[0]``, default zero

        Returns
        -------
        dict
            Roles of recordings (SI): yaw rates, lateral accelerations at the COGs, articulation,
            and ``car_lateral_velocity``.
        """
        from scipy.signal import cont2discrete, lfilter

        a, b = self.state_space(speed_m_s)
        size = a.shape[0]
        step = float(time_s[1] - time_s[0])
        ad, bd, _, dd, _ = cont2discrete(
            (a, b[:, None], np.eye(size), np.zeros((size, 1))), step, method="foh"
        )
        u = np.asarray(steering_wheel_angle_rad, dtype=float)
        # The first-order-hold form carries a shifted state, x = z + D u; its modes run apart.
        start = np.zeros(size) if initial is None else np.asarray(initial, float) - dd[:, 0] * u[0]
        poles, shapes = np.linalg.eig(ad)
        gains, begin = np.linalg.solve(shapes, np.column_stack([bd[:, 0], start])).T
        runs = [
            lfilter([0.0, gain], [1.0, -pole], u, zi=[first])[0]
            for pole, gain, first in zip(poles, gains, begin, strict=True)
        ]
        states = (shapes @ np.array(runs)).real.T + np.outer(u, dd[:, 0])
        rates = states @ a.T + np.outer(u, b)
        out = {
            "car_lateral_velocity": states[:, 0],
            "car_yaw_rate": states[:, 1],
            "car_lateral_acceleration": rates[:, 0] + speed_m_s * states[:, 1],
        }
        if self.has_trailer:
            yaw_2 = states[:, 1] + states[:, 2]
            # Eq. 3.13 in the trailer's own axes: v_y2 = v_y,hitch - v theta - l_h2 psi_dot_2.
            v_dot = (
                rates[:, 0] - self.lh1 * rates[:, 1] - speed_m_s * states[:, 2]
                - self.lh2 * (rates[:, 1] + rates[:, 2])
            )  # fmt: skip
            out["trailer_yaw_rate"] = yaw_2
            out["articulation"] = states[:, 3]
            out["trailer_lateral_acceleration"] = v_dot + speed_m_s * yaw_2
        return out
