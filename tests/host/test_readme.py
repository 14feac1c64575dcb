"""The example of the package's README runs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from conftest import DATA

README = Path(__file__).resolve().parents[2] / "sim_host" / "README.md"


def test_example_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(DATA / "practice" / "p01")
    (code,) = re.findall(r"```python\n(.*?)```", README.read_text(), re.DOTALL)
    names: dict[str, object] = {}
    exec(compile(code, str(README), "exec"), names)
    result = names["result"]
    assert result.values["v_crit_m_s"].value * 3.6 == pytest.approx(123.3, abs=2.0)  # type: ignore[attr-defined]


def test_every_command_of_the_table_exists() -> None:
    from swaywatch.cli import build_parser

    text = README.read_text()
    named = set(re.findall(r"^\| `swaywatch (\w+)", text, re.MULTILINE))
    parser = build_parser()
    (subparsers,) = (a for a in parser._actions if hasattr(a, "choices") and a.dest == "command")
    assert named <= set(subparsers.choices or ())
