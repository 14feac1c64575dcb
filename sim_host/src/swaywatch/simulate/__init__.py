"""The simulator: a scenario in TOML becomes a drive, with its driver, sensors and message times.

scenario -> manoeuvres (steering, speed, road, wind) -> driver and model -> sensors -> timing
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from swaywatch.simulate.run import simulate_scenario
    from swaywatch.simulate.scenario import Scenario, load_scenario

__all__ = ["Scenario", "load_scenario", "simulate_scenario"]


def __getattr__(name: str) -> Any:
    """Load the simulator when it is asked for: the feed of a recording does without it."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from swaywatch.simulate import run, scenario

    return getattr(run if name == "simulate_scenario" else scenario, name)
