"""A sample of the foreign mistakes of `foreign.py`; `make foreign` runs 400 of them."""

from __future__ import annotations

import pytest
from foreign import BAD, FAMILIES, cases, endings


def test_there_are_four_hundred_of_all_families() -> None:
    found = cases(400, 1)
    assert len(found) == 400
    assert {family for family, _ in found} == set(FAMILIES)
    assert len({name for _, (name, _) in found}) > 350


@pytest.mark.timeout(600)
def test_none_of_a_sample_ends_in_a_traceback_a_hang_or_a_silent_wrong_answer() -> None:
    seen = list(endings(28, 20261122))
    bad = [(family, name, end) for family, name, end, _ in seen if end.kind in BAD]
    assert bad == []
    assert {family for family, *_ in seen} == set(FAMILIES)
    assert any(end.kind == "refused" for _, _, end, _ in seen)
    assert any(end.kind == "right" for _, _, end, _ in seen)
