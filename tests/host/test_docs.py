"""The documentation site: it builds, its links lead somewhere, its commands exist, all is in it."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

from swaywatch.cli import command_names

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def docs() -> ModuleType:
    spec = importlib.util.spec_from_file_location("docs_build", ROOT / "sim_host/docs/build.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["docs_build"] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def site(docs: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("docs")
    assert docs.build(out) == []
    return out / "site"


def test_everything_is_in_the_reference(docs: ModuleType, site: Path) -> None:
    commands = (site / "commands.html").read_text()
    for name in command_names():
        assert f'id="{name}"' in commands
    assert "--scheduler" in commands
    core = (site / "c-core.html").read_text() + (site / "c-ports.html").read_text()
    for path in [*(ROOT / "lib").glob("*.h"), *(ROOT / "port").glob("*.h")]:
        assert path.name in core
    for declared in ("sway_node_receive", "sway_core_input", "sway_port_t", "SWAY_ASSUMED_ALL"):
        assert declared in core
    assert "SwayFinding" in (site / "frames.html").read_text()
    assert "car.mass" in (site / "parameters.html").read_text()
    effects = (site / "effects.html").read_text()
    assert 'id="hitch_friction"' in effects
    assert "swaywatch.analysis" in (site / "python.html").read_text()


def test_every_effect_has_equation_and_source(docs: ModuleType) -> None:
    for part in docs.effects().split("\n## ")[1:]:
        assert "| equation |  |" not in part, part
        assert "| source |  |" not in part, part


def test_what_is_wrong_is_found(docs: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "other.html").write_text("<h1 id='there'>x</h1>")
    (tmp_path / "page.html").write_text(
        "<script src='https://cdn.example/x.js'></script><a href='other.html#there'>good</a>"
        "<a href='other.html#gone'>x</a><a href='nowhere.html'>x</a><a href='https://doi.org'>y</a>"
    )
    wrong = docs.broken_links(tmp_path)
    assert len(wrong) == 3
    assert "cdn.example" in "".join(wrong)
    assert docs.wrong_commands("```sh\nswaywatch survey x --jobs 2\n```") == []
    assert len(docs.wrong_commands("```sh\nswaywatch survey x --no-such\n```")) == 1
    assert len(docs.wrong_commands("```sh\nswaywatch surrvey x\n```")) == 1


def test_a_header_is_read_as_it_is_written(docs: ModuleType) -> None:
    lines = [
        "#ifndef SWAY_X_H", "#define SWAY_X_H", "", "/// A limit.", "#define SWAY_LIMIT 3",
        "/// What it holds.", "typedef struct {", "    int a; ///< one; two", "} sway_x_t;", "",
        "// not for users", "/// What it does,", "/// and when.", "int sway_x(", "    int a);",
    ]  # fmt: skip
    assert list(docs._declarations(lines)) == [
        (["A limit."], ["#define SWAY_LIMIT 3"]),
        (["What it holds."], ["typedef struct {", "    int a; ///< one; two", "} sway_x_t;"]),
        (["What it does,", "and when."], ["int sway_x(", "    int a);"]),
    ]
