"""A fixed few of the mutated files of ``make fuzz-recordings``, and those that it once found."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

PLACE = Path(__file__).resolve().parent.parent / "fuzz" / "fuzz_recordings.py"


@pytest.fixture(scope="module")
def fuzzer() -> ModuleType:
    spec = importlib.util.spec_from_file_location("fuzz_recordings", PLACE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_mutated_files_end_in_a_result_or_a_sentence(fuzzer: ModuleType) -> None:
    ended, findings = fuzzer.fuzz(60.0, 1300, 20261122, None)
    assert findings == []
    names = {name.split(":")[0] for name in ended}
    assert len(names) == 13
    refused = sum(count for name, count in ended.items() if name.endswith("refused"))
    assert refused > 0.2 * sum(ended.values())  # the mutations bite
