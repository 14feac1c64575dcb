"""`swaywatch validate`: the 5 % criterion, the corrections, and the loop that proves them."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from conftest import DATA

from swaywatch.cli import main
from swaywatch.validate.compare import CRITERION, ComparedLine, MeanValue
from swaywatch.validate.correct import OperatingPoint, corrections, lags
from swaywatch.validate.loop import validate
from swaywatch.vehicle_file import load_vehicle

P01 = DATA / "practice" / "p01"
STIFFNESS = {"front_cornering_stiffness": (109300.0, 131200.0),
             "rear_cornering_stiffness": (185200.0, 124400.0)}  # fmt: skip
STEERING_N_PER_RAD = 1437e3  # K_s of Eq. 5.5
LENGTH_M = 0.5


def line(recorded: float, simulated: float, error: float, **more: object) -> ComparedLine:
    values = {"key": "car_rear.cornering_stiffness", "name": "C", "unit": "kN/rad",
              "factor": 1e-3, "kind": "parameter"} | more  # fmt: skip
    return ComparedLine(
        **values, recording=MeanValue(recorded, error), simulation=MeanValue(simulated, 0.0),
        difference=simulated - recorded, error=error, allowed=CRITERION * recorded,
    )  # type: ignore[arg-type]  # fmt: skip


@pytest.mark.parametrize(
    ("simulated", "error", "outcome"),
    [
        (102.0, 1.0, "within"),
        (104.0, 1.0, "perhaps within"),
        (106.0, 1.0, "perhaps beyond"),
        (108.0, 1.0, "beyond"),
        (math.nan, 1.0, "not compared"),
    ],
)
def test_a_line_says_whether_it_is_sure(simulated: float, error: float, outcome: str) -> None:
    assert line(100.0, simulated, error).outcome == outcome


def test_drives_that_contradict_each_other_correct_nothing() -> None:
    vehicle = load_vehicle(P01 / "vehicle.toml")
    agree = corrections(vehicle, [[line(95e3, 100e3, 300.0)], [line(95.2e3, 100e3, 300.0)]])
    assert [c.key for c in agree] == ["car.rear_cornering_stiffness"]
    assert agree[0].share == pytest.approx(-0.049, abs=0.002)
    assert not corrections(vehicle, [[line(95e3, 100e3, 300.0)], [line(105e3, 100e3, 300.0)]])


def test_a_lag_is_the_length_at_two_speeds() -> None:
    motions = [OperatingPoint(30.0, 4.2), OperatingPoint(20.0, 3.1)]
    drives = [
        [line(1.0, 1.0, 0.001, key="car_rear.argument", unit="deg", kind="state")] for _ in motions
    ]
    for lines, motion in zip(drives, motions, strict=True):
        turn = math.atan(motion.omega_rad_s / motion.speed_m_s * 0.7)
        lines[0] = ComparedLine("car_rear.argument", "", "deg", 1.0, "state",
                                MeanValue(-turn, 1e-3), MeanValue(0.0, 0.0), turn, 1e-3,
                                CRITERION)  # fmt: skip
    found = lags({}, drives, motions)
    assert [c.key for c in found] == ["car_rear.relaxation_length"]
    assert found[0].after == pytest.approx(0.7, rel=1e-6)


def test_an_exact_vehicle_passes_uncorrected() -> None:
    found = validate([P01 / "run1.blf"], P01 / "vehicle.toml", P01 / "signals.toml")
    assert found.passed
    assert not found.total
    assert len(found.rounds[-1].lines[0]) >= 15


@pytest.fixture(scope="module")
def chapter5(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Chapter 5's differences concealed: elastic steering, 0.5 m of relaxation, stiff beliefs."""
    folder = tmp_path_factory.mktemp("chapter5")
    physics = "".join(
        f'[[physics]]\nid = "tyre_relaxation"\naxle = "{axle}"\nlength_m = {LENGTH_M}\n'
        for axle in ("car_front", "car_rear", "trailer_front", "trailer_rear")
    )
    (folder / "scenario.toml").write_text(
        f'vehicle = "{(P01 / "vehicle.toml").resolve()}"\nduration_s = 16.0\nspeed_kmh = 107.9\n'
        '[[manoeuvre]]\nkind = "impulse"\nstart_s = 2.0\nangle_deg = 19.0\n'
        f'[[physics]]\nid = "steering_compliance"\nstiffness_n_per_rad = {STEERING_N_PER_RAD}\n'
        f'{physics}[sensors]\npreset = "typical"\n'
    )
    main(["simulate", str(folder / "scenario.toml"), "--out", str(folder / "run.csv"),
          "--signals", str(folder / "signals.toml")])  # fmt: skip
    text = (P01 / "vehicle.toml").read_text()
    for values, factor in zip(zip(*STIFFNESS.values(), strict=True), (1.30, 1.47), strict=True):
        for value in values:
            assert f"{value}" in text
            text = text.replace(f"{value}", f"{value * factor}")
    (folder / "vehicle.toml").write_text(text)
    return folder


def test_the_loop_of_chapter_5_converges(chapter5: Path) -> None:
    out = chapter5 / "corrected.toml"
    code = main(["validate", str(chapter5 / "run.csv"), "--vehicle", str(chapter5 / "vehicle.toml"),
                 "--signals", str(chapter5 / "signals.toml"), "--out", str(chapter5 / "out"),
                 "--write", str(out)])  # fmt: skip
    assert code == 0
    said = json.loads((chapter5 / "out" / "validation.json").read_text())
    assert said["passed"]
    first, last = said["rounds"][0], said["rounds"][-1]
    assert first["beyond"] >= 5
    assert last["worst"] < 1.0
    found = load_vehicle(out)
    front, rear = STIFFNESS["front_cornering_stiffness"], STIFFNESS["rear_cornering_stiffness"]
    # the axle has the steering in it (Eq. 5.7)
    assert found.car.front_cornering_stiffness == pytest.approx(
        1.0 / (1.0 / front[0] + 1.0 / STEERING_N_PER_RAD), rel=0.03
    )
    assert found.car.rear_cornering_stiffness == pytest.approx(rear[0], rel=0.03)
    assert found.trailer is not None
    assert found.trailer.front_cornering_stiffness == pytest.approx(front[1], rel=0.03)
    assert found.trailer.rear_cornering_stiffness == pytest.approx(rear[1], rel=0.03)
    added = [c for c in said["corrections"] if c["key"].endswith("relaxation_length")]
    assert len(added) == 4
    for change in added:
        assert change["after"] == pytest.approx(LENGTH_M, abs=3.0 * change["standard_error"] + 0.05)
    v_crit = {x["key"]: x for x in last["drives"][0]["lines"]}["v_crit"]
    assert v_crit["simulation"]["value"] == pytest.approx(v_crit["recording"]["value"], rel=0.01)
    assert "was " in out.read_text()
    page = (chapter5 / "out" / "validation.html").read_text()
    assert "The simulation agrees with the recording after" in page


def test_a_simulation_of_ones_own_is_given_its_factors(
    chapter5: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    paths = [
        str(chapter5 / "run.csv"),
        *("--vehicle", str(chapter5 / "vehicle.toml")),
        *("--signals", str(chapter5 / "signals.toml")),
        *("--out", str(chapter5 / "own")),
    ]
    code = main(["validate", *paths, "--simulation", str(P01 / "run1.blf"),
                 "--simulation-signals", str(P01 / "signals.toml")])  # fmt: skip
    said = capsys.readouterr().out
    assert code == 0  # another drive at another speed: its stiffnesses are compared all the same
    assert "To correct in your simulation" in said
    assert "front axle of the car times 0.9" in said
    assert main(["validate", *paths, "--simulation", *(str(P01 / f"run{k}.blf") for k in (1, 2)),
                 "--simulation-signals", str(P01 / "signals.toml")]) == 1  # fmt: skip
    assert "expected one simulation for each recording" in capsys.readouterr().err


def test_a_drive_without_steering_is_refused(tmp_path: Path) -> None:
    signals = (P01 / "signals.toml").read_text()
    kept = [x for x in signals.splitlines() if not x.startswith("steering_wheel_angle")]
    text = "\n".join(kept).replace('dbc = "../', f'dbc = "{P01.parent.resolve()}/')
    (tmp_path / "signals.toml").write_text(text)
    code = main(["validate", str(P01 / "run1.blf"), "--vehicle", str(P01 / "vehicle.toml"),
                 "--signals", str(tmp_path / "signals.toml"), "--out", str(tmp_path)])  # fmt: skip
    assert code == 1
