"""The report on chapters 3, 5 and 6: its theory, its generator, and the whole of it."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from swaywatch.cli import main
from swaywatch.models.single_track import SingleTrack
from swaywatch.reproduce import chapter5, chapter6, courses, leads
from swaywatch.reproduce.page import Chapter, Check, make_page
from swaywatch.reproduce.study import VEHICLE, ImpulseDrive, drive_of, identify, ladder_of


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
    state = identify(ImpulseDrive(speed_kmh=speed))
    mode = SingleTrack.of(VEHICLE).modes(speed / 3.6)[0]
    assert state.damping_ratio == pytest.approx(mode.damping_ratio, rel=0.01)
    assert state.frequency_hz == pytest.approx(mode.frequency_hz, rel=0.01)


def test_regression_of_damping_finds_the_critical_speed() -> None:
    states = [identify(ImpulseDrive(speed_kmh=speed)) for speed in (118.0, 122.0, 125.0, 128.0)]
    assert ladder_of(states, 2).v_crit_kmh == pytest.approx(123.34, abs=0.05)
    assert ladder_of(states, 1).v_crit_kmh == pytest.approx(123.34, abs=0.5)


def test_generator_of_table_63_makes_the_phases_of_table_63() -> None:
    common: dict[str, Any] = {
        "speed_kmh": 123.34, "angle_deg": 10.0, "start_s": 48.0, "duration_s": 63.0,
    }  # fmt: skip
    _, plain = drive_of(ImpulseDrive(**common))
    physics = chapter6.generator_windows(plain)
    _, trace = drive_of(ImpulseDrive(**common, physics=physics))
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


def test_understeer_of_the_combination_is_that_of_its_steady_states() -> None:
    """Eq. 3.26-3.35; the trailer that the text calls neutral understeers more than the car."""
    model = SingleTrack.of(VEHICLE)
    length, gradient = leads._gradient(model)
    v = 25.0
    assert v / (length + gradient * v**2 / 9.81) == pytest.approx(leads._gain(model, v), rel=1e-6)
    car = leads._gradient(dataclasses.replace(model, has_trailer=False))[1]
    assert car == pytest.approx(0.04016, abs=5e-5)
    assert gradient == pytest.approx(0.03367, abs=5e-5)
    assert leads._gradient(leads.trailer_alone())[1] == pytest.approx(0.0855, abs=1e-3)


def test_ball_load_moves_the_centre_of_gravity() -> None:
    """500 N more on the ball: balance of moments about the axles before and after."""
    still, moved = (leads.ball_load(500.0, stiffness=True, moved=m) for m in (0.0, 2.5))
    assert still == pytest.approx(123.34 + 2.4, abs=0.2)
    assert moved > still + 15.0
    assert leads.ball_load(0.0, stiffness=True, moved=2.5) == pytest.approx(123.34, abs=0.01)


def test_own_and_extra_load_add_as_phasors() -> None:
    largest, _ = courses.together(700.0, courses.OWN_DEG)
    least, _ = courses.together(700.0, courses.OWN_DEG + 180.0)
    assert (largest, least) == pytest.approx((900.0, 500.0))


def test_a_miss_without_a_cause_fails_the_report() -> None:
    assert not Check("a", 10.0, 12.0, 1.0, "km/h", cause="because").met
    text = make_page([Chapter("c", "t", checks=[
        Check("missed", 10.0, 12.0, 1.0, "km/h", cause="because of this"),
        Check("hit", 10.0, 10.5, 1.0, "km/h", cause="never said"),
    ])], 1.0)  # fmt: skip
    assert "because of this" in text
    assert "never said" not in text


def test_check_knows_its_tolerance() -> None:
    assert Check("a", 10.0, 10.4, 0.5, "km/h").met
    assert not Check("a", 10.0, 10.6, 0.5, "km/h").met
    assert not Check("a", 10.0, float("nan"), 0.5, "km/h").met


def test_the_whole_report(tmp_path: Path, capsys: Any) -> None:
    assert main(["reproduce", "--out", str(tmp_path / "report")]) == 0, capsys.readouterr().out
    page = (tmp_path / "report" / "reproduce.html").read_text(encoding="utf-8")
    for title in ("Fig. 3-4", "Fig. 3-5", "Fig. 3-6", "Fig. 3-7", "Table 5-1", "Table 5-2",
                  "Fig. 6-5", "Table 6-3", "Fig. 1-3", "Fig. 3-3", "Fig. 4-4", "Fig. 5-10",
                  "Fig. 5-12", "Fig. 5-13", "Fig. 5-14", "Fig. 6-2", "Fig. 6-6", "Fig. 6-12",
                  "Table 5-1 from the plant", "Roll stiffness times ten"):  # fmt: skip
        assert title in page
    assert "each with its cause" in capsys.readouterr().out
    assert "src=" not in page.split("</script>")[-1]  # nothing is loaded from elsewhere
