"""The scorer of the concealed cases: what counts as right, and what does not."""

import json
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "proof" / "blind"))

import beside_score
import score
import table


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


def scored(name, left, *, first, ids=("tyre_relaxation",), **more):
    return {
        "case": name, "kind": "pair" if len(ids) > 1 else "planar", "tier": "B", "ids": list(ids),
        "left": left, "best_wrong": ["hitch_damping"] * len(left), "first": first, "set": first,
        "silent": not first, "claims": first, "first_id": None, "verdict": "consistent",
        "confidence": 0.9, **more,
    }  # fmt: skip


def test_above_the_limit_is_what_leaves_enough_beside_the_best_wrong_effect():
    both = ("tyre_relaxation", "hitch_friction")
    rows = [
        scored("b001", [12.0], first=True),
        scored("b002", [40.0], first=False),
        scored("b003", [9.9], first=False),
        scored("b004", [], first=True),
        scored("b005", [80.0, 3.0], first=True, ids=both, all=False),
        scored("b006", [80.0, 13.0], first=True, ids=both, all=False),
    ]
    total = score.summarise(rows)
    assert total["first"] == {"right": 2, "of": 4, "share": 0.5}
    assert total["first_above_limit"] == {"right": 1, "of": 2, "share": 0.5}
    assert total["without_limit"] == 1
    assert total["pair_both_above_limit"]["of"] == 1
    assert total["effects"]["tyre_relaxation"]["above_limit"]["of"] == 2
    assert [r["case"] for r in total["missed_above_limit"]] == ["b002", "b006"]
    assert [(r["from"], r["right"], r["of"]) for r in total["by_limit"]] == [
        (5.0, 0, 1), (10.0, 1, 1), (30.0, 0, 1),
    ]  # fmt: skip


def test_the_page_names_what_was_missed_above_the_limit():
    total = score.summarise([scored("b002", [40.0], first=False)])
    text = table.page({"summary": total}, "7")
    assert "| b002 | B | tyre_relaxation | 40 | hitch_damping | consistent |" in text
    assert "30 to 100 standard deviations" in text


@pytest.mark.parametrize(("name", "weak"), [(10.0, False), (9.0, True)])
def test_a_pair_beside_a_simulation_counts_where_it_can_be_named(name, weak):
    pair = answer(effects=[{"id": "hitch_friction"}], values=[30.0])
    limit = [{"id": "hitch_friction", "detect": 50.0, "name": name, "best_wrong": ""}]
    row = beside_score.row(pair, diagnosis(claim("hitch_friction")), limit)
    assert row["effects"][0]["word"] == "named"
    assert row["effects"][0]["above"] is not weak
    assert not beside_score.row(pair, None, [])["effects"][0]["above"]


def test_tables_and_file(tmp_path, capsys):
    limit = {"limits": [{"id": "tyre_relaxation", "detect": 80.0, "name": 31.0, "best_wrong": "x"}]}
    (tmp_path / "a" / "b001").mkdir(parents=True)
    (tmp_path / "a" / "b001" / "limit.json").write_text(json.dumps(limit))
    cases = {
        "b001": (answer(), diagnosis(claim())),
        "b002": (answer(case="b002", **CLEAN), diagnosis(verdict="consistent")),
    }
    for name, (true, said) in cases.items():
        for folder, content, file in (("a", true, "answer.json"), ("d", said, "diagnosis.json")):
            (tmp_path / folder / name).mkdir(parents=True, exist_ok=True)
            (tmp_path / folder / name / file).write_text(json.dumps(content))
    rows = score.score(tmp_path / "a", tmp_path / "d", predict=False)
    total = score.summarise(rows)
    score.print_tables(total, rows)
    assert total["first"]["share"] == 1.0
    assert total["first_above_limit"] == {"right": 1, "of": 1, "share": 1.0}
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
    total = score.summarise(rows)
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
