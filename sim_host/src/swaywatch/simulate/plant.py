"""What a loop steps sample by sample: our double track, or a user's FMU."""

from __future__ import annotations

from typing import Any, Protocol

from swaywatch.models.double_track import Trace


class Plant(Protocol):
    """A combination under way (`models.double_track.Stepper`, `cosim.plant.FmuPlant`)."""

    @property
    def time_s(self) -> float:
        """Time of the last sample since the start."""

    @property
    def is_whole(self) -> bool:
        """False once the motion has left all bounds."""

    def advance(self, steering_wheel_angle_rad: float, speed_m_s: float) -> Any:
        """Go on to the next sample, to which both inputs run linearly."""

    def value(self, name: str) -> float:
        """A quantity of the last sample by the name of its channel."""

    def axle_force(self, axle: int) -> float:
        """Side force in N of an axle in the last sample."""

    def brake(self, body: str, force_n: float) -> None:
        """Brake a body with a force from now on; 0 releases it."""

    def trace(self, steering_rad: float) -> Trace:
        """The last sample's channels."""

    def close(self) -> None:
        """Let go of what is held."""
