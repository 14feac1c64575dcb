"""The report on chapters 3, 5 and 6: its theory, its generator, and the whole of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from swaywatch.cli import main
from swaywatch.models.single_track import SingleTrack
from swaywatch.reproduce import chapter5, chapter6
from swaywatch.reproduce.page import Check
from swaywatch.reproduce.study import VEHICLE, Setup, drive_of, identify, ladder_of


def test_complex_stiffness_without_argument_is_the_single_track() -> None:
    expected = 3.6 * SingleTrack.of(VEHICLE).critical_speed()
    assert chapter6.complex_v_crit_kmh(185.2e3 + 0j) == pytest.approx(expected, abs=1e-3)


def test_lag_at_the_rear_axle_lowers_the_critical_speed() -> None:
    lag, lead = (chapter6.complex_v_crit_kmh(185.2e3 * np.exp(1j * turn)) for turn in (-0.05, 0.05))
    assert lag < 123.34 - 4.0
    assert lead > 123.34 + 4.0


def test_front_tyres_and_steering_in_series_are_table_b() -> None:
    tyres = chapter5.tyre_vehicle().car.front_cornering_stiffness
    assert tyres is not None
    series = 1.0 / (1.0 / tyres + 1.0 / 1437.1e3)
    assert series == pytest.approx(109.3e3, rel=1e-4)


@pytest.mark.parametrize("speed", [80.0, 107.9, 117.3])
def test_the_core_reads_the_damping_of_a_simulated_drive(speed: float) -> None:
    """Linear limit, noise-free: damping and frequency within 1 % of the single track."""
    state = identify(Setup(speed_kmh=speed))
    mode = SingleTrack.of(VEHICLE).modes(speed / 3.6)[0]
    assert state.damping_ratio == pytest.approx(mode.damping_ratio, rel=0.01)
    assert state.frequency_hz == pytest.approx(mode.frequency_hz, rel=0.01)


def test_regression_of_damping_finds_the_critical_speed() -> None:
    states = [identify(Setup(speed_kmh=speed)) for speed in (118.0, 122.0, 125.0, 128.0)]
    assert ladder_of(states, 2).v_crit_kmh == pytest.approx(123.34, abs=0.05)
    assert ladder_of(states, 1).v_crit_kmh == pytest.approx(123.34, abs=0.5)


def test_generator_of_table_63_makes_the_phases_of_table_63() -> None:
    common: dict[str, Any] = {
        "speed_kmh": 123.34, "angle_deg": 10.0, "start_s": 48.0, "duration_s": 63.0,
    }  # fmt: skip
    _, plain = drive_of(Setup(**common))
    physics = chapter6.generator_windows(plain)
    _, trace = drive_of(Setup(**common, physics=physics))
    windows = physics[0]["windows"]
    for (start, stop, _, phase), window in zip(chapter6.WINDOWS, windows, strict=True):
        inside = (trace.time_s > start + 0.1) & (trace.time_s < stop - 0.1)
        time = trace.time_s[inside]
        load = chapter6._line(time, trace.axle_load("car_rear")[inside], 2.0 * 0.672)
        force = chapter6._line(time, trace.axle_force("car_rear")[inside] ** 2, 2.0 * 0.672)
        found = np.degrees(np.angle(load / force))
        turn = (found - phase + 180.0) % 360.0 - 180.0
        assert abs(turn) < 20.0  # the window holds 2.7 periods of a changing oscillation
        yaw = chapter6._line(time, trace["car_yaw_rate"][inside], 0.672)
        expected = window["gain_n_s2_per_rad2"] * 0.5 * abs(yaw) ** 2  # Eq. 6.1
        assert abs(load) == pytest.approx(expected, rel=0.15)


def test_check_knows_its_tolerance() -> None:
    assert Check("a", 10.0, 10.4, 0.5, "km/h").met
    assert not Check("a", 10.0, 10.6, 0.5, "km/h").met
    assert not Check("a", 10.0, float("nan"), 0.5, "km/h").met


def test_the_whole_report(tmp_path: Path, capsys: Any) -> None:
    assert main(["reproduce", "--out", str(tmp_path / "report")]) == 0, capsys.readouterr().out
    page = (tmp_path / "report" / "reproduce.html").read_text(encoding="utf-8")
    for title in ("Fig. 3-4", "Fig. 3-5", "Fig. 3-6", "Fig. 3-7", "Table 5-1", "Table 5-2",
                  "Fig. 6-5", "Table 6-3"):  # fmt: skip
        assert title in page
    assert "src=" not in page.split("</script>")[-1]  # nothing is loaded from elsewhere
