"""Each condition of the judgement alone changes a decision in some unit test (MC/DC)."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "coverage"))

import mcdc

ROOT = Path(__file__).resolve().parents[2]
SOURCE = """
/* a && b in a comment */
static bool f(int a, int b, int c)
{
    const bool first = a == 1 && (b < 2 || !(c != 0));
    if (g(a && b) || c) {
        return !a || (b && c) ? a : b;
    }
    return first;
}
"""


def test_decisions_and_their_conditions_are_found() -> None:
    found = [
        [SOURCE[start:stop] for start, stop in decision.conditions]
        for decision in mcdc.decisions(SOURCE)
    ]
    assert found == [
        ["a == 1", "b < 2", "!(c != 0)"], ["g(a && b)", "c"], ["a", "b"], ["!a", "b", "c"],
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("seen", "which"),
    [
        ({(1, 1, 1), (0, 2, 0), (1, 0, 0)}, [True, True]),  # a && b
        ({(1, 1, 1), (0, 2, 0)}, [True, False]),
        ({(1, 1, 1), (1, 0, 0)}, [False, True]),
        ({(1, 2, 1), (0, 1, 1), (0, 0, 0)}, [True, True]),  # a || b
        ({(1, 2, 1), (0, 1, 1)}, [False, False]),
        (set(), [False, False]),
    ],
)
def test_a_condition_is_shown_by_a_pair_that_differs_in_it_alone(
    seen: set[tuple[int, ...]], which: list[bool]
) -> None:
    assert [mcdc.shown(k, seen) for k in range(2)] == which


def test_every_condition_of_the_judgement_is_shown() -> None:
    if not (ROOT / "build/gcc/libsway.a").exists():
        pytest.skip("needs build/gcc/libsway.a: make test")
    text, missing = mcdc.table(list(mcdc.JUDGEMENT))
    assert missing == []
    assert text == (ROOT / "tests/coverage/mcdc.md").read_text(), "python tests/coverage/mcdc.py"
