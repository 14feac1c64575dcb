"""Builds the package with its bindings to the C core and to the plant.

A source distribution is whole by itself: the core, its codec, kissfft, the bus description and the
licences of all of them are laid into it (``csrc``), since `sim_host` alone does not have them.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

HERE = Path(__file__).resolve().parent
WITHIN = HERE / "csrc"  # of an unpacked source distribution
ROOT = HERE.parent
KISSFFT_FILES = (
    "kiss_fft.c",
    "kiss_fft.h",
    "_kiss_fft_guts.h",
    "kiss_fft_log.h",
    "COPYING",
    "LICENSES/BSD-3-Clause",
)


def _dbc() -> Path:
    own = WITHIN / "dbc" / "swaywatch.dbc"
    return own if own.is_file() else ROOT / "dbc" / "swaywatch.dbc"


def _copy(files: list[Path], root: Path, target: Path) -> None:
    for file in files:
        there = target / file.relative_to(root)
        there.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, there)


class WithDbc(build_py):
    """Lays the bus description beside the modules."""

    def run(self) -> None:
        """Modules first, then the description."""
        super().run()
        if not self.editable_mode:
            folder = Path(self.build_lib) / "swaywatch"
            folder.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(_dbc(), folder / "swaywatch.dbc")


class Whole(sdist):
    """Lays the C sources and licences into the distribution."""

    def make_release_tree(self, base_dir: str, files: list[str]) -> None:
        """The package's own files, then what lies outside `sim_host`."""
        # Sources of the extension that lie outside would land outside: they go into `csrc`.
        super().make_release_tree(base_dir, [f for f in files if not f.startswith("..")])
        base = Path(base_dir)
        if WITHIN.is_dir():
            return  # made from a source distribution: it is there already
        lib = ROOT / "lib"
        kissfft = Path(os.environ.get("KISSFFT_DIR") or ROOT / "build/third_party/kissfft")
        codec = Path(os.environ.get("SWAYWATCH_CODEC_DIR") or ROOT / "build/codec")
        _copy([*lib.rglob("*.c"), *lib.rglob("*.h")], lib, base / "csrc" / "lib")
        _copy([kissfft / name for name in KISSFFT_FILES], kissfft, base / "csrc" / "kissfft")
        _copy([*codec.glob("swaywatch_dbc.[ch]")], codec, base / "csrc" / "codec")
        _copy([_dbc()], _dbc().parent, base / "csrc" / "dbc")
        (base / "LICENSE").unlink(missing_ok=True)
        shutil.copyfile(ROOT / "LICENSE", base / "LICENSE")


setup(
    cffi_modules=["core_build.py:FFI_BUILDER", "plant_build.py:FFI_BUILDER"],
    cmdclass={"build_py": WithDbc, "sdist": Whole},
    options={"bdist_wheel": {"py_limited_api": "cp311"}},
)
