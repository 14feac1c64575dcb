"""Faults of a sensor, put into sound recordings: named by kind, channel and time, and put right."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from conftest import DATA, recordings

from swaywatch.checks.quality import check_drive
from swaywatch.checks.samples import Finding
from swaywatch.checks.sensor_faults import SensorFaults
from swaywatch.diagnose.engine import diagnose
from swaywatch.diagnose.fit import data
from swaywatch.drive import Channel, Drive, load_drives
from swaywatch.vehicle_file import load_vehicle

Array = npt.NDArray[np.float64]
Fault = Callable[[Drive], Drive]
RUNS = [("p01", 1), ("p07", 0)]


def case_folder(case: str) -> Path:
    return DATA / "practice" / case if case == "p01" else recordings("practice", case)


@pytest.fixture(scope="module", params=RUNS, ids=str)
def drive(request: pytest.FixtureRequest) -> Drive:
    case, run = request.param
    folder = case_folder(case)
    return load_drives([sorted(folder.glob("run*"))[run]], folder / "signals.toml")[0]


VEHICLE = load_vehicle(DATA / "practice" / "p01" / "vehicle.toml")


def with_channel(drive: Drive, channel: Channel) -> Drive:
    return replace(drive, channels={**drive.channels, channel.name: channel})


def changed(drive: Drive, name: str, change: Callable[[Array, Array], Array]) -> Drive:
    """A channel with other values, as rough as the logger has them."""
    channel = drive.channels[name]
    value = change(channel.time_s, channel.value.copy())
    rough = np.round(value / channel.resolution) * channel.resolution
    return with_channel(drive, replace(channel, value=rough))


def spiked(name: str, at: tuple[float, ...], size: float) -> Fault:
    def change(time: Array, value: Array) -> Array:
        value[np.searchsorted(time, at)] += size * value.std()
        return value

    return lambda drive: changed(drive, name, change)


def frozen(name: str, start: float, stop: float) -> Fault:
    def change(time: Array, value: Array) -> Array:
        hit = (time >= start) & (time < stop)
        value[hit] = value[np.argmax(hit)]
        return value

    return lambda drive: changed(drive, name, change)


def silent(name: str, start: float, stop: float) -> Fault:
    def fault(drive: Drive) -> Drive:
        c = drive.channels[name]
        keep = (c.time_s < start) | (c.time_s > stop)
        return with_channel(drive, replace(c, time_s=c.time_s[keep], value=c.value[keep]))

    return fault


def clipped(name: str, share: float) -> Fault:
    def change(time: Array, value: Array) -> Array:
        return np.clip(value, -share * np.abs(value).max(), share * np.abs(value).max())

    return lambda drive: changed(drive, name, change)


def drifting(name: str, deviations: float) -> Fault:
    return lambda drive: changed(
        drive, name, lambda time, value: value + deviations * value.std() * time / time[-1]
    )


def scaled(name: str, factor: float) -> Fault:
    return lambda drive: with_channel(
        drive, replace(drive.channels[name], value=drive.channels[name].value * factor)
    )


def swapped(first: str, second: str) -> Fault:
    def fault(drive: Drive) -> Drive:
        a, b = drive.channels[first], drive.channels[second]
        drive = with_channel(drive, replace(a, time_s=b.time_s, value=b.value))
        return with_channel(drive, replace(b, time_s=a.time_s, value=a.value))

    return fault


def clocked(name: str, factor: float) -> Fault:
    return lambda drive: with_channel(
        drive, replace(drive.channels[name], time_s=drive.channels[name].time_s * factor)
    )


def findings(drive: Drive) -> list[Finding]:
    return [f for f in check_drive(drive, VEHICLE) if f.severity != "info"]


def only(drive: Drive, kind: str, name: str) -> Finding:
    """The finding on a faulty channel; nothing is said of any other."""
    found = findings(drive)
    assert [f.kind for f in found] == [kind], [f.text for f in found]
    assert found[0].channels[0] == name
    assert drive.channels[name].signal in found[0].text
    return found[0]


def test_nothing_is_said_of_the_sound_recordings(drive: Drive) -> None:
    assert findings(drive) == []


def test_nothing_is_said_of_missing_physics() -> None:
    for folder in sorted(recordings("practice").glob("p*")):
        vehicle = load_vehicle(folder / "vehicle.toml")
        for run in load_drives(sorted(folder.glob("run*")), folder / "signals.toml"):
            faults = SensorFaults()
            faults.put_right(run, vehicle, run.name)
            assert faults.found == []
            assert faults.lost == {}


@pytest.mark.parametrize("name", ["car_yaw_rate", "steering_wheel_angle", "hitch_lateral_force"])
@pytest.mark.parametrize("size", [0.8, -6.0])
def test_spikes(drive: Drive, name: str, size: float) -> None:
    at = (3.21, 9.7, 9.72, 26.0)
    found = only(spiked(name, at, size)(drive), "spike", name)
    assert [start for start, _ in found.windows] == pytest.approx(at, abs=0.012)


@pytest.mark.parametrize(
    ("name", "start", "stop"),
    [
        ("trailer_yaw_rate", 7.0, 7.8),
        ("car_lateral_acceleration", 5.5, 9.5),
        ("wheel_lateral_force_rr", 6.2, 7.4),
        ("wheel_vertical_load_rl", 5.0, 12.0),
    ],
)
def test_a_frozen_signal(drive: Drive, name: str, start: float, stop: float) -> None:
    found = only(frozen(name, start, stop)(drive), "stuck", name)
    assert found.windows[0] == pytest.approx((start, stop), abs=0.03)
    assert len(found.windows) == 1


def test_a_signal_frozen_to_the_end(drive: Drive) -> None:
    found = only(frozen("car_yaw_rate", 17.0, 99.0)(drive), "stuck", "car_yaw_rate")
    assert found.windows[0] == pytest.approx((17.0, drive.duration_s), abs=0.05)


def test_a_dropout(drive: Drive) -> None:
    found = only(silent("trailer_lateral_acceleration", 11.0, 11.4)(drive), "gap",
                 "trailer_lateral_acceleration")  # fmt: skip
    assert found.windows[0] == pytest.approx((11.0, 11.4), abs=0.02)


@pytest.mark.parametrize("name", ["trailer_yaw_rate", "wheel_lateral_force_rl"])
def test_a_clipped_signal(drive: Drive, name: str) -> None:
    spoilt = clipped(name, 0.55)(drive)
    found = only(spoilt, "clipped", name)
    channel = spoilt.channels[name]
    worst = np.abs(channel.value) >= 0.999 * np.abs(channel.value).max()
    inside = np.zeros(len(worst), dtype=np.bool_)
    for start, stop in found.windows:
        inside |= (channel.time_s >= start) & (channel.time_s <= stop)
    assert np.mean(inside[worst]) > 0.9
    assert np.mean(worst[inside]) > 0.9


@pytest.mark.parametrize(
    "name",
    ["hitch_lateral_force", "trailer_lateral_acceleration", "trailer_yaw_rate",
     "wheel_vertical_load_fr", "wheel_lateral_force_rl"],
)  # fmt: skip
@pytest.mark.parametrize("deviations", [2.5, -2.5])
def test_a_drifting_offset(drive: Drive, name: str, deviations: float) -> None:
    found = only(drifting(name, deviations)(drive), "drift", name)
    rate = deviations * float(np.std(drive.channels[name].value)) / drive.duration_s
    assert found.amount == pytest.approx(rate, rel=0.25)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("car_yaw_rate", "trailer_yaw_rate"),
        ("car_lateral_acceleration", "trailer_lateral_acceleration"),
        ("wheel_vertical_load_fl", "wheel_vertical_load_fr"),
        ("wheel_lateral_force_rl", "wheel_lateral_force_rr"),
        ("wheel_lateral_force_fr", "wheel_lateral_force_rr"),
    ],
)
def test_swapped_channels(drive: Drive, first: str, second: str) -> None:
    found = only(swapped(first, second)(drive), "swapped", first)
    assert found.channels == (first, second)


def all_of(*faults: Fault) -> Fault:
    """Several sensors are faulty."""
    return lambda drive: functools.reduce(lambda spoilt, fault: fault(spoilt), faults, drive)


G = 9.80665
CAR_ACC, TRAILER_ACC = "car_lateral_acceleration", "trailer_lateral_acceleration"
CAR_YAW, TRAILER_YAW = "car_yaw_rate", "trailer_yaw_rate"
HITCH, STEER = "hitch_lateral_force", "steering_wheel_angle"
WHEEL_FORCES = [f"wheel_lateral_force_{wheel}" for wheel in ("fl", "fr", "rl", "rr")]


@pytest.mark.parametrize(
    "wrong",
    [
        {CAR_ACC: G, TRAILER_ACC: G},
        {CAR_YAW: math.pi / 180, TRAILER_YAW: math.pi / 180},
        {CAR_YAW: -1.0, TRAILER_YAW: -1.0},
        {CAR_ACC: G, HITCH: -1.0},
        {HITCH: -1.0, STEER: -1.0},
        {CAR_ACC: G, HITCH: 1e3, TRAILER_YAW: -1.0},
        dict.fromkeys(WHEEL_FORCES, 1e3),
        {HITCH: -1.0} | dict.fromkeys(WHEEL_FORCES, 1e3),
    ],
)
def test_several_wrong_signs_and_units(drive: Drive, wrong: dict[str, float]) -> None:
    spoilt = all_of(*(scaled(name, 1.0 / factor) for name, factor in wrong.items()))(drive)
    found = [f for f in check_drive(spoilt, VEHICLE) if f.kind == "sign_or_unit"]
    assert {f.channels[0]: f.amount for f in found} == pytest.approx(wrong)
    assert all(len(f.channels) == 1 for f in found)


def test_a_wrong_vehicle_is_no_wrong_sign(drive: Drive) -> None:
    """Nothing is put right by factors that explain it no better than others, or badly."""
    assert VEHICLE.car.hitch_to_cog is not None
    for car in (
        replace(VEHICLE.car, mass=2.5 * VEHICLE.car.mass),
        replace(VEHICLE.car, yaw_inertia=3.0 * VEHICLE.car.yaw_inertia),
        replace(VEHICLE.car, hitch_to_cog=0.1 * VEHICLE.car.hitch_to_cog),
    ):
        found = check_drive(drive, replace(VEHICLE, car=car))
        assert not [f for f in found if f.kind == "sign_or_unit" and f.channels]


def test_axes_to_the_right_are_said_to_be_possible(drive: Drive) -> None:
    """Loads of the wheels are positive either way; only the sides are another's."""
    lateral = [n for n in drive.channels if n != "speed" and "vertical" not in n]
    spoilt = all_of(*(scaled(name, -1.0) for name in lateral if name != STEER))(drive)
    found = [f for f in check_drive(spoilt, VEHICLE) if f.severity == "error"]
    sides = [f for f in found if f.kind == "swapped"]
    assert len(sides) == 4
    assert all("SAE axes" in f.text for f in sides)
    assert [f.channels for f in found if f.kind == "sign_or_unit"] == [(STEER,)]


@pytest.mark.parametrize("factor", [1.006, 0.994])
def test_a_clock_of_its_own(drive: Drive, factor: float) -> None:
    spoilt = clocked("trailer_lateral_acceleration", factor)(drive)
    found = only(spoilt, "clock", "trailer_lateral_acceleration")
    assert found.amount == pytest.approx(factor - 1.0, rel=0.2)


def run_diagnosis(
    case: str, fault: Fault, monkeypatch: pytest.MonkeyPatch, runs: int = 2
) -> dict[str, Any]:
    folder = case_folder(case)
    files = sorted(folder.glob("run*"))[:runs]
    spoilt = [fault(d) for d in load_drives(files, folder / "signals.toml")]
    monkeypatch.setattr(data, "load_drives", lambda *_: spoilt)
    return diagnose(files, folder / "vehicle.toml", folder / "signals.toml")


def test_a_frozen_yaw_rate_is_the_fault_of_an_else_consistent_case(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    result = run_diagnosis("p01", frozen("trailer_yaw_rate", 8.0, 10.0), monkeypatch)
    assert result["verdict"] == "measurement_fault"
    (effect,) = result["effects"]
    assert effect["id"] == "sensor_frozen"
    assert effect["channel"] == effect["component"] == "YawRate2"
    assert np.allclose(effect["windows"], [[8.0, 10.0]] * 2, atol=0.05)
    assert any("YawRate2: frozen" in text and "left out" in text for text in result["checks"])


@pytest.mark.parametrize(
    ("fault", "names"),
    [
        (
            all_of(
                spiked("car_yaw_rate", (6.0, 14.0), 4.0),
                scaled("hitch_lateral_force", -1.0),
                scaled("car_lateral_acceleration", 1 / 9.80665),
                silent("steering_wheel_angle", 7.0, 7.4),
            ),
            {
                ("sensor_spikes", "YawRate1"),
                ("sensor_sign", "HitchFy"),
                ("sensor_unit", "LatAccRear1"),
            },
        ),
        (swapped("car_yaw_rate", "trailer_yaw_rate"), {("sensor_swapped", "YawRate1")}),
    ],
)
def test_the_physics_behind_is_found_all_the_same(
    fault: Fault, names: set[tuple[str, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    result = run_diagnosis("p07", fault, monkeypatch, runs=1)
    assert result["verdict"] == "missing_physics"
    friction, *rest = result["effects"]
    assert friction["id"] == "hitch_friction"
    assert friction["parameters"]["moment_nm"]["value"] == pytest.approx(130.0, rel=0.05)
    assert {(e["id"], e["channel"]) for e in rest} == names
    assert result["checks"]


@pytest.mark.parametrize(("left", "right"), [(1.0, True), (0.0, False)])
def test_a_drift_that_was_none_is_seen_in_what_the_fit_leaves(left: float, right: bool) -> None:
    """A ramp that was taken off a sound channel stays behind alone: nothing else makes one."""
    from test_diagnose import synthetic

    from swaywatch.diagnose.evidence.drifts import contradicted
    from swaywatch.diagnose.fit.fit import Fitter

    names, rate = ("wheel_lateral_force_fr", "wheel_lateral_force_fl"), -5.0
    problem = synthetic((), seed=5)
    run = problem.runs[0]
    run.channels[names[0]] = run.channels[names[0]] - left * rate * run.time
    text = "FyFR: its offset (or that of FyFL) drifts"
    found = Finding("warning", "drift", ("FyFR", "FyFL"), text, 0.0, names, ((0.0, 25.0),), rate)
    fitter = Fitter(problem)
    fit = fitter.run(fitter.start(), 4)
    said = contradicted(fitter, fit, [(run.name, found)])
    assert said == (frozenset((run.name, name) for name in names) if right else frozenset())
    kept = SensorFaults(right=said)
    assert kept._drifting(found, run.name) == ([] if right else [found])
    assert len(kept.checks) == right
