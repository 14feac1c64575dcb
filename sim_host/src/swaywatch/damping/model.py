"""The user's own linear model, as eigenvalues or matrices over speed.

``.csv``
    A speed column and ``growth``/``sigma`` with ``omega`` (or ``real``, ``imag``; or
    ``frequency_hz`` with ``damping_ratio``/``zeta``). Several rows at a speed are several modes; a
    text column tells variants apart: ``FILE.csv:NAME``. A unit may stand behind a name in brackets;
    a speed in another one than the recording's is converted.
``.mat``, ``.npz``
    ``speed`` (k) with ``eigenvalues`` (k, modes), or ``A`` (k, n, n) or (n, n, k), or ``M``, ``C``,
    ``K`` of M q'' + C q' + K q = 0 in the same shapes.
``.py``
    A function ``system(speed)`` that gives a python-control StateSpace or TransferFunction, a
    matrix A, or a list of eigenvalues.

Without any speed (one flight condition, one load) the eigenvalues hold wherever it was driven.
"""

from __future__ import annotations

import csv
import math
import re
import runpy
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.io

from swaywatch.errors import ModelError

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]

_COLUMNS = {
    "speed": (
        "speed", "speed_m_s", "speed_mps", "speed_kmh", "speed_km_h", "speed_kph", "speed_kt", "v",
        "v_mps", "v_m_s", "v_kmh", "v_km_h", "velocity", "airspeed", "tas", "u", "x",
    ),
    "real": ("growth", "growth_1_s", "sigma", "sigma_1_s", "real", "re"),
    "imag": ("omega", "omega_rad_s", "omega_d", "imag", "im"),
    "frequency": ("frequency_hz", "f_hz", "f", "frequency"),
    "ratio": ("damping_ratio", "zeta", "damping"),
}  # fmt: skip

_UNITS_M_S = {
    "m/s": 1.0, "mps": 1.0, "m_s": 1.0, "km/h": 1 / 3.6, "kmh": 1 / 3.6, "km_h": 1 / 3.6,
    "kph": 1 / 3.6, "mph": 0.44704, "kt": 0.514444, "kts": 0.514444, "kn": 0.514444,
    "knots": 0.514444, "ft/s": 0.3048,
}  # fmt: skip


@dataclass(frozen=True)
class LinearModel:
    """Oscillating eigenvalues at given speeds, or a function of the speed.

    Attributes
    ----------
    speed : shape (k,)
        Rising; empty where `function` gives the eigenvalues at any speed.
    poles : tuple of complex arrays
        Those with a positive imaginary part, at each speed.
    speed_unit
        As the model says, or "".
    anywhere
        The model has no speed: `poles` holds one array, for every place.
    """

    name: str
    speed: FloatArray
    poles: tuple[ComplexArray, ...]
    function: Callable[[float], ComplexArray] | None = None
    speed_unit: str = ""
    anywhere: bool = False

    def over(self, unit: str) -> LinearModel:
        """The same over a speed in the unit of a recording, where both units are known."""
        own, theirs = _UNITS_M_S.get(self.speed_unit), _UNITS_M_S.get(unit.strip().lower())
        if own is None or theirs is None or own == theirs:
            return self
        return replace(self, speed=self.speed * own / theirs, speed_unit=unit)

    def range_words(self) -> str:
        """Of its speeds: `` (2 to 5 m/s)``; nothing where it has none."""
        if not len(self.speed):
            return ""
        return f" ({self.speed[0]:.3g} to {self.speed[-1]:.3g} {self.speed_unit}".rstrip() + ")"

    def pole(self, speed: float, near: complex) -> complex | None:
        """Eigenvalue of the mode near `near` at a speed; None outside the model's speeds."""
        if self.anywhere or self.function is not None:
            return _nearest(self.function(speed) if self.function else self.poles[0], near)
        if not len(self.speed):
            return None
        margin = 0.05 * max(float(np.ptp(self.speed)), abs(float(self.speed[0])))
        if not self.speed[0] - margin <= speed <= self.speed[-1] + margin:
            return None
        after = int(np.clip(np.searchsorted(self.speed, speed), 1, max(1, len(self.speed) - 1)))
        if len(self.speed) == 1:
            return _nearest(self.poles[0], near)
        low, high = (_nearest(self.poles[k], near) for k in (after - 1, after))
        if low is None or high is None:
            return None
        part = (speed - self.speed[after - 1]) / (self.speed[after] - self.speed[after - 1])
        return complex(low + float(np.clip(part, -0.2, 1.2)) * (high - low))


def _nearest(poles: ComplexArray, near: complex) -> complex | None:
    if not len(poles):
        return None
    return complex(poles[np.argmin(np.abs(poles - near))])


def _swinging(eigenvalues: npt.ArrayLike) -> ComplexArray:
    values = np.asarray(eigenvalues, dtype=np.complex128).ravel()
    return values[np.isfinite(values) & (values.imag > 1e-6)]


def load_model(text: str) -> LinearModel:
    """Read a model; the text is a path, with ``:NAME`` behind a CSV with several variants.

    Raises
    ------
    ModelError
        Names the file, what is missing and what would be right.
    """
    path = Path(text)
    variant = ""
    if not path.is_file() and ":" in text:
        head, _, variant = text.rpartition(":")
        path = Path(head)
    if not path.is_file():
        raise ModelError(f"{text}: no such file")
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return _from_csv(path, variant)
    if suffix == ".mat":
        try:
            content = scipy.io.loadmat(path)
        # scipy says so of the HDF5 format of MATLAB 7.3
        except (ValueError, NotImplementedError, OSError) as error:
            raise ModelError(f"{path}: not a MAT file that can be read ({error})") from error
        return _from_arrays(path, content)
    if suffix == ".npz":
        with np.load(path, allow_pickle=False) as archive:
            return _from_arrays(path, dict(archive))
    if suffix == ".py":
        return _from_python(path)
    raise ModelError(f"{path}: unknown format {suffix!r}; known: .csv, .mat, .npz, .py")


def _column(names: Sequence[str], kind: str) -> str | None:
    lower = {_UNIT.sub("", name).strip().lower(): name for name in names}
    return next((lower[one] for one in _COLUMNS[kind] if one in lower), None)


_UNIT = re.compile(r"\s*[\[(]([^\])]*)[\])]\s*$")


def _unit_of(name: str) -> str:
    """Unit of a speed column: in brackets behind its name, or the end of the name."""
    found = _UNIT.search(name)
    if found:
        return found[1].strip().lower()
    tail = name.strip().lower().partition("_")[2]
    return {"m_s": "m/s", "mps": "m/s", "kmh": "km/h", "km_h": "km/h", "kph": "km/h"}.get(
        tail, tail
    )


def _from_csv(path: Path, variant: str) -> LinearModel:
    with path.open(newline="", encoding="utf-8-sig") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        raise ModelError(f"{path}: no row below the head")
    names = list(rows[0])
    rows = _of_variant(path, rows, names, variant)
    columns = {kind: _column(names, kind) for kind in _COLUMNS}
    speed = columns["speed"]
    poles: dict[float, list[complex]] = {}
    for number, row in enumerate(rows, 2):
        try:
            place = 0.0 if speed is None else float(row[speed])
            poles.setdefault(place, []).append(_pole_of(path, row, columns))
        except (TypeError, ValueError) as error:
            raise ModelError(f"{path}: row {number}: {error}") from error
    name = f"{path.name}:{variant}" if variant else path.name
    if speed is None:
        return LinearModel(name, np.zeros(0), (_swinging(poles[0.0]),), anywhere=True)
    order = sorted(poles)
    return LinearModel(
        name,
        np.array(order),
        tuple(_swinging(poles[place]) for place in order),
        speed_unit=_unit_of(speed),
    )


def _of_variant(
    path: Path, rows: list[dict[str, str]], names: list[str], variant: str
) -> list[dict[str, str]]:
    """Rows of one variant, by the first column that holds no numbers."""
    text = next((name for name in names if not _is_number(rows[0][name])), None)
    there = list(dict.fromkeys(row[text] for row in rows)) if text is not None else []
    if text is None or (len(there) == 1 and not variant):
        return rows
    if variant not in there:
        raise ModelError(
            f"{path}: name one of its variants behind the file, {path.name}:NAME; there are "
            f"{', '.join(there[:12])}"
        )
    return [row for row in rows if row[text] == variant]


def _is_number(text: str | None) -> bool:
    try:
        float(text or "nan")
    except ValueError:
        return False
    return True


def _pole_of(path: Path, row: dict[str, str], columns: dict[str, str | None]) -> complex:
    real, imag = columns["real"], columns["imag"]
    if real is not None and imag is not None:
        return complex(float(row[real]), abs(float(row[imag])))
    frequency, ratio = columns["frequency"], columns["ratio"]
    if frequency is not None and ratio is not None:
        omega, zeta = 2 * math.pi * float(row[frequency]), float(row[ratio])
        if not -1.0 < zeta < 1.0:
            raise ValueError(f"damping ratio {zeta:g} must lie between -1 and 1")
        return complex(-zeta * omega / math.sqrt(1.0 - zeta**2), omega)
    raise ModelError(
        f"{path}: needs columns growth and omega (1/s, rad/s), or frequency_hz and damping_ratio"
    )


def _from_arrays(path: Path, content: dict[str, Any]) -> LinearModel:
    arrays = {name: np.asarray(value) for name, value in content.items() if name[:2] != "__"}
    key = _column(list(arrays), "speed")
    known = [name for name in ("eigenvalues", "A", "M", "C", "K") if name in arrays]
    if key is None and any(arrays[name].ndim > 2 for name in known):
        raise ModelError(f"{path}: no array `speed`; there are {', '.join(arrays)}")
    if key is None:  # one condition: every array is that of it
        arrays |= {name: arrays[name][None] for name in known if arrays[name].ndim}
        if "eigenvalues" in arrays:
            arrays["eigenvalues"] = arrays["eigenvalues"].reshape(1, -1)
    speed = np.zeros(1) if key is None else np.asarray(arrays[key], dtype=np.float64).ravel()
    count = len(speed)
    if "eigenvalues" in arrays:
        values = arrays["eigenvalues"].astype(np.complex128)
        values = values.reshape(count, -1) if values.shape[:1] == (count,) else values.T
        if values.shape[0] != count:
            raise ModelError(f"{path}: eigenvalues must have a row for each of {count} speeds")
        poles = [_swinging(row) for row in values]
    elif "A" in arrays:
        poles = [_swinging(np.linalg.eigvals(a)) for a in _stack(path, arrays, "A", count)]
    elif {"M", "C", "K"} <= set(arrays):
        parts = [_stack(path, arrays, name, count) for name in ("M", "C", "K")]
        poles = [_second_order(*matrices) for matrices in zip(*parts, strict=True)]
    else:
        raise ModelError(f"{path}: needs `eigenvalues`, or `A`, or `M`, `C` and `K`")
    if key is None:
        return LinearModel(path.name, np.zeros(0), tuple(poles), anywhere=True)
    order = np.argsort(speed)
    ordered = tuple(poles[k] for k in order)
    return LinearModel(path.name, speed[order], ordered, speed_unit=_unit_of(key))


def _stack(path: Path, arrays: dict[str, Any], name: str, count: int) -> list[FloatArray]:
    """A matrix for each speed."""
    value = np.asarray(arrays[name], dtype=np.float64)
    if value.ndim == 2:
        value = np.repeat(value[None], count, axis=0)
    elif value.ndim == 3 and value.shape[0] != count and value.shape[2] == count:
        value = np.moveaxis(value, 2, 0)
    if value.ndim != 3 or value.shape[0] != count or value.shape[1] != value.shape[2]:
        raise ModelError(
            f"{path}: {name} has the shape {arrays[name].shape}; expected (k, n, n) or (n, n, k) "
            f"with k = {count} speeds"
        )
    return list(value)


def _second_order(mass: FloatArray, damping: FloatArray, stiffness: FloatArray) -> ComplexArray:
    """Eigenvalues of M q'' + C q' + K q = 0."""
    n = len(mass)
    inverse = np.linalg.inv(mass)
    below = np.hstack([-inverse @ stiffness, -inverse @ damping])
    return _swinging(np.linalg.eigvals(np.vstack([np.eye(n, 2 * n, n), below])))


def from_systems(
    name: str, systems: Sequence[tuple[float, Any]] | Callable[[float], Any]
) -> LinearModel:
    """Model of python-control systems (or matrices A): pairs (speed, system), or a function."""
    if callable(systems):
        system = systems
        return LinearModel(name, np.zeros(0), (), lambda speed: _poles_of(system(speed)))
    pairs = sorted(systems, key=lambda pair: pair[0])
    speed = np.array([float(pair[0]) for pair in pairs])
    return LinearModel(name, speed, tuple(_poles_of(system) for _, system in pairs))


def _poles_of(system: Any) -> ComplexArray:
    """Of a python-control system, a square matrix, or a list of eigenvalues."""
    if callable(getattr(system, "poles", None)):
        return _swinging(system.poles())
    values = np.asarray(system)
    if values.ndim == 2 and values.shape[0] == values.shape[1]:
        values = np.linalg.eigvals(values)
    return _swinging(values)


def _from_python(path: Path) -> LinearModel:
    try:
        system = runpy.run_path(str(path)).get("system")
    except Exception as error:  # whatever the user's file raises
        raise ModelError(f"{path}: {type(error).__name__}: {error}") from error
    if not callable(system):
        raise ModelError(f"{path}: defines no function system(speed)")
    return from_systems(path.name, system)
