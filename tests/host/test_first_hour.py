"""What a new user stopped trusting: small points that no other test holds (`make first-hour`)."""

from __future__ import annotations

import io
import time
from typing import Any

import pytest
from rich.console import Console

from swaywatch.diagnose.evidence.evidence import UNEXPLAINED_ABOVE
from swaywatch.diagnose.report import labels, page
from swaywatch.terminal.progress import LateProgress


@pytest.mark.parametrize("left", [UNEXPLAINED_ABOVE - 0.05, UNEXPLAINED_ABOVE + 0.05])
def test_a_mismatch_above_clean_recordings_is_not_called_noise(left: float) -> None:
    said = page.rest_of_it([], {"reduced_chi_square_diagnosed": left})
    assert ("Nothing above the noise." in said) == (left < UNEXPLAINED_ABOVE)
    assert any(f"{left:.2f} is above" in text for text in said) == (left > UNEXPLAINED_ABOVE)


@pytest.mark.parametrize("at_bound", [False, True])
def test_a_number_at_the_end_of_the_range_is_said_to_be(at_bound: bool) -> None:
    found: dict[str, Any] = {"value": 1.2, "low": 1.1, "high": 1.3, "at_bound": at_bound}
    [text] = labels.how_much({"parameters": {"factor": found}})
    assert ("at the end of the range searched" in text) == at_bound


def test_progress_shows_the_time_left() -> None:
    screen = io.StringIO()
    console = Console(file=screen, force_terminal=True, width=100)
    with LateProgress(console) as progress:
        progress.tell("reading", 1.0, 10.0)
        time.sleep(1.3)  # it shows itself after a second
        progress.tell("reading", 5.0, 10.0)
        time.sleep(0.3)
    drawn = screen.getvalue()
    assert "reading" in drawn
    assert "left" in drawn
    assert "0:00:0" in drawn
