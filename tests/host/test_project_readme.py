"""The README's examples run as they stand there."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from conftest import EXAMPLES, ROOT, run_example

README = (ROOT / "README.md").read_text(encoding="utf-8")
QUOTED = {
    "swaywatch analyze": r'\*"(At .*? km/h)"\*',  # `make run` analyses the same recordings
    "--remember": r"`(trailer: another, likeness [-0-9.]+)`",
}
"""Commands of which the README quotes what they print."""


def include_flags() -> list[str]:
    kissfft = os.environ.get("KISSFFT_DIR", str(ROOT / "build/third_party/kissfft"))
    return ["-Ilib", "-Ibuild/codec", f"-I{kissfft}", "-DFIXED_POINT=32"]


def test_there_are_examples_of_all_three_uses() -> None:
    text = "".join(body for _, body in EXAMPLES)
    assert "analyze" in text
    assert "swaywatchd" in text
    assert "sway_node_receive" in text


@pytest.mark.parametrize("body", [b for kind, b in EXAMPLES if kind == "sh"])
def test_shell_example(body: str, request: pytest.FixtureRequest) -> None:
    if "build/swaywatchd" in body and not (ROOT / "build/swaywatchd").exists():
        pytest.skip("build/swaywatchd is not built: make hil")
    if "swaywatch diagnose" in body:
        assert (request.getfixturevalue("diagnosed_p03") / "report.html").exists()
        return
    printed = " ".join(run_example(body).split())
    for command, quoted in QUOTED.items():
        if command in body:
            (words,) = re.findall(quoted, README)
            assert words in printed


@pytest.mark.parametrize("body", [b for kind, b in EXAMPLES if kind == "c"])
def test_c_example(body: str, tmp_path: Path) -> None:
    library = ROOT / "build/gcc/libsway.a"
    compiler = shutil.which("gcc")
    if compiler is None or not library.exists():
        pytest.skip("needs gcc and build/gcc/libsway.a: make test")
    source = tmp_path / "example.c"
    source.write_text(body, encoding="utf-8")
    program = tmp_path / "example"
    subprocess.run(
        [compiler, "-std=c99", "-Wall", "-Wextra", "-Werror", *include_flags(), str(source),
         str(library), "-lm", "-o", str(program)],
        cwd=ROOT, check=True,
    )  # fmt: skip
    assert subprocess.run([str(program)], check=False).returncode == 0
