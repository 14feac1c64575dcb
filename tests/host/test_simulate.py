"""Scenarios: manoeuvres, drivers, sensors, timing, files, and the bus feed."""

from __future__ import annotations

import errno
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import DATA, Clock

from swaywatch.cli import main
from swaywatch.drive import load_drive
from swaywatch.errors import RecordingError, ScenarioError
from swaywatch.recording import Frames, read_recording
from swaywatch.simulate import Scenario, load_scenario, simulate_scenario
from swaywatch.simulate.campaign import jobs_of, run_campaign
from swaywatch.simulate.feed import feed
from swaywatch.simulate.manoeuvres import MANOEUVRES
from swaywatch.simulate.scenario import read_scenario
from swaywatch.simulate.sensors import Sensor

FOLDER = DATA / "practice" / "p01"


def scenario(**content: Any) -> Scenario:
    base: dict[str, Any] = {
        "vehicle": "vehicle.toml",
        "duration_s": 20.0,
        "speed_kmh": 90.0,
        "sensors": {"preset": "perfect"},
    }
    return read_scenario({**base, **content}, "test", FOLDER, "test.toml")


KINDS: dict[str, dict[str, Any]] = {
    "impulse": {"angle_deg": 10.0},
    "double_impulse": {"gap_s": 4.0},
    "impulse_ladder": {"speeds_kmh": [80, 85], "hold_s": 4.0, "settle_s": 1.0},
    "slalom": {"angle_deg": 8.0},
    "sine_sweep": {"angle_deg": 5.0, "duration_s": 15.0},
    "lane_change": {},
    "steady_circle": {"angle_deg": 15.0},
    "gust": {"force_n": 1500.0, "body": "trailer"},
    "banked_road": {"angle_deg": 2.0},
    "accelerate": {"speed_kmh": 100.0},
    "brake": {"speed_kmh": 60.0, "acceleration_m_s2": 2.0},
}


def test_every_manoeuvre_is_tried() -> None:
    assert set(KINDS) == set(MANOEUVRES)


@pytest.mark.parametrize("kind", KINDS)
def test_manoeuvres_move_the_combination(kind: str) -> None:
    _, trace = simulate_scenario(scenario(manoeuvre=[{"kind": kind, **KINDS[kind]}]))
    assert trace.whole
    moved = np.abs(trace["trailer_yaw_rate"]).max() > 0.002
    assert moved or np.ptp(trace["speed"]) > 1.0
    before = trace.time_s < 0.99
    assert np.abs(trace["car_yaw_rate"][before]).max() == 0.0


def test_impulse_is_the_half_sine_of_the_reference() -> None:
    plan = scenario(manoeuvre=[{"kind": "impulse", "start_s": 2.0}]).plan
    assert np.degrees(plan.steering_rad.max()) == pytest.approx(19.0, abs=0.01)
    moving = plan.time_s[np.abs(plan.steering_rad) > 0.0]
    assert moving[-1] - moving[0] == pytest.approx(0.5 / 0.675, abs=0.015)


def test_ladder_reaches_its_speeds_before_each_impulse() -> None:
    plan = scenario(
        duration_s=60.0,
        manoeuvre=[{"kind": "impulse_ladder", "speeds_kmh": [80, 90, 100], "hold_s": 8.0}],
    ).plan
    starts = [end - 0.5 / 0.675 for end in plan.impulses_s]
    speeds = np.interp(starts, plan.time_s, plan.speed_m_s) * 3.6
    assert speeds == pytest.approx([80.0, 90.0, 100.0])


def last_swing(driver: dict[str, Any]) -> float:
    """Yaw rate of the trailer left at the end of an impulse near the critical speed."""
    made = scenario(
        speed_kmh=112.0, driver=driver, manoeuvre=[{"kind": "impulse", "angle_deg": 15.0}]
    )
    _, trace = simulate_scenario(made)
    return float(np.ptp(trace["trailer_yaw_rate"][-400:]))


def test_drivers_differ() -> None:
    holds = last_swing({"kind": "holds"})
    free = last_swing({"kind": "lets_go", "from_s": 2.0})
    worse = last_swing({"kind": "over_corrects", "gain_s": 1.0, "reaction_s": 0.4})
    assert worse > 1.5 * holds
    assert abs(free - holds) > 0.05 * holds


def test_closed_loop_without_correction_is_the_open_loop() -> None:
    idle = {"kind": "over_corrects", "gain_s": 0.0}
    assert last_swing(idle) == pytest.approx(last_swing({"kind": "holds"}), rel=1e-6)


def test_same_seed_same_file_other_seed_another(tmp_path: Path) -> None:
    text = """
vehicle = "{vehicle}"
duration_s = 5.0
speed_kmh = 90.0
[[manoeuvre]]
kind = "impulse"
[timing]
jitter_s = 0.001
""".format(vehicle=(FOLDER / "vehicle.toml").as_posix())
    source = tmp_path / "drive.toml"
    source.write_text(text)
    for name, seed in (("a", "3"), ("b", "3"), ("c", "4")):
        out = str(tmp_path / f"{name}.log")
        assert main(["simulate", str(source), "--out", out, "--seed", seed]) == 0
    a, b, c = ((tmp_path / f"{name}.log").read_bytes() for name in "abc")
    assert a == b
    assert a != c


@pytest.mark.parametrize("suffix", [".blf", ".asc", ".log", ".trc", ".mf4", ".csv", ".parquet"])
def test_every_format_reads_back_as_the_truth(tmp_path: Path, suffix: str) -> None:
    source, out, signals = (tmp_path / n for n in ("d.toml", f"d{suffix}", "signals.toml"))
    source.write_text(
        f'vehicle = "{(FOLDER / "vehicle.toml").as_posix()}"\nduration_s = 4.0\nspeed_kmh = 90.0\n'
        '[[manoeuvre]]\nkind = "impulse"\n[sensors]\npreset = "perfect"\n'
        "[timing]\njitter_s = 0.0\nlatency_s = 0.0\n"
    )
    arguments = ["simulate", str(source), "--out", str(out), "--signals", str(signals)]
    assert main(arguments) == 0
    drive = load_drive([out], signals)
    _, trace = simulate_scenario(
        scenario(
            duration_s=4.0, manoeuvre=[{"kind": "impulse"}],
            timing={"jitter_s": 0.0, "latency_s": 0.0},
        )
    )  # fmt: skip
    for name, resolution in (("trailer_yaw_rate", 2e-4), ("wheel_vertical_load_rl", 1.0)):
        channel = drive.channels[name]
        expected = np.interp(channel.time_s, trace.time_s, trace[name])
        slope = np.abs(np.gradient(trace[name], 0.005)).max()
        assert np.abs(channel.value - expected).max() < resolution + 0.008 * slope, name


def test_sensor_faults_are_as_written() -> None:
    time = np.arange(0.0, 20.0, 0.005)
    value = np.sin(time)
    at = np.arange(1.0, 19.0, 0.01)
    random = np.random.default_rng(1)
    late = Sensor(delay_s=0.1, gain=1.2, bias=0.3).measure(time, value, at, random)
    assert late == pytest.approx(1.2 * np.sin(at - 0.1) + 0.3, abs=1e-5)
    noisy = Sensor(noise=0.05).measure(time, value, at, random) - np.sin(at)
    assert np.std(noisy) == pytest.approx(0.05, rel=0.05)
    stepped = Sensor(quantisation=0.25).measure(time, value, at, random)
    assert np.all(stepped * 4.0 == np.rint(stepped * 4.0))
    frozen = Sensor(frozen_from_s=10.0, noise=0.01).measure(time, value, at, random)
    assert np.ptp(frozen[at > 10.0]) == 0.0


def test_accelerometer_sees_position_roll_and_gravity() -> None:
    circle = [{"kind": "steady_circle", "angle_deg": 15.0}]
    level, trace = simulate_scenario(scenario(manoeuvre=circle))
    tilted, _ = simulate_scenario(
        scenario(
            manoeuvre=circle,
            sensors={
                "preset": "perfect",
                "car_lateral_acceleration": {"roll_gravity": True, "position_m": 0.0},
            },
        )
    )
    name = "car_lateral_acceleration"
    more = tilted.channels[name].value[-1] - level.channels[name].value[-1]
    assert more == pytest.approx(9.81 * np.sin(trace["car_roll"][-1]), rel=1e-3)
    assert level.channels[name].position_m == -1.383
    assert tilted.channels[name].position_m == 0.0


def test_lost_messages_are_missing_and_times_grow() -> None:
    drive, _ = simulate_scenario(
        scenario(manoeuvre=[{"kind": "impulse"}], timing={"lost": 0.2, "jitter_s": 0.02})
    )
    channel = drive.channels["car_yaw_rate"]
    assert 0.75 * 2000 < len(channel.time_s) < 0.85 * 2000
    assert np.all(np.diff(channel.time_s) > 0.0)


def test_single_track_as_plant_and_its_limits() -> None:
    drive, _ = simulate_scenario(scenario(model="single_track", manoeuvre=[{"kind": "impulse"}]))
    assert "trailer_yaw_rate" in drive.channels
    assert "wheel_lateral_force_fl" not in drive.channels
    with pytest.raises(ScenarioError, match="single_track"):
        scenario(model="single_track", physics=[{"id": "hitch_friction"}])


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ({"speed_kmh": 900}, "speed_kmh = 900 km/h is out of range"),
        ({"colour": "red"}, "unknown key 'colour'; known: .*duration_s"),
        ({"vehicle": 3}, "vehicle is missing"),
        ({"manoeuvre": [{"kind": "loop"}]}, "expected one of: impulse"),
        ({"manoeuvre": [{"kind": "impulse", "angel_deg": 3}]}, "unknown key 'angel_deg'"),
        ({"manoeuvre": {"kind": "impulse"}}, "array of tables"),
        ({"physics": [{"id": "hitch_glue"}]}, "hitch_load'. Known: .*hitch_friction"),
        ({"physics": [{"id": "hitch_friction", "moment_nm": -1}]}, "outside 0 to 3000"),
        ({"manoeuvre": [{"kind": "gust", "force_n": 1e9}]}, "outside -8000"),
        ({"manoeuvre": [{"kind": "impulse_ladder", "speeds_kmh": [80, 90]}]}, "the ladder takes"),
        ({"timing": {"rate_hz": 0}}, "rate_hz = 0 Hz is out of range"),
    ],
)
def test_bad_scenarios_are_refused(content: dict[str, Any], text: str) -> None:
    with pytest.raises(ScenarioError, match=text):
        scenario(**content)


def test_bad_sensor_is_refused_with_the_channels_that_are_there() -> None:
    with pytest.raises(ScenarioError, match="unknown key 'yaw'"):
        simulate_scenario(scenario(sensors={"yaw": {"noise": 1.0}}))


def test_command_writes_nothing_on_bad_input(tmp_path: Path, capsys: Any) -> None:
    source = tmp_path / "bad.toml"
    source.write_text('vehicle = "nowhere.toml"\nduration_s = 4.0\nspeed_kmh = 90.0\n')
    assert main(["simulate", str(source), "--out", str(tmp_path / "x.log")]) == 1
    assert "nowhere.toml" in capsys.readouterr().err
    assert not (tmp_path / "x.log").exists()


# Feed ---------------------------------------------------------------------------------------------


def frames(count: int = 50) -> Frames:
    return read_recording(FOLDER / "run1.blf").frames.take(slice(0, count))  # type: ignore[union-attr]


class FakeBus:
    """Records what is sent and when; can be slow once, or full."""

    def __init__(self, clock: Clock, slow_at: int = -1, full: int = 0) -> None:
        self.clock, self.slow_at, self.full = clock, slow_at, full
        self.times: list[float] = []

    def send(self, msg: Any, timeout: float | None = None) -> None:
        if self.full:
            self.full -= 1
            raise OSError(errno.ENOBUFS, "No buffer space available")
        if len(self.times) == self.slow_at:
            self.clock.now += 0.01
        self.times.append(self.clock.now)


@pytest.mark.parametrize("speed", [1.0, 4.0])
def test_feed_keeps_absolute_deadlines(speed: float) -> None:
    clock = Clock()
    bus = FakeBus(clock, slow_at=10)
    sent = frames()
    feed(sent, bus, speed=speed, clock=clock, sleep=clock.sleep)
    due = 100.0 + (sent.time_ns - sent.time_ns[0]) * 1e-9 / speed
    late = np.array(bus.times) - due
    assert late.min() >= 0.0
    assert late[:10].max() < 1e-4
    assert late[-1] < 1e-4  # the hold-up at frame 10 is not carried on


def test_feed_waits_for_a_full_buffer_and_loses_nothing() -> None:
    clock = Clock()
    bus = FakeBus(clock, full=7)
    result = feed(frames(), bus, clock=clock, sleep=clock.sleep)
    assert (result.sent, result.waits, len(bus.times)) == (50, 7, 50)


def test_feed_says_so_when_the_bus_never_takes_the_frame() -> None:
    clock = Clock()
    with pytest.raises(RecordingError, match=r"frame 1 .* could not be sent"):
        feed(frames(), FakeBus(clock, full=10**6), clock=clock, sleep=clock.sleep)


def test_feed_command_on_a_virtual_bus(capsys: Any) -> None:
    import can

    source = str(FOLDER / "run1.blf")
    arguments = ["feed", source, "--interface", "virtual", "--channel", "swaywatch-test"]
    with can.Bus(interface="virtual", channel="swaywatch-test") as listener:
        assert main([*arguments, "--speed", "0"]) == 0
        heard = 0
        while listener.recv(timeout=0.0) is not None:
            heard += 1
    total = len(read_recording(source).frames or ())
    assert heard == total
    assert f"{total} frames sent" in capsys.readouterr().out


def test_feed_of_a_recording_needs_no_simulator() -> None:
    """The feed works where only what analysis needs is installed: no numba, no MuJoCo."""
    code = "import sys, swaywatch.simulate.feed; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_feed_command_names_an_interface_that_is_not_there(capsys: Any) -> None:
    source = str(FOLDER / "run1.blf")
    assert main(["feed", source, "--interface", "socketcan", "--channel", "nocan7"]) == 1
    assert "nocan7" in capsys.readouterr().err


# Campaigns ----------------------------------------------------------------------------------------

CAMPAIGN = """
vehicle = "{vehicle}"
duration_s = 6.0
speed_kmh = 90.0
[[manoeuvre]]
kind = "impulse"
angle_deg = 5.0
[[vary]]
key = "speed_kmh"
low = 80.0
high = 120.0
[[vary]]
key = "manoeuvre.0.angle_deg"
low = 5.0
high = 15.0
"""


def campaign_file(folder: Path, text: str = CAMPAIGN) -> Path:
    path = folder / "campaign.toml"
    path.write_text(text.replace("{vehicle}", (FOLDER / "vehicle.toml").as_posix()))
    return path


def test_campaign_gives_the_same_drives_on_one_core_and_on_two(tmp_path: Path) -> None:
    jobs = jobs_of(campaign_file(tmp_path), 6, seed=5)
    one, two = run_campaign(jobs, workers=1), run_campaign(jobs, workers=2)
    assert one == two
    assert len({outcome.largest_yaw_rate_rad_s for outcome in one}) == 6
    speeds = [dict(outcome.values)["speed_kmh"] for outcome in one]
    assert 80.0 <= min(speeds) < max(speeds) <= 120.0


def test_campaign_command_writes_recordings_and_their_table(tmp_path: Path) -> None:
    out = tmp_path / "drives"
    arguments = ["simulate", str(campaign_file(tmp_path)), "--drives", "3", "--format", ".log"]
    assert main([*arguments, "--out", str(out), "--workers", "1"]) == 0
    assert sorted(path.name for path in out.glob("*.log")) == [
        f"drive_0000{number}.log" for number in (1, 2, 3)
    ]
    lines = (out / "drives.csv").read_text().splitlines()
    assert lines[0].startswith("drive,seed,speed_kmh,manoeuvre.0.angle_deg,")
    assert len(lines) == 4


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (("manoeuvre.0.angle_deg", "manoeuvre.7.angle_deg"), "nothing in the scenario"),
        (("high = 120.0", "high = 20.0"), "high = 20 .* out of range"),
        (("duration_s = 6.0", "duration_s = 0.0"), "duration_s = 0 s is out of range"),
    ],
)
def test_bad_campaigns_are_refused(tmp_path: Path, change: tuple[str, str], text: str) -> None:
    with pytest.raises(ScenarioError, match=text):
        run_campaign(jobs_of(campaign_file(tmp_path, CAMPAIGN.replace(*change)), 2))


# Examples and lists -------------------------------------------------------------------------------

EXAMPLES = sorted(
    file for file in (DATA / "scenarios").glob("*.toml") if "[reaction]" not in file.read_text()
)
"""Those with a reaction are for `swaywatch hil`: tests/host/test_hil.py, tests/hil."""


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_run(path: Path) -> None:
    drive, trace = simulate_scenario(load_scenario(path))
    assert trace.whole
    assert np.abs(trace["trailer_yaw_rate"]).max() > 0.01
    assert drive.duration_s == pytest.approx(trace.time_s[-1], abs=0.1)


def test_list_of_physics(capsys: Any) -> None:
    assert main(["physics"]) == 0
    assert "hitch_friction" in capsys.readouterr().out
    assert main(["physics", "steering_compliance"]) == 0
    text = capsys.readouterr().out
    for part in ("Eq. 5.3", "stiffness_n_per_rad", "N/rad", "100000 to 1e+08"):
        assert part in text
    assert main(["physics", "glue"]) == 1
    assert "steering_compliance" in capsys.readouterr().err
