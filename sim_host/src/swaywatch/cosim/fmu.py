"""An FMU that is opened, started and stepped; what is wrong with it is said in a sentence."""

from __future__ import annotations

import importlib
import math
import shutil
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any
from xml.etree import ElementTree

from swaywatch.cosim.mapping import Wire, Wiring, start_values
from swaywatch.errors import FmuError
from swaywatch.recording.guard import must_be_regular

LONGEST_STEP_S = 0.05
"""A step beyond it cannot show a sway of 1 Hz."""


def _fmpy(module: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError:
        raise FmuError(
            "an FMU needs FMPy, which is not installed: pip install 'swaywatch[fmi]'"
        ) from None


@contextmanager
def _as_fmu_error(path: Path, what: str, messages: list[str]) -> Iterator[None]:
    """What FMPy or the FMU raises, as a sentence with what the FMU itself said."""
    try:
        yield
    except FmuError:
        raise
    except Exception as error:  # FMPy raises plain Exceptions, ctypes OSErrors
        own = "; the FMU said: " + " | ".join(messages[-3:]) if messages else ""
        raise FmuError(f"{path}: {what}: {error}{own}") from None


def _version(path: Path) -> str:
    """The version of FMI that it says it is made for."""
    with zipfile.ZipFile(path) as packed, packed.open("modelDescription.xml") as description:
        _, root = next(ElementTree.iterparse(description, events=("start",)))
    return str(root.attrib.get("fmiVersion", "unknown"))


class Fmu:
    """A co-simulation FMU on disk, unpacked while it is open (a context manager).

    Raises
    ------
    FmuError
        No FMU, another version of FMI than 2 or 3, no co-simulation, no binary for this machine.
    """

    def __init__(self, path: Path) -> None:
        must_be_regular(path, "FMU", FmuError)
        self.path = path
        self.messages: list[str] = []
        self._fmpy = _fmpy("fmpy")
        self._folder: str | None = None
        with _as_fmu_error(path, "not an FMU", self.messages):
            version = _version(path)
        if not version.startswith(("2.", "3.")):
            raise FmuError(f"{path}: made for FMI {version}; 2.0 or 3.0 is needed")
        with _as_fmu_error(path, "not an FMU", self.messages):
            self.description = self._fmpy.read_model_description(str(path), validate=False)
        if self.description.coSimulation is None:
            raise FmuError(
                f"{path}: for model exchange only (it brings no solver); export it for "
                "co-simulation"
            )
        self.version = int(version[0])
        there = self._fmpy.supported_platforms(str(path))
        if self._fmpy.platform not in there:
            raise FmuError(
                f"{path}: no binary for this machine ({self._fmpy.platform}); it has: "
                f"{', '.join(there) or 'none'}"
            )
        with _as_fmu_error(path, "does not meet its standard", self.messages):
            self._fmpy.read_model_description(str(path), validate=True)

    def __enter__(self) -> Fmu:
        with _as_fmu_error(self.path, "cannot be unpacked", self.messages):
            self._folder = self._fmpy.extract(str(self.path))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:  # fmt: skip
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)

    def step_s(self, wanted_s: float) -> float:
        """Longest step of communication up to `wanted_s` that the FMU takes."""
        experiment, own = self.description.defaultExperiment, self.description.coSimulation
        given = own.fixedInternalStepSize
        if given is None and experiment is not None:
            given = experiment.stepSize
        size = 0.0 if given is None else float(given)
        if not size > 0.0:
            return wanted_s
        if size > LONGEST_STEP_S:
            if own.canHandleVariableCommunicationStepSize:
                return wanted_s
            raise FmuError(f"{self.path}: takes steps of {size:g} s only; at most "
                           f"{LONGEST_STEP_S:g} s shows how a trailer sways")  # fmt: skip
        if own.canHandleVariableCommunicationStepSize:
            return min(wanted_s, size)
        return size * max(1, math.floor(wanted_s / size + 1e-9))

    def start(self, wiring: Wiring, first: Mapping[str, float]) -> Running:
        """Instantiate and initialise it; `first` are the roles' values at the beginning, SI."""
        simulation = _fmpy("fmpy.simulation")

        def note(*said: Any) -> None:
            text = said[-1]
            self.messages.append(text.decode(errors="replace") if isinstance(text, bytes) else
                                 str(text))  # fmt: skip

        values = start_values(self.description, self.path, wiring, first)
        with _as_fmu_error(self.path, "cannot be started", self.messages):
            instance = simulation.instantiate_fmu(
                self._folder, self.description, "CoSimulation",
                logger=note if self.version == 3 else None,
            )  # fmt: skip
            running = Running(self, instance, wiring)
            if self.version == 2:
                instance.setupExperiment(startTime=0.0)
                values = simulation.apply_start_values(
                    instance, self.description, values,
                    settable=simulation.settable_in_instantiated,
                )  # fmt: skip
                instance.enterInitializationMode()
            else:
                values = simulation.apply_start_values(
                    instance, self.description, values,
                    settable=simulation.settable_in_instantiated,
                )  # fmt: skip
                instance.enterInitializationMode(startTime=0.0)
            values = simulation.apply_start_values(
                instance, self.description, values,
                settable=simulation.settable_in_initialization_mode,
            )  # fmt: skip
            running.set(first)
            instance.exitInitializationMode()
        if values:
            raise FmuError(f"{self.path}: parameter {next(iter(values))} cannot be set")
        return running


class Running:
    """An FMU under way; `time_s` is where it stands."""

    def __init__(self, fmu: Fmu, instance: Any, wiring: Wiring) -> None:
        self._fmu, self._instance, self._wiring = fmu, instance, wiring
        self.time_s = 0.0

    def set(self, values: Mapping[str, float]) -> None:
        """Set inputs by role, SI; roles that drive nothing are passed over."""
        for wire in self._wiring.inputs:
            if wire.role in values:
                for variable in wire.variables:
                    self._write(variable, values[wire.role] / wire.factor)

    def step(self, values: Mapping[str, float], step_s: float) -> None:
        """Set inputs and go on."""
        with _as_fmu_error(self._fmu.path, f"failed at {self.time_s:.3f} s", self._fmu.messages):
            self.set(values)
            self._instance.doStep(
                currentCommunicationPoint=self.time_s, communicationStepSize=step_s
            )
        self.time_s += step_s

    def read(self) -> dict[str, float]:
        """All outputs by role, SI.

        Raises
        ------
        FmuError
            An output is no number.
        """
        found = {wire.role: self._value(wire) for wire in self._wiring.outputs}
        for role, value in found.items():
            if not math.isfinite(value):
                raise FmuError(f"{self._fmu.path}: {role} is {value} at {self.time_s:.3f} s; the "
                               "simulation has left all bounds")  # fmt: skip
        return found

    def _value(self, wire: Wire) -> float:
        values = [self._read(variable) for variable in wire.variables]
        return wire.factor * sum(values) / len(values)

    def _read(self, variable: Any) -> float:
        kind = "Real" if self._fmu.version == 2 else variable.type
        return float(getattr(self._instance, f"get{kind}")([variable.valueReference])[0])

    def _write(self, variable: Any, value: float) -> None:
        kind = "Real" if self._fmu.version == 2 else variable.type
        getattr(self._instance, f"set{kind}")([variable.valueReference], [value])

    def close(self) -> None:
        """End it; what goes wrong now spoils nothing."""
        try:
            self._instance.terminate()
            self._instance.freeInstance()
        except Exception:
            return
