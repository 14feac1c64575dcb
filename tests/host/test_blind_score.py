"""The scorer of the concealed cases: what counts as right, and what does not."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "proof"))
sys.path.insert(0, str(Path(__file__).parents[1] / "proof" / "blind"))

import limits
import score


def answer(**changes):
    base = {
        "case": "b001",
        "kind": "planar",
        "effects": [{"id": "tyre_relaxation", "axle": "car_rear", "length_m": 0.5}],
        "components": ["car_rear"],
        "strengths": [0.8],
        "values": [0.5],
        "outside": [False],
        "fault": [False],
        "windows": [{}],
        "hidden_channels": [],
        "run1": {"visibility": 40.0},
    }
    return base | changes


def claim(effect_id="tyre_relaxation", **changes):
    base = {
        "id": effect_id,
        "component": "car_rear",
        "parameters": {"length_m": {"value": 0.55, "low": 0.45, "high": 0.65}},
        "windows": [],
        "confidence": 0.95,
        "equivalent": [],
    }
    return base | changes


def diagnosis(*effects, verdict="missing_physics", **more):
    return {"verdict": verdict, "effects": list(effects), **more}


CLEAN = {"kind": "clean", "effects": [], "components": [], "strengths": [], "values": [],
         "outside": [], "fault": [], "windows": []}  # fmt: skip


def test_right_effect():
    got = score.judge(answer(), diagnosis(claim()))
    assert got["first"]
    assert got["set"]
    assert got["matches"][0]["location"]
    (length,) = got["matches"][0]["parameters"]
    assert length["error"] == pytest.approx(0.1)
    assert length["inside"]


def test_wrong_axle_wrong_id_and_silence():
    wrong = score.judge(answer(), diagnosis(claim(component="car_front")))
    assert wrong["first"]
    assert wrong["matches"][0]["location"] is False
    other = score.judge(answer(), diagnosis(claim("hitch_friction")))
    assert not other["first"]
    equivalent = diagnosis(claim("hitch_friction", equivalent=["tyre_relaxation"]))
    assert score.judge(answer(), equivalent)["set"]
    silent = score.judge(answer(), diagnosis(verdict="consistent"))
    assert not silent["first"]
    assert silent["silent"]


def test_clean_case_and_false_claim():
    assert score.judge(answer(**CLEAN), diagnosis(verdict="consistent"))["first"]
    false = score.judge(answer(**CLEAN), diagnosis(claim()))
    assert not false["first"]
    assert false["claims"]


def test_no_diagnosis_is_not_right():
    assert not score.judge(answer(), {})["first"]
    assert not score.judge(answer(**CLEAN), {})["first"]


def test_outside_the_library():
    outside = answer(kind="outside", outside=[True], effects=[{"id": "cargo_slosh"}])
    assert score.judge(outside, diagnosis(verdict="unexplained"))["first"]
    assert not score.judge(outside, diagnosis(claim()))["first"]
    assert not score.judge(outside, diagnosis(verdict="consistent"))["first"]


def test_two_effects():
    pair = answer(
        kind="pair",
        effects=[{"id": "tyre_relaxation", "axle": "car_rear"}, {"id": "hitch_friction"}],
        components=["car_rear", "hitch"],
        windows=[{}, {}],
        outside=[False, False],
        fault=[False, False],
    )
    both = score.judge(pair, diagnosis(claim("hitch_friction", component="hitch"), claim()))
    assert both["first"]
    assert both["all"]
    one = score.judge(pair, diagnosis(claim()))
    assert one["first"]
    assert not one["all"]


def test_windows():
    assert score.overlap([[10.0, 12.0]], [[10.0, 14.0]]) == pytest.approx(0.5, abs=0.03)
    assert score.per_run([[1.0, 2.0]]) == {"run1": [[1.0, 2.0]]}
    assert score.per_run([{"run": "run2", "start": 1, "stop": 2}]) == {"run2": [[1.0, 2.0]]}


def detections(label, limit, count=40, *, smaller=False):
    """Cases whose chance of being right passes 90 % at a strength."""
    rng = np.random.default_rng(7)
    rows = []
    for u in np.linspace(0.01, 0.99, count):
        chance = 1.0 / (1.0 + np.exp(-(np.log(9.0) + 10.0 * (u - limit))))
        value = 1e7 * 0.01**u if smaller else 0.01 * 100.0**u
        right = bool(rng.random() < chance)
        rows.append(
            {"kind": "planar", "ids": [label], "strength": u, "value": value, "first": right}
        )
    return rows


def test_limit_of_detection():
    rows = detections("tyre_relaxation", 0.5) + detections("steering_compliance", 0.7, smaller=True)
    rows += [r | {"first": False} for r in detections("hitch_friction", 0.5)]
    found = limits.limits(rows)
    assert found["tyre_relaxation"]["strength"] == pytest.approx(0.5, abs=0.12)
    assert found["tyre_relaxation"]["value"] == pytest.approx(0.1, rel=0.7)
    assert found["steering_compliance"]["strength"] == pytest.approx(0.7, abs=0.12)
    assert found["steering_compliance"]["value"] == pytest.approx(1e7 * 0.01**0.7, rel=0.7)
    assert found["hitch_friction"]["value"] is None
    assert found["hitch_friction"]["cases"] == 40


def test_few_cases_lean_on_the_others():
    rows = detections("tyre_relaxation", 0.5) + detections("hitch_damping", 0.5)
    weak_and_right = {"kind": "planar", "ids": ["roll_steer"], "strength": 0.05, "value": 0.01,
                      "first": True}  # fmt: skip
    assert 0.05 < limits.limits([*rows, weak_and_right])["roll_steer"]["strength"] < 0.6


def test_the_proof_is_no_source_of_limits(tmp_path, monkeypatch):
    monkeypatch.setattr(
        sys, "argv", ["limits.py", "s.json", "--seeds", "20261121", "--out", str(tmp_path / "l")]
    )
    with pytest.raises(SystemExit, match="seed of the proof"):
        limits.main()


def test_tables_and_file(tmp_path, capsys):
    cases = {
        "b001": (answer(), diagnosis(claim())),
        "b002": (answer(case="b002", **CLEAN), diagnosis(verdict="consistent")),
    }
    for name, (true, said) in cases.items():
        for folder, content, file in (("a", true, "answer.json"), ("d", said, "diagnosis.json")):
            (tmp_path / folder / name).mkdir(parents=True)
            (tmp_path / folder / name / file).write_text(json.dumps(content))
    rows = score.score(tmp_path / "a", tmp_path / "d", predict=False)
    total = score.summarise(rows, {})
    score.print_tables(total, rows)
    assert total["first"]["share"] == 1.0
    assert total["false_claims_on_clean"]["right"] == 0
    assert "tyre_relaxation" in capsys.readouterr().out


def test_a_case_without_a_verdict_says_why(tmp_path, capsys):
    for folder, content, file in (
        ("a", answer(), "answer.json"),
        ("d", {"seconds": 3.0, "said": "unexpected\n internal error"}, "run.json"),
    ):
        (tmp_path / folder / "b001").mkdir(parents=True)
        (tmp_path / folder / "b001" / file).write_text(json.dumps(content))
    rows = score.score(tmp_path / "a", tmp_path / "d", predict=False)
    total = score.summarise(rows, {})
    score.print_tables(total, rows)
    assert total["failed"] == 1
    assert total["simulated_s_max"] is None
    assert "failed: b001: unexpected internal error" in capsys.readouterr().out


def test_phase_of_a_harmonic_load():
    windows = {"run1": [[9.0, 12.0], [15.0, 18.0]]}
    true = answer(
        effects=[{"id": "axle_load_harmonic", "axle": "car_rear"}],
        windows=[windows],
        run1={
            "visibility": 9.0,
            "harmonic": [
                {"amplitude_n": 500.0, "phase_deg": 170.0},
                {"amplitude_n": 400.0, "phase_deg": 20.0},
            ],
        },
        run2={"harmonic": []},
    )
    details = [{"run": "run1", "start": 9.2, "stop": 12.0, "phase_deg": -175.0}]
    said = claim("axle_load_harmonic", window_details=details, windows=[[9.2, 12.0]])
    said["parameters"] = {"amplitude_n": {"value": 520.0, "low": 400.0, "high": 600.0}}
    got = score.judge(true, diagnosis(said))
    assert got["phase_errors_deg"] == pytest.approx([15.0])
    (amplitude,) = got["matches"][0]["parameters"]
    assert amplitude["error"] == pytest.approx(0.04)
