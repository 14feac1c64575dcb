"""What a physics module is made of."""

from __future__ import annotations

import functools
import importlib
import math
import pkgutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from swaywatch.nearest import with_known
from swaywatch.plant.layout import AXLES, A, Array, P

ALWAYS = (-math.inf, math.inf)


@dataclass(frozen=True)
class PhysicsParameter:
    """A number of an effect: name with unit suffix, unit, bounds, start value for a fit."""

    name: str
    unit: str
    low: float
    high: float
    start: float
    windowed: bool = False
    """True: one value per time window."""
    meaning: str = ""


class Arrays:
    """The arrays of one model while effects write into them."""

    def __init__(self, p: Array, axles: Array) -> None:
        self.p = p
        self.axles = axles
        self.windows: list[tuple[float, ...]] = []

    def set(self, name: str, value: float) -> None:
        """Set a global parameter of :data:`swaywatch.plant.layout.P_NAMES`."""
        self.p[P[name]] = value

    def get(self, name: str) -> float:
        """Read a global parameter."""
        return float(self.p[P[name]])

    def set_axle(self, axle: str, name: str, value: float) -> None:
        """Set a parameter of one axle, or of ``"car"``, ``"trailer"`` or ``"all"``."""
        for number in axle_numbers(axle):
            self.axles[number, A[name]] = value

    def scale_axle(self, axle: str, name: str, factor: float) -> None:
        """Multiply a parameter of one axle or a group."""
        for number in axle_numbers(axle):
            self.axles[number, A[name]] *= factor


def axle_numbers(axle: str) -> tuple[int, ...]:
    """Axle numbers of an axle or a group of axles."""
    groups = {"car": (0, 1), "trailer": (2, 3), "all": (0, 1, 2, 3)}
    if axle in groups:
        return groups[axle]
    if axle not in AXLES:
        raise ValueError(f"axle {axle!r} is unknown{with_known(axle, (*AXLES, *groups))}")
    return (AXLES.index(axle),)


Apply = Callable[[Arrays, "PhysicsEffect"], None]


@dataclass(frozen=True)
class Module:
    """One physics module.

    Attributes
    ----------
    id : word for the effect, as in the recordings' list
    title : one line
    equation : as text, in SI units
    source : where it is from
    enters : where it acts in the double-track model
    parameters : numbers with bounds and units
    options : choices that are words, e.g. the axle
    apply : writes the effect into the model's arrays
    """

    id: str
    title: str
    equation: str
    source: str
    enters: str
    parameters: tuple[PhysicsParameter, ...]
    apply: Apply
    options: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def windowed(self) -> bool:
        """True if the effect acts in time windows."""
        return any(parameter.windowed for parameter in self.parameters)


@dataclass(frozen=True)
class Windowed:
    """Values of one time window of an effect, acting from ``start_s`` to ``stop_s``."""

    start_s: float
    stop_s: float
    values: Mapping[str, float]


@functools.cache
def modules() -> dict[str, Module]:
    """Every physics module by id: the files of this folder that start with no underscore."""
    names = sorted(info.name for info in pkgutil.iter_modules([str(Path(__file__).parent)]))
    room = __name__.rpartition(".")[0]
    return {
        name: importlib.import_module(f"{room}.{name}").MODULE
        for name in names
        if not name.startswith("_")
    }


def module(effect_id: str) -> Module:
    """The module of an effect; ValueError names the known ones."""
    if effect_id not in modules():
        raise ValueError(f"physics {effect_id!r} is unknown{with_known(effect_id, modules())}")
    return modules()[effect_id]


class PhysicsEffect:
    """A physics module with its values.

    Parameters
    ----------
    effect_id : a key of :data:`swaywatch.models.physics.MODULES`
    windows : for effects in time windows, a list of ``{"start_s", "stop_s", <parameter>: value}``.
        Without it the keyword values hold for the whole run.
    values : the module's parameters (float) and options (str)

    Raises
    ------
    ValueError
        Unknown effect, parameter or option; a value out of its bounds.
    """

    def __init__(
        self,
        effect_id: str,
        windows: Sequence[Mapping[str, float]] | None = None,
        **values: Any,
    ) -> None:
        self.module = module(effect_id)
        self.id = effect_id
        self.options: dict[str, str] = {}
        self.values: dict[str, float] = {}
        known = {parameter.name: parameter for parameter in self.module.parameters}
        for name, value in values.items():
            if name in self.module.options:
                self.options[name] = self._option(name, value)
            elif name in known:
                self.values[name] = self._number(known[name], value)
            else:
                hint = with_known(name, [*known, *self.module.options])
                raise ValueError(f"{effect_id}: no parameter {name!r}{hint}")
        for name, choices in self.module.options.items():
            self.options.setdefault(name, choices[0])
        self.windows = self._windows(windows, known)
        for parameter in self.module.parameters:
            if not parameter.windowed:
                self.values.setdefault(parameter.name, parameter.start)

    def _option(self, name: str, value: Any) -> str:
        choices = self.module.options[name]
        if value not in choices:
            raise ValueError(f"{self.id}: {name} = {value!r}; it can be: {', '.join(choices)}")
        return str(value)

    def _number(self, parameter: PhysicsParameter, value: Any) -> float:
        number = float(value)
        if not parameter.low <= number <= parameter.high:
            raise ValueError(
                f"{self.id}: {parameter.name} = {number:g} {parameter.unit} is outside "
                f"{parameter.low:g} to {parameter.high:g} {parameter.unit}"
            )
        return number

    def _windows(
        self, windows: Sequence[Mapping[str, float]] | None, known: Mapping[str, PhysicsParameter]
    ) -> tuple[Windowed, ...]:
        names = [parameter.name for parameter in self.module.parameters if parameter.windowed]
        if not names:
            if windows:
                raise ValueError(f"{self.id}: takes no time windows")
            return ()
        rows: Sequence[Mapping[str, float]] = windows if windows is not None else [{}]
        out = []
        for row in rows:
            unknown = set(row) - set(names) - {"start_s", "stop_s"}
            if unknown:
                raise ValueError(f"{self.id}: no window value {sorted(unknown)}; it has: {names}")
            values = {
                name: self._number(known[name], row[name])
                if name in row
                else self.values.get(name, known[name].start)
                for name in names
            }
            start, stop = row.get("start_s", ALWAYS[0]), row.get("stop_s", ALWAYS[1])
            if not start < stop:
                raise ValueError(f"{self.id}: window {start:g} to {stop:g} s has no length")
            out.append(Windowed(float(start), float(stop), values))
        return tuple(out)

    def __repr__(self) -> str:
        parts = [f"{key}={value!r}" for key, value in {**self.options, **self.values}.items()]
        parts += [f"[{w.start_s:g}-{w.stop_s:g} s: {dict(w.values)}]" for w in self.windows]
        return f"{self.id}({', '.join(parts)})"
