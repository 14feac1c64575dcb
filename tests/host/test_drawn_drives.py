"""Of healthy drives nothing is claimed; a fault put into one that shows it is named."""

from __future__ import annotations

import math

import pytest
from drawn_drives import MANOEUVRES, drawn, scaled

from swaywatch.checks.quality import check_drive
from swaywatch.checks.samples import Finding


def claims(findings: list[Finding]) -> list[str]:
    return [finding.text for finding in findings if finding.severity != "info"]


@pytest.mark.parametrize("manoeuvre", MANOEUVRES)
def test_nothing_is_claimed_of_a_healthy_drive(manoeuvre: str) -> None:
    for seed in range(1000, 1005):
        one = drawn(seed, manoeuvre=manoeuvre)
        assert claims(check_drive(one.drive, one.vehicle)) == [], f"seed {seed}"


WRONG = [
    ("steering_wheel_angle", -1.0, "sign"),
    ("steering_wheel_angle", math.pi / 180.0, "in rad, not in deg"),
    ("car_yaw_rate", -1.0, "sign"),
    ("car_yaw_rate", 180.0 / math.pi, "in deg/s, not in rad/s"),
    ("trailer_yaw_rate", -1.0, "sign"),
    ("car_lateral_acceleration", 1.0 / 9.80665, "in g"),
    ("speed", 3.6, "km/h"),
]


@pytest.mark.parametrize(("name", "factor", "words"), WRONG)
def test_a_wrong_sign_or_unit_is_named_in_most_slaloms(
    name: str, factor: float, words: str
) -> None:
    found = 0
    for seed in range(2000, 2006):
        one = drawn(seed, manoeuvre="tones", sensors="all")
        texts = claims(check_drive(scaled(one.drive, name, factor), one.vehicle))
        assert all(name in text for text in texts if "does not hold" not in text), texts
        found += any(name in text and words in text for text in texts)
    assert found >= 3
