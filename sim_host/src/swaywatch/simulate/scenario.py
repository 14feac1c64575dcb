"""A scenario: everything one simulated drive needs, read from TOML.

::

    vehicle = "vehicle.toml"
    seed = 1
    duration_s = 38.0
    speed_kmh = 107.9
    model = "double_track"          # or "single_track", "multibody" (simulate/multibody.py), "fmu"
    speed_control = false           # true: longitudinal dynamics under the controller of 5.2.5

    [[manoeuvre]]
    kind = "impulse"
    start_s = 3.0
    angle_deg = 19.0

    [[physics]]
    id = "hitch_friction"
    moment_nm = 130.0

    [sprung]                        # bodies roll on springs; without it they do not act back
    roll_stiffness_car = 90e3       # any value of plant/sprung.py; the rest follows the vehicle

    [driver]
    kind = "lets_go"
    from_s = 4.0

    [sensors]
    preset = "typical"
    [sensors.car_yaw_rate]
    delay_s = 0.02

    [timing]
    rate_hz = 100.0
    jitter_s = 0.0005

``[reaction]``: see :mod:`swaywatch.simulate.closed_loop`; ``[expect]``:
:mod:`swaywatch.simulate.expectation`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from swaywatch.errors import ScenarioError
from swaywatch.models.physics import PhysicsEffect
from swaywatch.plant.layout import Array
from swaywatch.plant.sprung import defaults
from swaywatch.plant.vehicle_view import constants_of
from swaywatch.simulate.manoeuvres import Plan, make_plan
from swaywatch.simulate.table import Table
from swaywatch.simulate.timing import Timing, read_timing
from swaywatch.toml_file import load_toml
from swaywatch.vehicle import Vehicle
from swaywatch.vehicle_file import load_vehicle

MODELS = ("double_track", "single_track", "multibody", "fmu")
PLANT_RATE_HZ = 200.0


@dataclass(frozen=True)
class Scenario:
    """A drive to simulate.

    Attributes
    ----------
    plan : steering, speed, wind and road over time, on the plant's time axis
    physics : effects that act all along
    sprung : values of the sprung plant; None: roll follows the motion and does not act back
    fmu : the FMU and its roles where that is the model (simulate/closed_loop.py)
    driver, sensors, reaction, expect : tables that are read when the plant is known
    """

    name: str
    vehicle: Vehicle
    model: str
    seed: int
    duration_s: float
    start_s: float
    plan: Plan
    physics: tuple[PhysicsEffect, ...]
    speed_control: bool
    sprung: dict[str, float] | None
    fmu: tuple[Path, Path | None] | None
    multibody: dict[str, Any] = field(repr=False)
    driver: dict[str, Any] = field(repr=False)
    sensors: dict[str, Any] = field(repr=False)
    reaction: dict[str, Any] = field(repr=False)
    expect: dict[str, Any] = field(repr=False)
    timing: Timing

    @property
    def time_s(self) -> Array:
        """Time axis of the plant."""
        return self.plan.time_s


def load_scenario(path: Path | str, seed: int | None = None) -> Scenario:
    """Read and check a scenario.

    Parameters
    ----------
    path : the TOML file; a relative ``vehicle`` is relative to it
    seed : instead of the file's

    Raises
    ------
    ScenarioError, VehicleError
        Names file, key, value and what would be right.
    """
    path = Path(path)
    content = load_toml(path, ScenarioError, "scenario")
    return read_scenario(content, path.stem, path.parent, str(path), seed)


def read_scenario(
    content: dict[str, Any],
    name: str,
    folder: Path,
    place: str,
    seed: int | None = None,
    vehicle: Vehicle | None = None,
) -> Scenario:
    """A scenario from the content of its TOML; a vehicle given here replaces the file it names."""
    table = Table(content, place)
    file = table.raw("vehicle")
    if not isinstance(file, str):
        raise ScenarioError(f'{place}: vehicle is missing; e.g. vehicle = "vehicle.toml"')
    duration = table.number("duration_s", 1.0, 7200.0, "s")
    speed = table.number("speed_kmh", 5.0, 300.0, "km/h") / 3.6
    count = round(duration * PLANT_RATE_HZ) + 1
    time_s = np.arange(count) / PLANT_RATE_HZ
    number = table.number("seed", 0, 2**31, "1", 1)
    if vehicle is None:
        vehicle = load_vehicle(folder / file)
    scenario = Scenario(
        name=name,
        vehicle=vehicle,
        model=table.word("model", MODELS, MODELS[0]),
        seed=int(number) if seed is None else seed,
        duration_s=duration,
        start_s=table.number("start_unix_s", 0.0, 4e9, "s", 1_700_000_000.0),
        plan=make_plan(time_s, speed, table.tables("manoeuvre")),
        physics=tuple(_effect(entry) for entry in table.tables("physics")),
        speed_control=table.flag("speed_control", False),
        sprung=_sprung(table, vehicle) if table.has("sprung") else None,
        fmu=_fmu(table.table("fmu"), folder) if table.has("fmu") else None,
        multibody=table.raw("multibody", {}),
        driver=table.raw("driver", {}),
        sensors=table.raw("sensors", {}),
        reaction=table.raw("reaction", {}),
        expect=table.raw("expect", {}),
        timing=read_timing(table.table("timing")),
    )
    table.done()
    if scenario.model == "single_track":
        _check_single_track(scenario, place)
    if scenario.model in ("multibody", "fmu"):
        _check_own_physics(scenario, place)
    own = (("multibody", bool(scenario.multibody)), ("fmu", scenario.fmu is not None))
    for model, given in own:
        if given and scenario.model != model:
            raise ScenarioError(f"{place}: [{model}] needs model = {model!r}")
    if scenario.model == "fmu" and scenario.fmu is None:
        raise ScenarioError(f"{place}: model = 'fmu' needs [fmu] with file = \"my.fmu\"")
    return scenario


def _check_own_physics(scenario: Scenario, place: str) -> None:
    if scenario.physics or scenario.plan.effects or (scenario.fmu and scenario.sprung):
        its = "[multibody]" if scenario.model == "multibody" else "the FMU"
        raise ScenarioError(
            f"{place}: model = {scenario.model!r} has no [[physics]], [sprung], wind or road; its "
            f"own physics is in {its}"
        )


def _fmu(table: Table, folder: Path) -> tuple[Path, Path | None]:
    """The FMU and its roles, relative to the scenario."""
    files = [table.raw(key) for key in ("file", "signals")]
    table.done()
    if not isinstance(files[0], str) or not isinstance(files[1], (str, type(None))):
        raise ScenarioError(f'{table.place}: expected file = "my.fmu" and, if wanted, signals = '
                            '"my.toml"')  # fmt: skip
    return folder / files[0], None if files[1] is None else folder / files[1]


def _check_single_track(scenario: Scenario, place: str) -> None:
    if scenario.physics or scenario.plan.effects or scenario.speed_control:
        raise ScenarioError(
            f"{place}: model = 'single_track' has no physics, wind, road or speed control; "
            "use 'double_track'"
        )
    if np.ptp(scenario.plan.speed_m_s) > 0.0:
        raise ScenarioError(f"{place}: model = 'single_track' needs a constant speed")


def _effect(table: Table) -> PhysicsEffect:
    effect = table.raw("id")
    if not isinstance(effect, str):
        raise ScenarioError(f"{table.place}: id is missing, the name of a physics module")
    try:
        return PhysicsEffect(effect, **table.rest())
    except (ValueError, TypeError) as error:
        raise ScenarioError(f"{table.place}: {error}") from None


def _sprung(table: Table, vehicle: Vehicle) -> dict[str, float]:
    """Values of the sprung plant: those given, and the rest by their rules."""
    given = table.table("sprung")
    known = {name: given.number(name, 0.0, 1e7, "in SI units") for name in given.keys()}  # noqa: SIM118
    try:
        return defaults(constants_of(vehicle), known)
    except ValueError as error:
        raise ScenarioError(f"{given.place}: {error}") from None
