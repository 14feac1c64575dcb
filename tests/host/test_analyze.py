"""The main job from recording to report, on the practice case in which nothing is concealed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA

from swaywatch.cli import main
from swaywatch.ecu.core import analyze_drive, model_damping
from swaywatch.recording import read_recording, write_recording
from swaywatch.reproduce.study import VEHICLE, ImpulseDrive, drive_of
from swaywatch.vehicle_file import load_vehicle

P01 = DATA / "practice" / "p01"
TRUTH = json.loads((P01 / "truth.json").read_text())
AXLES = ("car_front", "car_rear", "trailer_front", "trailer_rear")
ARGUMENTS = ["--vehicle", str(P01 / "vehicle.toml"), "--signals", str(P01 / "signals.toml")]


@pytest.fixture(scope="module", params=["blf", "mf4", "asc", "log", "trc", "csv", "parquet"])
def summary(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> dict:
    """summary.json of both runs, read from one of the formats."""
    folder = tmp_path_factory.mktemp(request.param)
    files = []
    for run in ("run1", "run2"):
        frames = read_recording(P01 / f"{run}.blf").frames
        assert frames is not None
        path = folder / f"{run}.{request.param}"
        write_recording(path, frames)
        files.append(str(path))
    out = folder / "out"
    assert main(["analyze", *files, *ARGUMENTS, "--out", str(out), "--no-report"]) == 0
    return dict(json.loads((out / "summary.json").read_text()))


@pytest.mark.parametrize("run", [0, 1])
def test_cornering_stiffness_within_3_percent(summary: dict, run: int) -> None:
    vehicle = load_vehicle(P01 / "vehicle.toml")
    values = summary["drives"][run]["values"]
    for axle in AXLES:
        body, _, which = axle.partition("_")
        true = getattr(getattr(vehicle, body), f"{which}_cornering_stiffness")
        found = values[f"{axle}.cornering_stiffness_n_per_rad"]
        assert found["value"] == pytest.approx(true, rel=0.03)
        assert found["estimates"] >= 50


@pytest.mark.parametrize("run", [0, 1])
def test_critical_speed_within_2_kmh(summary: dict, run: int) -> None:
    found = summary["drives"][run]["values"]["v_crit_m_s"]
    assert found["value"] * 3.6 == pytest.approx(TRUTH["plant_vcrit_kmh"], abs=2.0)
    assert 0.0 < found["standard_error"] * 3.6 < 2.0


def test_dominant_frequency_within_5_mhz(summary: dict) -> None:
    vehicle = load_vehicle(P01 / "vehicle.toml")
    _, frequency = model_damping(vehicle, [TRUTH["run1"]["v_kmh"] / 3.6])
    found = summary["drives"][0]["values"]["frequency_hz"]["value"]
    assert found == pytest.approx(float(frequency[0]), abs=0.005)


def test_nothing_is_complained_of(summary: dict) -> None:
    for drive in summary["drives"]:
        assert [f for f in drive["findings"] if f["severity"] != "info"] == []
        assert drive["fault_count"]["range"] == 0
        assert drive["fault_count"]["time"] == 0


def test_model_has_the_golden_values() -> None:
    vehicle = load_vehicle(P01 / "vehicle.toml")
    speeds = np.array([80.0, 100.0, 107.9, 117.3, 140.0]) / 3.6
    damping, frequency = model_damping(vehicle, speeds)
    assert damping == pytest.approx([0.2520, 0.1115, 0.0689, 0.0250, -0.0587], abs=1e-4)
    assert frequency == pytest.approx([0.6478, 0.6659, 0.6690, 0.6712, 0.6729], abs=1e-4)


@pytest.mark.parametrize("suffix", ["parquet", "mf4", "csv"])
def test_report_json_and_estimates_are_written(tmp_path: Path, suffix: str) -> None:
    out = tmp_path / "out"
    run = str(P01 / "run1.blf")
    assert main(["analyze", run, *ARGUMENTS, "--out", str(out), "--estimates", suffix]) == 0
    names = {path.name for path in out.iterdir()}
    assert names == {"report.html", "summary.json", f"estimates_run1.{suffix}"}
    page = (out / "report.html").read_text()
    for word in ("critical speed", "Cornering stiffness", "Data quality", "class='plot'"):
        assert word in page
    signals = read_recording(out / f"estimates_run1.{suffix}").signals
    assert signals is not None
    summary = json.loads((out / "summary.json").read_text())
    assert len(signals["frequency_hz"].value) <= summary["drives"][0]["estimates"]
    assert signals["frequency_hz"].unit == "Hz"
    assert np.median(signals["v_crit_m_s"].value) * 3.6 == pytest.approx(123.3, abs=2.0)


def test_missing_signals_switch_off_their_results_only(tmp_path: Path) -> None:
    lines = (P01 / "signals.toml").read_text().splitlines()
    kept = [line for line in lines if not line.startswith(("wheel", "hitch", "trailer_lat"))]
    signals = tmp_path / "signals.toml"
    text = "\n".join(kept).replace("../measurement.dbc", str(DATA / "practice/measurement.dbc"))
    signals.write_text(text)
    out = tmp_path / "out"
    code = main(
        ["analyze", str(P01 / "run1.blf"), "--vehicle", str(P01 / "vehicle.toml"),
         "--signals", str(signals), "--out", str(out)]
    )  # fmt: skip
    assert code == 0
    drive = json.loads((out / "summary.json").read_text())["drives"][0]
    assert "frequency_hz" in drive["values"]
    off = {entry["result"] for entry in drive["switched_off"]}
    assert "effective load of the car's rear axle" in off
    assert "cornering stiffness of the trailer's rear axle" in off
    assert "frequency and damping of the oscillation" not in off
    assert not any(name.startswith("trailer_rear") for name in drive["values"])
    assert "switched off" in (out / "report.html").read_text()


def test_forces_from_the_balances_are_said_to_be_indirect(tmp_path: Path) -> None:
    lines = (P01 / "signals.toml").read_text().splitlines()
    kept = [line for line in lines if not line.startswith(("wheel", "hitch"))]
    signals = tmp_path / "signals.toml"
    text = "\n".join(kept).replace("../measurement.dbc", str(DATA / "practice/measurement.dbc"))
    signals.write_text(text)
    out = tmp_path / "out"
    code = main(
        ["analyze", str(P01 / "run1.blf"), "--vehicle", str(P01 / "vehicle.toml"),
         "--signals", str(signals), "--out", str(out)]
    )  # fmt: skip
    assert code == 0
    drive = json.loads((out / "summary.json").read_text())["drives"][0]
    found = drive["values"]["car_rear.cornering_stiffness_n_per_rad"]["value"]
    assert found == pytest.approx(185.2e3, rel=0.05)
    indirect = {entry["result"] for entry in drive["indirect"]}
    assert "cornering stiffness of the car's rear axle" in indirect


def test_length_of_the_window_is_taken_and_said_on_the_page(tmp_path: Path) -> None:
    words = ["analyze", str(P01 / "run1.blf"), *ARGUMENTS, "--window", "3"]
    assert main([*words, "--out", str(tmp_path)]) == 0
    summary = json.loads((tmp_path / "summary.json").read_text())["drives"][0]
    assert summary["window_oscillations"] == 3.0
    assert "window over 3 oscillations" in (tmp_path / "report.html").read_text()
    signals = read_recording(tmp_path / "estimates_run1.parquet").signals
    assert signals is not None
    kept = signals["frequency_se_hz"].value > 0.0
    turns = (signals["window_s"].value * signals["frequency_hz"].value)[kept]
    assert np.median(turns) == pytest.approx(3.0, rel=0.02)


def test_a_longer_window_errs_less_in_an_undisturbed_swing() -> None:
    """Variance of a frequency falls with the third power of the length."""
    drive, _ = drive_of(
        ImpulseDrive(sensors="typical", speed_kmh=120.0, angle_deg=12.0, duration_s=20.0)
    )
    errors = []
    for window in (1.7, 3.0):
        found = analyze_drive(drive, VEHICLE, window=window)
        free = found.has("line") & (found.time_s > 7.0) & (found.time_s < 16.0)
        errors.append(float(np.median(found["frequency_se_hz"][free])))
    assert errors[1] / errors[0] == pytest.approx((1.7 / 3.0) ** 1.5, rel=0.25)


@pytest.mark.parametrize("window", ["1", "7", "two"])
def test_a_window_out_of_range_is_refused(
    window: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["analyze", str(P01 / "run1.blf"), *ARGUMENTS, "--out", str(tmp_path),
              "--window", window])  # fmt: skip
    assert "expected 1.5 to 6 oscillations" in capsys.readouterr().err
