"""The C core through cffi: drives in, estimates out. Nothing is estimated here.

``analyze_drive(drive, vehicle)`` feeds every sample of a drive to ``sway_core_input()`` in order of
time and collects each new ``sway_status_t``; field names and units come from ``lib/sway_status.h``.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from swaywatch.drive import Channel, Drive
from swaywatch.errors import VehicleError
from swaywatch.roles import CHANNELS
from swaywatch.vehicle import UNKNOWNS, Vehicle

try:
    from swaywatch.ecu._core import ffi, lib
except ImportError as missing:  # the package was not installed
    raise ImportError(
        "swaywatch's C core is not built; run `make setup-run` at the top of the repository"
    ) from missing

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

AXLES = ("car_front", "car_rear", "trailer_front", "trailer_rear")
"""The four axles in the order of ``sway_axle_t``."""

_SUFFIXES: tuple[tuple[str, str, float], ...] = (
    ("_ppm_per_s", "_per_s", 1e-6),
    ("_micro_per_s", "_per_s", 1e-6),
    ("_milli_per_rad", "_per_rad", 1e-3),
    ("_n_per_rad", "_n_per_rad", 1.0),
    ("_urad_s", "_rad_s", 1e-6),
    ("_urad", "_rad", 1e-6),
    ("_uhz", "_hz", 1e-6),
    ("_ppm", "", 1e-6),
    ("_mm_s", "_m_s", 1e-3),
    ("_gm2", "_kgm2", 1e-3),
    ("_mn", "_n", 1e-3),
    ("_ms", "_s", 1e-3),
    ("_us", "_s", 1e-6),
)
"""Ending of an integer field, ending of the SI name, factor."""


def _enumeration(prefix: str, type_name: str) -> dict[str, int]:
    """Names (without prefix, lower case) and values of a C enum."""
    elements = ffi.typeof(type_name).relements
    return {
        name.removeprefix(prefix).lower(): value
        for name, value in elements.items()
        if name.startswith(prefix) and not name.endswith(("_COUNT", "_BITS"))
    }


VALID: dict[str, int] = _enumeration("SWAY_VALID_", "sway_valid_t")
"""Bits of ``valid`` and ``old`` by name, e.g. ``line``, ``critical_speed``, ``car_front``."""

QUALITY: dict[str, int] = _enumeration("SWAY_QUALITY_", "sway_quality_t")
"""Bits of ``quality`` by name, e.g. ``forced``."""

ALARM: dict[int, str] = {v: k for k, v in _enumeration("SWAY_ALARM_", "sway_alarm_state_t").items()}
"""Name of each alarm state."""

REASON: dict[str, int] = _enumeration("SWAY_REASON_", "sway_reason_t")
"""Bits of ``reasons`` by name."""

VCRIT: dict[int, str] = {v: k for k, v in _enumeration("SWAY_VCRIT_", "sway_vcrit_t").items()}
"""Name of each kind of critical speed."""

SOURCE: dict[int, str] = {v: k for k, v in _enumeration("SWAY_SOURCE_", "sway_source_t").items()}
"""Where the critical speed comes from."""

PRESENCE: dict[int, str] = {
    v: k for k, v in _enumeration("SWAY_TRAILER_", "sway_trailer_presence_t").items()
}
"""Whether a trailer is there: ``undecided``, ``none``, ``there``, ``sensed``."""

FAULT: dict[int, str] = {v: k for k, v in _enumeration("SWAY_FAULT_", "sway_fault_t").items()}
"""Name of each fault counter."""

PARAMETER: dict[int, str] = {
    v: k for k, v in _enumeration("SWAY_PARAMETER_", "sway_parameter_t").items()
}
"""Name of each parameter of the sensitivities of the critical speed."""


def _dtype(type_name: str) -> np.dtype[Any]:
    """The numpy structure of a C structure of integers."""
    kind = ffi.typeof(type_name)
    names, formats, offsets = [], [], []
    for name, member in kind.fields:
        names.append(name)
        formats.append(_member_dtype(member.type))
        offsets.append(member.offset)
    return np.dtype(
        {"names": names, "formats": formats, "offsets": offsets, "itemsize": ffi.sizeof(kind)}
    )


def _member_dtype(kind: Any) -> Any:
    if kind.kind == "array":
        return (_member_dtype(kind.item), (kind.length,))
    if kind.kind == "struct":
        return _dtype(kind.cname)
    size = ffi.sizeof(kind)
    unsigned = kind.kind == "enum" or kind.cname.startswith(("uint", "unsigned"))
    return np.dtype(f"{'u' if unsigned else 'i'}{size}")


STATUS_DTYPE: np.dtype[Any] = _dtype("sway_status_t")
"""``sway_status_t`` as a numpy structure."""


@dataclass(frozen=True)
class Estimates:
    """Every estimate of a drive.

    Attributes
    ----------
    status : structured array, shape (n,)
        ``sway_status_t`` as the core wrote them.
    fault_count : dict
        Fault counters at the end of the drive, by name.
    inputs : tuple
        Channels that were fed.
    trailer : dict
        What the car's own sensors tell of the trailer, see :meth:`Core.trailer`.
    """

    status: npt.NDArray[Any]
    fault_count: dict[str, int]
    inputs: tuple[str, ...] = ()
    trailer: dict[str, Any] = field(default_factory=dict)
    columns: dict[str, FloatArray] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.status)

    def __getitem__(self, name: str) -> FloatArray:
        """Values in SI units by their SI name, e.g. ``frequency_hz``, ``car_rear.load_n``."""
        return self.columns[name]

    def has(self, bit: str) -> BoolArray:
        """Where the bit of ``valid`` is set, shape (n,)."""
        flags: BoolArray = (self.status["valid"] & VALID[bit]) != 0
        return flags

    def flagged(self, bit: str) -> BoolArray:
        """Where the bit of ``quality`` is set, shape (n,)."""
        flags: BoolArray = (self.status["quality"] & QUALITY[bit]) != 0
        return flags

    @property
    def time_s(self) -> FloatArray:
        """Middle of each window, s since the start of the drive."""
        return self.columns["mid_time_s"]


def si_name(name: str) -> tuple[str, float]:
    """SI name of an integer field and the factor to it."""
    for old, new, factor in _SUFFIXES:
        if name.endswith(old):
            return name.removesuffix(old) + new, factor
    return name, 1.0


_UNITS = {
    "_hz": "Hz", "_per_s": "1/s", "_per_rad": "1/rad", "_n_per_rad": "N/rad", "_rad_s": "rad/s",
    "_rad": "rad", "_m_s": "m/s", "_kgm2": "kgm2", "_n": "N", "_s": "s",
}  # fmt: skip


def unit_of(name: str) -> str:
    """Unit of a column by the end of its name; "1" for ratios, flags and counts."""
    plain = name.rpartition("sensitivity_m_s.")[1].rstrip(".") or name
    ends = [end for end in _UNITS if plain.endswith(end)]
    return _UNITS[max(ends, key=len)] if ends else "1"


def columns_of(status: npt.NDArray[Any]) -> dict[str, FloatArray]:
    """Every number of the statuses in SI units; axles as ``car_front.<field>`` and so on."""
    columns: dict[str, FloatArray] = {}
    for name in status.dtype.names or ():
        if name == "axle":
            for index, axle in enumerate(AXLES):
                for part in status.dtype["axle"].base.names or ():
                    label, factor = si_name(part)
                    columns[f"{axle}.{label}"] = status["axle"][:, index][part] * factor
        elif name == "sensitivity_mm_s":
            for index, parameter in PARAMETER.items():
                columns[f"sensitivity_m_s.{parameter}"] = status[name][:, index] * 1e-3
        elif name == "fault_count":
            for index, fault in FAULT.items():
                columns[f"fault_count.{fault}"] = status[name][:, index].astype(np.float64)
        else:
            label, factor = si_name(name)
            columns[label] = status[name] * factor
    return columns


def core_vehicle(vehicle: Vehicle, positions_m: Mapping[str, float] | None = None) -> Any:
    """``sway_vehicle_t`` of a vehicle.

    Parameters
    ----------
    vehicle
        The combination.
    positions_m
        Of the accelerometers, by channel, ahead of the COG; 0 where not given.

    Raises
    ------
    VehicleError
        The core's own check refuses a value; names the key and its range.
    """
    result = ffi.new("sway_vehicle_t *")
    positions = {
        body: (positions_m or {}).get(f"{body}_lateral_acceleration", 0.0)
        for body in ("car", "trailer")
    }
    for body in ("car", "trailer"):
        data, target = getattr(vehicle, body), getattr(result, body)
        if data is None:
            continue
        for name, member in ffi.typeof(target).fields:
            del member
            if name == "axles":
                target.axles = 1 if data.front_axle_to_cog is None else 2
            elif name == "lateral_acc_position_um":
                target.lateral_acc_position_um = round(positions[body] * 1e6)
            else:
                key, factor = _vehicle_key(name)
                value = getattr(data, key)
                setattr(target, name, 0 if value is None else round(value * factor))
    offender = ffi.new("sway_vehicle_range_t const **")
    if lib.sway_vehicle_check(result, offender) != lib.SWAY_OK:
        raise VehicleError(_refusal(vehicle, result, offender[0]))
    return result


@functools.cache
def vehicle_ranges() -> dict[str, tuple[float, float]]:
    """Lowest and highest value of each key of a vehicle.toml, such as ``car.mass``, SI units."""
    count = ffi.new("size_t *")
    table = lib.sway_vehicle_ranges(count)
    found = {}
    for index in range(count[0]):
        named = lib.sway_vehicle_name(table + index)
        row, scale = table[index], named.scale
        found[ffi.string(named.key).decode()] = (row.low / scale, row.high / scale)
    return found


def positions_of(drive: Drive | None) -> dict[str, float]:
    """Positions of the accelerometers of a drive."""
    channels = {} if drive is None else drive.channels
    return {name: channel.position_m for name, channel in channels.items()}


def _vehicle_key(name: str) -> tuple[str, float]:
    for suffix, factor in (
        ("_gm2", 1e3), ("_g", 1e3), ("_um", 1e6), ("_n_per_rad", 1.0), ("_mn", 1e3), ("_milli", 1e3)
    ):  # fmt: skip
        if name.endswith(suffix):
            return name.removesuffix(suffix), factor
    return name, 1.0


def _refusal(vehicle: Vehicle, result: Any, offender: Any) -> str:
    if offender == ffi.NULL:
        return f"{vehicle.path}: the core refuses this vehicle"
    named = lib.sway_vehicle_name(offender)
    name, scale = ffi.string(named.key).decode(), named.scale
    value = lib.sway_vehicle_value(result, offender) / scale
    return (
        f"{vehicle.path}: {name} = {value:g} is out of range; expected "
        f"{offender.low / scale:g} to {offender.high / scale:g}"
    )


WINDOW = (1.5, 6.0)
"""Oscillations that a window may hold."""
USUAL_WINDOW = 1.7
"""Oscillations in a window where nobody says otherwise."""


def core_config(
    vehicle: Vehicle,
    positions_m: Mapping[str, float] | None = None,
    alarm: Mapping[str, int] | None = None,
) -> Any:
    """``sway_core_config_t *`` with its defaults, the vehicle, and fields of `alarm` by C name."""
    config = ffi.new("sway_core_config_t *")
    lib.sway_core_defaults(config)
    config.vehicle = core_vehicle(vehicle, positions_m)[0]
    if vehicle.trailer is not None:
        config.trailer_assumed = sum(
            1 << index for index, name in enumerate(UNKNOWNS) if name in vehicle.trailer.assumed
        )
    for name, value in (alarm or {}).items():
        setattr(config.alarm, name, value)
    return config


class Core:
    """One ``sway_core_t`` of its own.

    Parameters
    ----------
    vehicle
        The combination.
    positions_m
        Of the accelerometers, by channel, ahead of the COG.
    alarm
        Overrides fields of ``sway_alarm_config_t``, by their C names.
    window
        Length of the window in oscillations, `WINDOW`; None: the core's own.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        positions_m: Mapping[str, float] | None = None,
        alarm: Mapping[str, int] | None = None,
        window: float | None = None,
    ) -> None:
        self._core = ffi.new("sway_core_t *")
        config = core_config(vehicle, positions_m, alarm)
        if window is not None:
            config.window_cycles_milli = round(1e3 * window)
        config.input_period_us = 0  # a recording has the rates that it has
        error = lib.sway_core_init(self._core, config)
        if error != lib.SWAY_OK:
            raise VehicleError(f"{vehicle.path}: the core refuses this configuration ({error})")

    def input(self, channel: str, time_s: float, value: float) -> None:
        """Feed one sample (SI units) and run what is due."""
        kind = CHANNELS[channel]
        if kind.core_input is None:
            return
        number = round(float(np.clip(value * kind.core_scale, -(2**31), 2**31 - 1)))
        lib.sway_core_input(self._core, getattr(lib, kind.core_input), round(time_s * 1e6), number)
        while lib.sway_core_run(self._core):
            pass

    def status(self) -> npt.NDArray[Any]:
        """The newest status, shape (1,)."""
        pointer = lib.sway_core_status(self._core)
        raw = bytes(ffi.buffer(pointer, ffi.sizeof("sway_status_t")))
        return np.frombuffer(raw, dtype=STATUS_DTYPE)

    @property
    def watch(self) -> Any:
        """``sway_trailer_watch_t const *`` of this core."""
        return lib.sway_core_trailer(self._core)

    def trailer(self) -> dict[str, Any]:
        """What the car's own sensors tell of the trailer: ``sway_trailer_report_t`` by its names.

        Numbers are pairs (value, standard error) in the units of their names.
        """
        report = ffi.new("sway_trailer_report_t *")
        lib.sway_trailer_report(lib.sway_core_trailer(self._core), report)
        result: dict[str, Any] = {}
        for name, member in ffi.typeof(report[0]).fields:
            value = getattr(report, name)
            kind = member.type.kind
            result[name] = (
                (value.value, value.se)
                if kind == "struct"
                else tuple(value)
                if kind == "array"
                else value
            )
        return result

    def feed(
        self, drive: Drive, progress: Callable[[float], None] | None = None
    ) -> tuple[npt.NDArray[Any], tuple[str, ...]]:
        """Feed a whole drive; every new status, shape (n,), and the channels that were fed."""
        names = [name for name in drive.channels if CHANNELS[name].core_input is not None]
        feeds = ffi.new("core_feed_t[]", max(1, len(names)))
        keep: list[Any] = []
        for index, name in enumerate(names):
            time_us, value = integer_samples(drive.channels[name])
            keep += [time_us, value]
            feeds[index].input = getattr(lib, str(CHANNELS[name].core_input))
            feeds[index].count = len(time_us)
            feeds[index].time_us = ffi.cast("int64_t *", time_us.ctypes.data)
            feeds[index].value = ffi.cast("int32_t *", value.ctypes.data)
        room = 256
        buffer = ffi.new("sway_status_t[]", room)
        done = ffi.new("bool *")
        parts = []
        step_s = min(10.0, max(1.0, drive.duration_s / 100))  # a call that ends soon
        until_s = step_s
        while True:
            limit = 2**62 if until_s > drive.duration_s else round(until_s * 1e6)
            count = lib.core_feed(self._core, feeds, len(names), limit, buffer, room, done)
            raw = bytes(ffi.buffer(buffer, count * ffi.sizeof("sway_status_t")))
            parts.append(np.frombuffer(raw, dtype=STATUS_DTYPE))
            if progress:
                progress(min(until_s, drive.duration_s))
            if done[0]:
                if until_s > drive.duration_s:
                    break
                until_s += step_s
        return np.concatenate(parts), tuple(names)


def core_version() -> str:
    """Version of the C core inside, ``0.1.0``."""
    number = int(lib.core_version())
    return f"{number // 10000}.{number // 100 % 100}.{number % 100}"


def integer_samples(
    channel: Channel,
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int32]]:
    """Timestamps in us and values in the integer unit of the core's input, shapes (n,)."""
    kind = CHANNELS[channel.name]
    time_us = np.rint(channel.time_s * 1e6).astype(np.int64)
    scaled = np.rint(np.clip(channel.value * kind.core_scale, -(2.0**31), 2.0**31 - 1))
    return time_us, scaled.astype(np.int32)


def real_to_float(real: Any) -> float:
    """A ``sway_real_t`` as a float."""
    return float(np.ldexp(float(real.m), int(real.e)))


def model_damping(
    vehicle: Vehicle, speeds_m_s: npt.ArrayLike, stiffness: dict[str, float] | None = None
) -> tuple[FloatArray, FloatArray]:
    """Damping ratio and frequency (Hz) of the single-track model's weakest mode at each speed.

    Parameters
    ----------
    vehicle
        The combination.
    speeds_m_s
        Shape (n,), above 0.
    stiffness
        Cornering stiffness in N/rad by axle name, instead of the vehicle's.

    Returns
    -------
    damping_ratio, frequency_hz : float64, shape (n,)
        NaN where the vehicle does not have all that the model needs.
    """
    speeds = np.asarray(speeds_m_s, dtype=np.float64)
    damping, frequency = np.full(len(speeds), np.nan), np.full(len(speeds), np.nan)
    plain = core_vehicle(vehicle)
    for axle, value in (stiffness or {}).items():
        body, _, which = axle.partition("_")
        setattr(getattr(plain, body), f"{which}_cornering_stiffness_n_per_rad", round(value))
    stm = ffi.new("sway_single_track_t *")
    if lib.sway_single_track_from_vehicle(stm, plain) != lib.SWAY_OK:
        return damping, frequency
    roots = ffi.new("sway_single_track_roots_t *")
    quartic = ffi.new("sway_single_track_quartic_t *")
    for index, speed in enumerate(speeds):
        quartic[0] = lib.sway_single_track_quartic(
            stm, lib.sway_real_ratio(round(speed * 1e6), 1_000_000)
        )
        lib.sway_single_track_roots_start(roots, quartic)
        for _ in range(200):
            if lib.sway_single_track_roots_sweep(roots, quartic):
                break
        root = lib.sway_single_track_dominant(roots)
        damping[index] = real_to_float(lib.sway_single_track_damping_ratio(root))
        frequency[index] = abs(real_to_float(root.im)) / (2 * np.pi)
    return damping, frequency


def analyze_drive(
    drive: Drive,
    vehicle: Vehicle,
    progress: Callable[[float], None] | None = None,
    window: float | None = None,
) -> Estimates:
    """Run the core over a drive.

    Parameters
    ----------
    drive, vehicle
        What was measured, and what the user believes of the combination.
    progress
        Called with the seconds of the drive that are done.
    window
        Length of the window in oscillations; None: the core's own.

    Returns
    -------
    Estimates
        One entry for each estimate of the core.
    """
    core = Core(vehicle, positions_of(drive), window=window)
    status, inputs = core.feed(drive, progress)
    counts = core.status()["fault_count"][0]
    faults = {name: int(counts[index]) for index, name in FAULT.items()}
    return Estimates(status, faults, inputs, core.trailer(), columns_of(status))
