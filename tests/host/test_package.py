"""The source distribution is whole by itself. `make package` builds and tries the wheel."""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source distribution, unpacked."""
    out = tmp_path_factory.mktemp("dist")
    build = f"import setuptools.build_meta as b; print(b.build_sdist({str(out)!r}))"
    done = subprocess.run(
        [sys.executable, "-c", build], cwd=ROOT / "sim_host", capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    [archive] = out.glob("swaywatch-*.tar.gz")
    with tarfile.open(archive) as tar:
        assert all(not name.startswith(("/", "..")) for name in tar.getnames())
        tar.extractall(out)  # Debian 12 has Python 3.11.2, without filters
    [folder] = (path for path in out.iterdir() if path.is_dir())
    return folder


def test_it_holds_core_codec_kissfft_bus_and_licences(unpacked: Path) -> None:
    for name in (
        "LICENSE", "csrc/kissfft/COPYING", "csrc/kissfft/LICENSES/BSD-3-Clause",
        "csrc/kissfft/kiss_fft.c", "csrc/codec/swaywatch_dbc.c", "csrc/dbc/swaywatch.dbc",
        "csrc/lib/sway_node.h", "src/swaywatch/ecu/core_feed.c",
        "src/swaywatch/plant/plant_lanes.c",
        "src/swaywatch/report/page.js", "src/swaywatch/report/page.css",
        "src/swaywatch/report/shell.html", "src/swaywatch/diagnose/report/page.html",
        "src/swaywatch/diagnose/evidence/calibration.json", "src/swaywatch/py.typed",
    ):  # fmt: skip
        assert (unpacked / name).is_file(), name
    ours = {path.relative_to(ROOT / "lib") for path in (ROOT / "lib").rglob("*.[ch]")}
    theirs = unpacked / "csrc" / "lib"
    assert {path.relative_to(theirs) for path in theirs.rglob("*.[ch]")} == ours
    assert not (ROOT / "sim_host" / "csrc").exists()
    assert not (ROOT / "sim_host" / "lib").exists()


def test_its_core_is_built_from_itself_alone(unpacked: Path) -> None:
    """Declarations and sources are found without the repository; nothing is compiled here."""
    look = (
        "import core_build; b = core_build.FFI_BUILDER; "
        "print(*b._assigned_source[3]['sources'], sep='\\n')"
    )
    environment = {k: v for k, v in os.environ.items() if "KISSFFT" not in k and "CODEC" not in k}
    done = subprocess.run(
        [sys.executable, "-c", look], cwd=unpacked, env=environment, capture_output=True,
        text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    sources = done.stdout.split()
    assert len(sources) > 20
    assert all((unpacked / source).is_file() for source in sources)
    assert not any(source.startswith("..") for source in sources)
