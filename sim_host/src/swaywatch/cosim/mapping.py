"""Which variable of an FMU plays which role: by the roles' names, or by a small TOML.

The TOML is a ``signals.toml`` whose ``[signals]`` are the FMU's outputs, and two tables more::

    [signals]
    car_yaw_rate = "vehicle.psi_dot"
    car_lateral_acceleration = { signal = "vehicle.ay", position = -1.383 }

    [inputs]                  # what drives it; steering_wheel_angle has to be there
    steering_wheel_angle = { signal = "delta_sw", unit = "deg", sign = -1 }
    speed = "v_set"

    [parameters]              # start values, in the FMU's own units
    "trailer.mass" = 1880.0
    "v_start" = "speed"       # or a role: its value where the drive begins

Without a table, variables named as the role are taken (an input also as ``target_<role>``), or as
the signal is that plays the role in the recording. ``<role>_rate`` is an input that takes the
derivative; ``car_brake_force`` and ``trailer_brake_force`` (N) take what an ECU brakes with.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from swaywatch.drive import UNITS, canonical_unit, read_mappings
from swaywatch.drive import Mapping as Entry
from swaywatch.errors import FmuError
from swaywatch.nearest import did_you_mean, with_known
from swaywatch.roles import CHANNELS
from swaywatch.toml_file import load_toml

STEERING = "steering_wheel_angle"
BRAKES = ("car_brake_force", "trailer_brake_force")
RATES = {f"{STEERING}_rate": "rad/s", "speed_rate": "m/s2"}
INPUT_UNITS = {
    **{name: kind.unit for name, kind in CHANNELS.items()},
    **RATES,
    **dict.fromkeys(BRAKES, "N"),
}
"""SI unit of everything that can be an input."""
_BASE = {
    "rad": [{}, {"rad": 1}], "rad/s": [{"s": -1}, {"rad": 1, "s": -1}], "m/s": [{"m": 1, "s": -1}],
    "m/s2": [{"m": 1, "s": -2}], "N": [{"kg": 1, "m": 1, "s": -2}],
}  # fmt: skip
"""Exponents of SI's base units in a role's unit, as FMI writes them."""
REALS = ("Real", "Float64", "Float32")


@dataclass(frozen=True)
class Wire:
    """A role and what plays it: the value in SI is `factor` times the variables' mean.

    `position_m` of an accelerometer, ahead of the body's COG; None: where the recording's is.
    """

    role: str
    variables: tuple[Any, ...]
    factor: float
    position_m: float | None = None


@dataclass(frozen=True)
class Wiring:
    """All roles of an FMU; `idle` are inputs that nothing drives."""

    inputs: tuple[Wire, ...]
    outputs: tuple[Wire, ...]
    parameters: dict[str, float | str] = field(default_factory=dict)
    idle: tuple[str, ...] = ()

    def has_input(self, role: str) -> bool:
        """Whether a role drives it."""
        return any(wire.role == role for wire in self.inputs)


def wire(
    description: Any, fmu: Path, toml: Path | None = None, recorded: Mapping[str, str] | None = None
) -> Wiring:
    """Roles of an FMU.

    Parameters
    ----------
    description : FMPy's model description
    fmu : its file, for messages
    toml : the mapping, or None: by names
    recorded : role -> signal of the recording

    Raises
    ------
    SwaywatchError
        An unknown role or variable, a unit that does not fit, no input for the steering.
    """
    content: dict[str, Any] = {}
    if toml is not None:
        content = load_toml(toml, FmuError, "mapping of an FMU")
        unknown = sorted(set(content) - {"signals", "inputs", "parameters", "dbc"})
        if unknown:
            hint = with_known(unknown[0], ("signals", "inputs", "parameters"))
            raise FmuError(f"{toml}: unknown key {unknown[0]!r}{hint}")
    finder = _VariableFinder(description, fmu, toml, recorded or {})
    inputs = finder.wires(content.get("inputs"), "input")
    if not any(w.role == STEERING for w in inputs):
        raise FmuError(
            f"{fmu}: no input for the role {STEERING}; its inputs: {finder.listed('input')}. Name "
            f'it in the file of --simulation-signals: [inputs] {STEERING} = "..."'
        )
    outputs = finder.wires(content.get("signals"), "output")
    if not outputs:
        raise FmuError(
            f"{fmu}: no output is named as a role; its outputs: {finder.listed('output')}. Name "
            'them in the file of --simulation-signals: [signals] car_yaw_rate = "..."'
        )
    driven = {variable.name for w in inputs for variable in w.variables}
    idle = tuple(v.name for v in finder.by_name.values()
                 if v.causality == "input" and v.name not in driven)  # fmt: skip
    return Wiring(inputs, outputs, finder.parameters(content.get("parameters", {})), idle)


class _VariableFinder:
    """Looks for variables in a model description."""

    def __init__(
        self, description: Any, fmu: Path, toml: Path | None, recorded: Mapping[str, str]
    ) -> None:
        self.by_name = {v.name: v for v in description.modelVariables}
        self._units = {unit.name: unit for unit in description.unitDefinitions or []}
        self._fmu, self._toml, self._recorded = fmu, toml, recorded

    def listed(self, causality: str) -> str:
        """Variables for a message."""
        found = [
            f"{v.name} [{_unit_name(v) or '-'}]"
            for v in self.by_name.values()
            if v.causality == causality
        ]
        return ", ".join(found[:12]) + (", ..." if len(found) > 12 else "") if found else "none"

    def wires(self, table: Any, causality: str) -> tuple[Wire, ...]:
        """Roles of one kind: those of the table, else by name."""
        if table is None:
            return tuple(self._by_name(causality))
        assert self._toml is not None
        kind = "inputs" if causality == "input" else "signals"
        known = INPUT_UNITS if causality == "input" else None
        entries = read_mappings(self._toml, table, kind, known)
        return tuple(self._wire(entry, causality) for entry in entries)

    def _by_name(self, causality: str) -> Iterable[Wire]:
        roles = INPUT_UNITS if causality == "input" else CHANNELS
        for role in roles:
            names = [role, f"target_{role}"] if causality == "input" else [role]
            names += [self._recorded[role]] if role in self._recorded else []
            for name in names:
                variable = self.by_name.get(name)
                if variable is not None and variable.causality == causality:
                    yield Wire(role, (variable,), self._factor(role, variable, None), None)
                    break

    def _wire(self, entry: Entry, causality: str) -> Wire:
        variables = tuple(self._variable(entry.channel, name, causality) for name in entry.signals)
        factors = {self._factor(entry.channel, v, entry.unit) for v in variables}
        if len(factors) > 1:
            raise FmuError(f"{self._toml}: {entry.channel}: variables to average differ in unit")
        return Wire(entry.channel, variables, factors.pop() * entry.factor, entry.position_m)

    def _variable(self, role: str, name: str, causality: str) -> Any:
        variable = self.by_name.get(name)
        if variable is None:
            hint = did_you_mean(name, self.by_name) or "."
            raise FmuError(
                f"{self._toml}: {role} = {name!r}, but {self._fmu} has no such variable{hint} Its "
                f"{causality}s: {self.listed(causality)}"
            )
        allowed = ("input",) if causality == "input" else ("output", "local")
        if variable.causality not in allowed:
            raise FmuError(
                f"{self._toml}: {role} = {name!r} is a variable of causality "
                f"{variable.causality} in {self._fmu}; an {causality} is needed"
            )
        return variable

    def _factor(self, role: str, variable: Any, unit: str | None) -> float:
        """Factor from the variable's unit to SI."""
        if variable.type not in REALS:
            raise FmuError(f"{self._fmu}: {variable.name} ({role}) is of type {variable.type}; a "
                           "real number is needed")  # fmt: skip
        wanted = INPUT_UNITS[role]
        name = unit or _unit_name(variable)
        text = canonical_unit(name or "")
        if text in UNITS[wanted]:
            return UNITS[wanted][text]
        base = getattr(self._units.get(name), "baseUnit", None) if unit is None else None
        if base is not None and _exponents(base) in _BASE[wanted] and base.offset == 0.0:
            return float(base.factor)
        said = f"has the unit {name!r}" if name else "has no unit"
        raise FmuError(
            f"{self._fmu}: variable {variable.name!r} {said}, but {role} needs one of: "
            f"{', '.join(UNITS[wanted])}. Is it the right variable? Otherwise set the unit in the "
            "file "
            f'of --simulation-signals: {role} = {{ signal = "{variable.name}", '
            f'unit = "{wanted}" }}'
        )

    def parameters(self, table: Any) -> dict[str, float | str]:
        """Start values, checked by name."""
        if not isinstance(table, dict):
            raise FmuError(f"{self._toml}: [parameters] must be a table")
        found: dict[str, float | str] = {}
        for name, value in table.items():
            variable = self.by_name.get(name)
            if variable is None or variable.causality not in ("parameter", "input", "local"):
                raise FmuError(
                    f"{self._toml}: [parameters] {name!r} is not a parameter of {self._fmu}"
                    + did_you_mean(name, self.by_name)
                )
            if isinstance(value, str) and value not in INPUT_UNITS:
                raise FmuError(
                    f"{self._toml}: [parameters] {name} = {value!r} must be a number, or a role "
                    "whose first value it takes, such as speed"
                )
            found[name] = self._start(name, variable, value)
        return found

    def _start(self, name: str, variable: Any, value: Any) -> float | str:
        if isinstance(value, str):
            self._factor(value, variable, None)
            return value
        if isinstance(value, (bool, int, float)) and abs(value) < 1e300:
            return float(value)
        raise FmuError(f"{self._toml}: [parameters] {name} = {value!r} must be a number")

    def in_unit(self, name: str, role: str, value: float) -> float:
        """A role's value in the unit of a variable."""
        return value / self._factor(role, self.by_name[name], None)


def start_values(
    description: Any, fmu: Path, wiring: Wiring, first: Mapping[str, float]
) -> dict[str, float]:
    """Parameters in the FMU's units; `first` are the roles' values where the drive begins, SI."""
    finder = _VariableFinder(description, fmu, None, {})
    found = {}
    for name, value in wiring.parameters.items():
        if isinstance(value, str):
            if value not in first:
                raise FmuError(f"{fmu}: parameter {name} takes the first value of {value}, which "
                               "was not recorded")  # fmt: skip
            found[name] = finder.in_unit(name, value, first[value])
        else:
            found[name] = value
    return found


def _unit_name(variable: Any) -> str | None:
    """Unit of a variable, or of its declared type."""
    own = variable.unit
    if own is None and getattr(variable, "declaredType", None) is not None:
        own = variable.declaredType.unit
    return None if own is None else str(own)


def _exponents(base: Any) -> dict[str, int]:
    names = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
    return {name: int(getattr(base, name)) for name in names if getattr(base, name)}
