"""What the checks of the data find, and what they leave alone."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
from conftest import DATA, recordings

from swaywatch.checks.quality import Finding, check_channel, check_drive
from swaywatch.drive import Channel, Drive, load_drive, load_drives
from swaywatch.vehicle_file import load_vehicle

P01 = DATA / "practice" / "p01"
VEHICLE = load_vehicle(P01 / "vehicle.toml")


@pytest.fixture(scope="module", params=["run1", "run2"])
def drive(request: pytest.FixtureRequest) -> Drive:
    return load_drive([P01 / f"{request.param}.blf"], P01 / "signals.toml")


def changed(drive: Drive, name: str, value: npt.NDArray[np.float64]) -> Drive:
    return replace(
        drive, channels={**drive.channels, name: replace(drive.channels[name], value=value)}
    )


def worth_telling(findings: list[Finding]) -> list[Finding]:
    return [finding for finding in findings if finding.severity != "info"]


def test_a_sound_recording_has_no_findings(drive: Drive) -> None:
    assert worth_telling(check_drive(drive, VEHICLE)) == []


@pytest.mark.parametrize("moment_nm_s", [2e4, 6e4, 1.5e5])
def test_what_turns_the_car_is_no_wrong_sign_of_a_wheel(drive: Drive, moment_nm_s: float) -> None:
    """A brake on one side: front and rear axle hold against it, both wheels of each alike."""
    car = VEHICLE.car
    rate = drive.channels["car_yaw_rate"]
    braked = drive
    for end, sense in (("f", 1.0), ("r", -1.0)):
        for side in "lr":
            name = f"wheel_lateral_force_{end}{side}"
            own = drive.channels[name]
            moment = moment_nm_s * np.interp(own.time_s, rate.time_s, rate.value)
            lever = 2.0 * (car.front_axle_to_cog + car.rear_axle_to_cog)
            braked = changed(braked, name, own.value + sense * moment / lever)
    found = worth_telling(check_drive(braked, VEHICLE))
    assert not [f for f in found if f.severity == "error"]
    assert moment_nm_s < 1e5 or any("yaw moments on the car" in f.text for f in found)


def test_missing_physics_is_no_fault_of_the_signals() -> None:
    for case in ("p02", "p03", "p05", "p06", "p07", "p08", "p10"):
        folder = recordings("practice", case)
        vehicle = load_vehicle(folder / "vehicle.toml")
        for other in load_drives(sorted(folder.glob("run*")), folder / "signals.toml"):
            assert worth_telling(check_drive(other, vehicle)) == []


@pytest.mark.parametrize(
    ("channel", "factor", "words"),
    [
        ("steering_wheel_angle", -1.0, "sign"),
        ("steering_wheel_angle", np.pi / 180, "in rad, not in deg"),
        ("car_yaw_rate", -1.0, "sign"),
        ("car_yaw_rate", np.pi / 180, "in rad/s, not in deg/s"),
        ("trailer_yaw_rate", -1.0, "sign"),
        ("trailer_yaw_rate", 180 / np.pi, "in deg/s, not in rad/s"),
        ("car_lateral_acceleration", -1.0, "sign"),
        ("car_lateral_acceleration", 1 / 9.80665, "in g"),
        ("trailer_lateral_acceleration", -1.0, "sign"),
        ("hitch_lateral_force", -1.0, "sign"),
        ("wheel_lateral_force_rl", -1.0, "sign"),
        ("wheel_lateral_force_fl", 1e-3, "left and right"),
        ("wheel_vertical_load_rr", 1 / 9.80665, "left and right"),
        ("speed", 1 / 3.6, "in m/s, not in km/h"),
        ("speed", 3.6, "km/h"),
    ],
)
def test_wrong_signs_and_units_are_named(
    drive: Drive, channel: str, factor: float, words: str
) -> None:
    wrong = changed(drive, channel, drive.channels[channel].value * factor)
    errors = [f for f in check_drive(wrong, VEHICLE) if f.severity == "error"]
    assert errors
    assert drive.channels[channel].signal in errors[0].text
    assert words in errors[0].text


@pytest.mark.parametrize(
    ("name", "delay_s"),
    [
        ("car_lateral_acceleration", 0.06),
        ("trailer_yaw_rate", 0.12),
        ("trailer_lateral_acceleration", 0.12),
        ("car_yaw_rate", 0.08),  # enters the balances by its slope only: less shows less
    ],
)
def test_a_late_sensor_is_named(drive: Drive, name: str, delay_s: float) -> None:
    channel = drive.channels[name]
    late = np.interp(channel.time_s - delay_s, channel.time_s, channel.value)
    found = worth_telling(check_drive(changed(drive, name, late), VEHICLE))
    assert [finding.kind for finding in found] == ["delay"]
    assert found[0].signals == (channel.signal,)
    assert (
        f"{delay_s * 1e3:.0f} ms too late" in found[0].text
        or abs(float(found[0].text.split(" comes ")[1].split(" ms")[0]) - delay_s * 1e3)
        < 0.2 * delay_s * 1e3
    )


def test_what_a_rolling_body_explains_as_well_is_only_remarked(drive: Drive) -> None:
    channel = drive.channels["trailer_yaw_rate"]
    late = np.interp(channel.time_s - 0.035, channel.time_s, channel.value)
    found = check_drive(changed(drive, "trailer_yaw_rate", late), VEHICLE)
    assert worth_telling(found) == []
    (remark,) = [finding for finding in found if finding.kind == "delay"]
    assert "roll" in remark.text
    assert remark.channels == ()


def test_the_late_sensor_of_the_practice_case_is_named() -> None:
    folder = recordings("practice", "p09")
    vehicle = load_vehicle(folder / "vehicle.toml")
    for drive in load_drives(sorted(folder.glob("run*")), folder / "signals.toml"):
        found = worth_telling(check_drive(drive, vehicle))
        assert [finding.signals for finding in found] == [("LatAccRear1",)]
        assert re.search("(59|60|61) ms too late", found[0].text)  # one step of the search


def test_two_speeds_of_clock_within_a_drive_are_named(drive: Drive) -> None:
    def warped(channel: Channel) -> Channel:
        time = channel.time_s
        return replace(channel, time_s=np.where(time > 20.0, 20.0 + 1.5 * (time - 20.0), time))

    odd = replace(drive, channels={n: warped(c) for n, c in drive.channels.items()})
    errors = [f for f in check_drive(odd, VEHICLE) if f.severity == "error"]
    assert "clock" in {finding.kind for finding in errors}


def test_two_clocks_that_drift_apart_are_named() -> None:
    drive = load_drive([P01 / "run1.blf"], P01 / "signals.toml")

    def other_clock(name: str, channel: Channel) -> Channel:
        if not name.startswith("trailer"):
            return replace(channel, files=("car.blf",))
        return replace(channel, files=("trailer.blf",), time_s=channel.time_s * 1.005)

    odd = replace(drive, channels={n: other_clock(n, c) for n, c in drive.channels.items()})
    errors = [f for f in check_drive(odd, VEHICLE) if f.severity == "error"]
    assert [finding.kind for finding in errors] == ["clock"]
    assert "two clocks at different rates" in errors[0].text
    assert "trailer.blf" in errors[0].text


def test_gaps_stuck_clipped_and_wild_samples_are_named(drive: Drive) -> None:
    channel = drive.channels["trailer_yaw_rate"]
    keep = (channel.time_s < 8.0) | (channel.time_s > 8.7)
    gap = replace(channel, time_s=channel.time_s[keep], value=channel.value[keep])
    assert [f.kind for f in check_channel(gap)] == ["gap"]
    held = channel.value.copy()
    held[1000:1150] = held[1000]
    assert [f.kind for f in check_channel(replace(channel, value=held))] == ["stuck"]
    flat = np.clip(channel.value, None, 0.6 * channel.value.max())
    assert [f.kind for f in check_channel(replace(channel, value=flat))] == ["clipped"]
    wild = channel.value.copy()
    wild[[700, 2100]] += 0.5
    assert [f.kind for f in check_channel(replace(channel, value=wild))] == ["spike"]
    dead = np.zeros_like(channel.value)
    assert [f.kind for f in check_channel(replace(channel, value=dead))] == ["stuck"]


def test_a_corner_of_a_steering_robot_is_no_spike(drive: Drive) -> None:
    """Down a slope, a jump, and up another slope: the tip lies on the course that follows."""
    channel = drive.channels["steering_wheel_angle"]
    before, after = np.arange(40, -1, -1), np.arange(40)
    value = np.zeros_like(channel.value)
    value[500:541], value[541:581] = 1.8 + 0.23 * before, 0.3 + 0.6 * after
    value[541] = 0.2
    value = np.radians(value)
    assert not [f for f in check_channel(replace(channel, value=value)) if f.kind == "spike"]
    value[520] += 0.2
    spikes = [f for f in check_channel(replace(channel, value=value)) if f.kind == "spike"]
    assert [len(f.windows) for f in spikes] == [1]
