"""The simulator: a scenario in TOML becomes a drive, with its driver, sensors and message times.

scenario -> manoeuvres (steering, speed, road, wind) -> driver and model -> sensors -> timing
"""

from __future__ import annotations

from swaywatch.simulate.run import simulate_scenario
from swaywatch.simulate.scenario import Scenario, load_scenario

__all__ = ["Scenario", "load_scenario", "simulate_scenario"]
