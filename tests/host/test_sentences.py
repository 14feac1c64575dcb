"""A diagnosis in plain sentences."""

from __future__ import annotations

from typing import Any

import pytest

from swaywatch.commands.physics import known
from swaywatch.diagnose.report.sentences import _SENTENCES, sentence
from swaywatch.effects.effect import library


def _effect(name: str, component: str, **values: float) -> dict[str, Any]:
    return {
        "id": name, "component": component, "window_details": [],
        "parameters": {k: {"value": v, "low": v, "high": v} for k, v in values.items()},
    }  # fmt: skip


def _stability(
    name: str, with_it: float | None, without: float | None, windows: tuple[float, ...] = ()
) -> dict[str, Any]:
    """As in diagnosis.json, the three swings alike."""

    def row(value: float | None) -> dict[str, float] | None:
        return None if value is None else {"value": value, "low": value - 1.0, "high": value + 1.0}

    back = None if with_it is None or without is None else without - with_it
    cause = {
        "name": name, "v_crit_without_km_h": 3 * [row(without)], "gives_back_km_h": 3 * [row(back)],
        "windows": [{"gives_back_km_h": row(value)} for value in windows],
    }  # fmt: skip
    return {"causes": [cause], "diagnosed": {"v_crit_km_h": 3 * [row(with_it)]}}


def test_an_axle_load_that_swings() -> None:
    effect = _effect("axle_load_harmonic", "car_rear", amplitude_n=760.0)
    effect["window_details"] = [
        {"run": "run 1", "start": start, "stop": start + 3.0, "amplitude_n": 760.0}
        for start in (9.5, 15.0)
    ]
    stability = _stability("axle_load_harmonic:car_rear", 118.8, 123.4, (4.6, -5.5))
    assert sentence(effect, stability) == (
        "The load of the car's rear axle swings by up to 760 N at twice the yaw frequency; a "
        "damper is the usual cause (run 1: 9.5 to 12.5 s, 15.0 to 18.0 s); in its worst window it "
        "lowers the critical speed by 4.6 (3.6 to 5.6) km/h, from 123.4 to 118.8 km/h; in its most "
        "favourable window it raises it by 5.5 km/h."
    )
    assert sentence(effect, {"causes": []}).endswith("15.0 to 18.0 s).")


@pytest.mark.parametrize(
    ("with_it", "without", "words"),
    [
        (
            120.0,
            124.5,
            "it lowers the critical speed by 4.5 (3.5 to 5.5) km/h, from 124.5 to 120.0",
        ),
        (
            130.0,
            124.5,
            "it raises the critical speed by 5.5 (4.5 to 6.5) km/h, from 124.5 to 130.0",
        ),
        (124.0, 124.5, "it lowers the critical speed by 0.5 (0.0 to 1.5) km/h"),
        (124.5, 124.5, "it does not change the critical speed"),
        (124.5, None, "with it the critical speed is 124.5 km/h, without it none is found"),
        (None, 124.5, "with it no critical speed is found"),
    ],
)
def test_what_it_does_to_the_critical_speed(
    with_it: float | None, without: float | None, words: str
) -> None:
    effect = _effect("hitch_friction", "hitch", moment_nm=150.0)
    text = sentence(effect, _stability("hitch_friction:hitch", with_it, without))
    assert text.startswith("Dry friction at the hitch: 150 N m; ")
    assert words in text


def test_a_cost_that_depends_on_the_swing_names_its_size() -> None:
    stability = _stability("hitch_friction:hitch", 138.5, 123.2)
    stability["swings_deg_s"] = [1.0, 4.0, 10.0]
    stability["causes"][0]["gives_back_km_h"][2] = {"value": -5.9, "low": -6.2, "high": -5.6}
    text = sentence(_effect("hitch_friction", "hitch", moment_nm=130.0), stability)
    assert "to 138.5 km/h for a swing of 4 deg/s, and by 5.9 km/h for one of 10 deg/s." in text


@pytest.mark.parametrize(
    ("name", "values", "words"),
    [
        ("hitch_friction", {"moment_nm": (129.7, 127.2, 132.1)}, "130 (127 to 132) N m."),
        ("sensor_delay", {"delay_s": (0.06043, 0.059, 0.0621)}, "60.4 (59 to 62.1) ms; the"),
        ("damper_fade", {"factor": (0.242, 0.2, 0.29)}, "is 76 % lower (-80 to -71 %)."),
    ],
)
def test_a_size_comes_with_its_interval(
    name: str, values: dict[str, tuple[float, float, float]], words: str
) -> None:
    effect = _effect(name, "car_rear")
    effect["parameters"] = {
        key: {"value": value, "low": low, "high": high}
        for key, (value, low, high) in values.items()
    }
    assert words in sentence(effect)


def test_every_effect_has_a_sentence_and_none_breaks_without_numbers() -> None:
    assert {effect.id for effect in library()} == set(_SENTENCES)
    assert set(_SENTENCES) <= set(known())
    for name in known():
        text = sentence(_effect(name, "car_rear"))
        assert text.endswith(".")
        assert "{" not in text
        assert "None" not in text
