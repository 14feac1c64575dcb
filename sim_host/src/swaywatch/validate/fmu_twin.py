"""A user's FMU driven with what was recorded: the simulation of that drive."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from swaywatch.cosim.fmu import Fmu
from swaywatch.cosim.mapping import RATES, STEERING, Wiring, wire
from swaywatch.drive import Channel, Drive
from swaywatch.errors import FmuError
from swaywatch.validate.twin import twin_inputs

Array = NDArray[np.float64]

STEP_S = 0.01
"""Longest step of communication."""
_BODIES = ("car", "trailer")


def drive_fmu(
    fmu: Fmu, wiring: Wiring, time_s: Array, inputs: Mapping[str, Array],
    positions: Mapping[str, float],
) -> dict[str, Array]:  # fmt: skip
    """Channels of an FMU that is driven with channels.

    Within a step an input that has a ``_rate`` beside it runs with that, any other stays at its
    mean over the step: so neither lags by half a step.

    Parameters
    ----------
    fmu, wiring : an open FMU and its roles
    time_s : shape (n,), rising
    inputs : role -> values on `time_s`, SI, shape (n,)
    positions : places of the recording's accelerometers by channel, m ahead of the COG

    Returns
    -------
    Channel -> values on `time_s`, SI; steering and speed are the inputs where it gives none.
    """
    step = fmu.step_s(STEP_S)
    count = int(np.ceil((time_s[-1] - time_s[0]) / step - 1e-9))
    own = np.arange(count + 1) * step
    laid = {role: np.interp(own, time_s - time_s[0], value) for role, value in inputs.items()}
    for role in inputs:
        if f"{role}_rate" in RATES:
            laid[f"{role}_rate"] = np.append(np.diff(laid[role]) / step, 0.0)
    running = fmu.start(wiring, {role: float(value[0]) for role, value in laid.items()})
    rows = [running.read()]
    try:
        for k in range(count):
            running.step(_held(wiring, laid, k), step)
            rows.append(running.read())
    finally:
        running.close()
    found = {
        role: np.interp(time_s - time_s[0], own, np.array([row[role] for row in rows]))
        for role in rows[0]
    }
    _move_accelerometers(fmu, wiring, found, time_s, positions)
    for role in (STEERING, "speed"):
        if role in inputs:
            found.setdefault(role, inputs[role])
    return found


def _held(wiring: Wiring, laid: Mapping[str, Array], k: int) -> dict[str, float]:
    """Inputs of the step from sample `k`."""
    return {
        role: float(value[k])
        if role in RATES or wiring.has_input(f"{role}_rate")
        else 0.5 * float(value[k] + value[min(k + 1, value.size - 1)])
        for role, value in laid.items()
    }


def _move_accelerometers(
    fmu: Fmu, wiring: Wiring, channels: dict[str, Array], time_s: Array,
    positions: Mapping[str, float],
) -> None:  # fmt: skip
    """Accelerations at the recording's places: a(x) = a(x0) + (x - x0) dr/dt."""
    for one in wiring.outputs:
        if one.position_m is None or one.role not in positions:
            continue
        ahead = positions[one.role] - one.position_m
        rate = f"{one.role.partition('_')[0]}_yaw_rate"
        if abs(ahead) < 1e-3:
            continue
        if rate not in channels:
            raise FmuError(
                f"{fmu.path}: {one.role} is {one.position_m:g} m ahead of the COG, the recording's "
                f"{positions[one.role]:g} m; {rate} is needed to tell one from the other"
            )
        channels[one.role] = channels[one.role] + ahead * np.gradient(channels[rate], time_s)


def twin_of(drive: Drive, path: Path, signals: Path | None) -> Drive:
    """The drive as the FMU has it: its channels that the recording has, too."""
    time_s, inputs = twin_inputs(drive)
    recorded = {name: channel.signal for name, channel in drive.channels.items()}
    positions = {
        name: channel.position_m
        for name, channel in drive.channels.items()
        if name.endswith("lateral_acceleration")
    }
    with Fmu(path) as fmu:
        wiring = wire(fmu.description, path, signals, recorded)
        channels = drive_fmu(fmu, wiring, time_s, inputs, positions)
    made = {
        name: Channel(
            name, time_s, value, name, drive.channels[name].unit, positions.get(name, 0.0),
            (path.name,),
        )
        for name, value in channels.items()
        if name in drive.channels
    }  # fmt: skip
    return dataclasses.replace(drive, channels=made, remarks=tuple(remarks(path, wiring)))


def remarks(path: Path, wiring: Wiring) -> list[str]:
    """What drives an FMU and what does not, as sentences."""
    driven = ", ".join(w.role for w in wiring.inputs if w.role not in RATES)
    text = [f"{path.name}: driven with the recorded {driven}"]
    if wiring.idle:
        text.append(f"{path.name}: inputs left at their start values: {', '.join(wiring.idle)}")
    return text
