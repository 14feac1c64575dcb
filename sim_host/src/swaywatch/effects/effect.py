"""What a module of the diagnosis is, and how modules are found.

A module is one file in `swaywatch.effects.library` with a list `EFFECTS` of `Effect` objects: one
for each component (axle, channel, body, vehicle value) that its id can act on.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from swaywatch.effects.runs import Run
    from swaywatch.plant.lanes import PlantInput

Array = NDArray[np.float64]
Values = Mapping[str, float]


@dataclass(frozen=True)
class Window:
    """A stretch of time of one run in which an effect acts, with its values there."""

    start: float
    stop: float
    values: Mapping[str, float]

    def mask(self, time: Array) -> Array:
        """1 inside, 0 outside, linear over one sample at the edges. Shape of `time`."""
        found = np.zeros_like(time)
        inside, share = self.part(time)
        found[inside] = share
        return found

    def part(self, time: Array) -> tuple[slice, Array]:
        """The samples that the window reaches, and `mask` of them; `time` is evenly spaced."""
        step = float(time[1] - time[0])
        first = int((self.start - time[0]) / step) - 1
        last = int((self.stop - time[0]) / step) + 3
        first, last = (min(max(i, 0), time.size) for i in (first, last))
        inside = slice(first, max(first, last))
        rise = np.clip((time[inside] - self.start) / step + 0.5, 0.0, 1.0)
        fall = np.clip((self.stop - time[inside]) / step + 0.5, 0.0, 1.0)
        return inside, np.minimum(rise, fall)

    def half_sine(self, time: Array) -> Array:
        """A half sine over the window. Shape of `time`."""
        x = (time - self.start) / max(self.stop - self.start, 1e-6)
        return np.where((x > 0.0) & (x < 1.0), np.sin(np.pi * np.clip(x, 0.0, 1.0)), 0.0)

    def one_minus_cosine(self, time: Array) -> Array:
        """(1 - cos) / 2 over the window. Shape of `time`."""
        return self.half_sine(time) ** 2

    def ramped(self, time: Array) -> Array:
        """Half-cosine ramps of `rise_s` about both edges, where it is at half. Shape of `time`."""
        rise = max(self.values["rise_s"], float(time[1] - time[0]))
        inside = np.minimum(time - self.start, self.stop - time) / rise + 0.5
        return np.asarray(0.5 - 0.5 * np.cos(np.pi * np.clip(inside, 0.0, 1.0)))


#: A least claim beyond which a value only shapes its effect.
SHAPING = 1e6


#: How an effect changes the plant of a run: its values, and the windows in which they hold.
Act = Callable[["PlantInput", "Run", Values, Sequence[Window]], None]


@dataclass(frozen=True)
class Parameter:
    """One free number of an effect.

    Attributes
    ----------
    name, unit
        As in the word list of the recordings.
    neutral
        Value at which the effect vanishes.
    low, high
        Bounds of the fit.
    starts
        Values from which fits start.
    scale
        Typical size of a noticeable change.
    minimum
        Smallest distance from `neutral` that is worth a claim.
    steepness
        Whether it says how steeply something rises to what it levels off at: a value at a bound is
        one that is too steep to be seen, not one that is none.
    """

    name: str
    unit: str
    neutral: float
    low: float
    high: float
    starts: tuple[float, ...]
    scale: float
    minimum: float = 0.0
    steepness: bool = False

    @property
    def shapes(self) -> bool:
        """A value that no claim rests on: it only shapes its effect."""
        return self.minimum >= SHAPING


#: Duration of the ramps of a window of the form "ramped": reported, never a claim by itself.
RISE = Parameter("rise_s", "s", 0.0, 0.0, 4.0, (0.3, 1.2), 0.3, 1e9)


def _nothing(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del plant, run, values, windows


def no_observation(outputs: dict[str, Array], run: Run, values: Values) -> None:
    """`observe` of an effect that leaves the sensors alone."""
    del outputs, run, values


def _identity(values: Values) -> dict[str, float]:
    return dict(values)


@dataclass(frozen=True)
class Effect:
    """One explanation: an id at one component.

    Attributes
    ----------
    id
        Word of the list.
    title
        What it is, in words; empty where a module of the simulator has the same id and its title.
    component
        Where: axle, channel, body or name of the vehicle value.
    kind
        "physics", "measurement" or "parameter".
    equation, source
        For the report.
    parameters
        Free numbers, empty for a template.
    act
        Fills slots of the plant before a simulation.
    observe
        Changes the channels after a simulation (measurement faults).
    windowed
        True: acts in time windows that have to be found; the values are then per window.
    lines
        Lines at which it shows in the residual map.
    needs
        Channels without which it cannot be tested.
    decided_by
        Measurement that tells it from its equivalents.
    report
        Maps fitted to reported values.
    plausibility
        Log prior weight among explanations of equal fit.
    extra
        What only some have: "form", "refine", "undo", "possible" (of values: no such effect can
        be stronger), "located" (names of values that say when or where), ...; "follows_motion"
        where `act` makes it of the run's own signals; "imitated_on_springs" where what a vehicle
        on springs is described by inexactly looks like it.
    on_springs
        The same as it is said beside a vehicle on springs, where that differs.
    """

    id: str
    component: str
    kind: str
    equation: str
    source: str
    parameters: tuple[Parameter, ...]
    act: Act = _nothing
    observe: Callable[[dict[str, Array], Run, Values], None] = no_observation
    windowed: bool = False
    lines: tuple[str, ...] = ("f",)
    needs: tuple[str, ...] = ()
    decided_by: str = ""
    report: Callable[[Values], dict[str, float]] = _identity
    plausibility: float = 0.0
    extra: dict[str, object] = field(default_factory=dict)
    on_springs: Effect | None = None
    title: str = ""

    @property
    def name(self) -> str:
        """Unique name: id and component."""
        return f"{self.id}:{self.component}" if self.component else self.id


def library(extra: Sequence[Effect] = ()) -> list[Effect]:
    """All effects of all modules, in alphabetical order of the files."""
    package = importlib.import_module("swaywatch.effects.library")
    effects: list[Effect] = []
    for info in sorted(pkgutil.iter_modules(package.__path__), key=lambda item: item.name):
        module = importlib.import_module(f"{package.__name__}.{info.name}")
        effects.extend(module.EFFECTS)
    return [*effects, *extra]
