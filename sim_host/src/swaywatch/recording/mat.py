"""MATLAB files (level 5, ``save -v7`` and before) of decoded signals.

Written: one variable for each signal, a structure with ``time`` (s since ``start_unix_ns``),
``value``, ``unit`` and ``name``. Read: such structures, and plain vectors beside one vector of time
(``time``, ``t``, also with ``_s``, ``_ms``, ``_us``) of the same length, as most scripts save them;
also one structure that holds them all, each a vector or a structure with ``data`` and ``units``, as
data acquisition systems do.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from swaywatch.errors import RecordingError
from swaywatch.recording.frames import FloatArray, IntArray, Recording, Series, must_rise
from swaywatch.recording.guard import must_fit, refusing

START = "start_unix_ns"
_TIME = re.compile(r"^(time|t|timestamp|timestamps)(?:_(?P<unit>s|ms|us|ns))?$", re.IGNORECASE)
_PER_S = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
_LATEST_S = 9e9
_LONGEST_NAME = 31  # of MATLAB's older versions; a longer one is cut and kept in `name`


def read(path: Path) -> Recording:
    """Read every signal of a MATLAB file."""
    from scipy.io import loadmat, whosmat

    with path.open("rb") as file:
        head = file.read(128)
    if b"MATLAB 7.3" in head or head[:8] == b"\x89HDF\r\n\x1a\n":
        raise RecordingError(f"{path}: is of MATLAB's version 7.3; save it with save(..., '-v7')")
    with refusing(path, "MATLAB"):
        sizes = whosmat(path)
        must_fit(path, sum(8 * int(np.prod(shape, dtype=float)) for _, shape, _ in sizes), "MATLAB")
        content = loadmat(path, squeeze_me=True, struct_as_record=False)
    start_ns = _start(path, content)
    signals = {**_structures(path, content, start_ns), **_vectors(path, content, start_ns)}
    for key, item in content.items():
        fields = getattr(item, "_fieldnames", ())
        if fields and not {"time", "value"} <= set(fields):
            signals |= _vectors(path, {name: getattr(item, name) for name in fields}, start_ns, key)
    if not signals:
        raise RecordingError(
            f"{path}: no signal in it; expected structures with time and value, or vectors beside "
            "one named time (as variables, or together in one structure). Variables there: "
            f"{', '.join(_described(name, shape) for name, shape, _ in sizes[:8]) or '-'}"
        )
    return Recording(path, "MATLAB", signals=signals)


def _described(name: str, shape: tuple[int, ...]) -> str:
    """``y (2000x3)``: a matrix does not say what its columns are."""
    return f"{name} ({'x'.join(map(str, shape))})" if min(shape, default=1) > 1 else name


def _start(path: Path, content: dict[str, Any]) -> int:
    value = np.asarray(content.get(START, 0))
    if value.size != 1 or value.dtype.kind not in "iu":
        raise RecordingError(f"{path}: {START} must be one integer, ns since 1970")
    return int(value)


def _structures(path: Path, content: dict[str, Any], start_ns: int) -> dict[str, Series]:
    found = {}
    for key, item in content.items():
        fields = getattr(item, "_fieldnames", ())
        if not {"time", "value"} <= set(fields):
            continue
        name = str(getattr(item, "name", "") or key)
        time, value = _numbers(path, key, item.time), _numbers(path, key, item.value)
        if len(time) != len(value):
            raise RecordingError(f"{path}: {key} has {len(time)} times and {len(value)} values")
        found[name] = _series(path, name, time, value, start_ns, str(getattr(item, "unit", "")))
    return found


def _vectors(
    path: Path, content: dict[str, Any], start_ns: int, within: str = ""
) -> dict[str, Series]:
    """Vectors beside one of time; `within`: the structure that holds them."""
    plain: dict[str, FloatArray] = {}
    units: dict[str, str] = {}
    for name, item in content.items():
        value = getattr(item, "data", None) if hasattr(item, "_fieldnames") else item
        if isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "iufb":
            plain[name] = np.atleast_1d(value).astype(np.float64)
            units[name] = str(getattr(item, "units", "") or getattr(item, "unit", ""))
    clocks = [(name, match) for name in plain if (match := _TIME.match(name))]
    if not clocks:
        return {}
    if len(clocks) > 1:
        raise RecordingError(
            f"{path}: {within}{': ' * bool(within)}several vectors of time "
            f"({', '.join(name for name, _ in clocks)}); keep one, or save structures with time "
            "and value"
        )
    name, match = clocks[0]
    own = units[name].lower()
    time = plain.pop(name) / _PER_S[match["unit"] or (own if own in _PER_S else "s")]
    return {
        key: _series(path, key, time, value, start_ns, units[key])
        for key, value in plain.items()
        if len(value) == len(time)
    }


def _numbers(path: Path, key: str, item: Any) -> FloatArray:
    array = np.atleast_1d(np.asarray(item))
    if array.ndim != 1 or array.dtype.kind not in "iufb":
        raise RecordingError(f"{path}: {key} must hold vectors of numbers in time and value")
    return array.astype(np.float64)


def _series(
    path: Path, name: str, time: FloatArray, value: FloatArray, start_ns: int, unit: str
) -> Series:
    bad = np.flatnonzero(~(np.abs(time) < _LATEST_S))
    if len(bad):
        raise RecordingError(f"{path}: {name} has the time {time[bad[0]]:g} s, which is no time")
    time_ns: IntArray = start_ns + np.rint(time * 1e9).astype(np.int64)
    must_rise(path, time_ns)
    there = np.isfinite(value)
    return Series(time_ns[there], value[there], unit)


def write(path: Path, signals: dict[str, Series]) -> None:
    """Write decoded signals, compressed, for every MATLAB since 7 and for Octave."""
    from scipy.io import savemat

    start_ns = min((int(s.time_ns[0]) for s in signals.values() if len(s.time_ns)), default=0)
    content: dict[str, Any] = {START: np.int64(start_ns)}
    for name, series in signals.items():
        content[_variable(name, content)] = {
            "time": (series.time_ns - start_ns) * 1e-9,
            "value": series.value,
            "unit": series.unit,
            "name": name,
        }
    savemat(path, content, do_compression=True, oned_as="column", appendmat=False)


def _variable(name: str, taken: dict[str, Any]) -> str:
    """A name that MATLAB accepts, as near to the signal's as can be."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    plain = (plain if re.match(r"[A-Za-z]", plain) else f"x{plain}")[:_LONGEST_NAME]
    number, found = 1, plain
    while found in taken:
        number += 1
        found = f"{plain[: _LONGEST_NAME - 4]}_{number}"
    return found
