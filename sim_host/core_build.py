"""Build script of ``swaywatch.ecu._core``: lib/, the codec and kissfft through cffi, API mode.

The declarations are those of the headers themselves, run through the preprocessor: nothing is
typed a second time. Where the third-party sources are is said by KISSFFT_DIR and
SWAYWATCH_CODEC_DIR; without them the folders that the Makefile fills are used, and in a source
distribution those that it brings.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import cffi

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
WITHIN = HERE / "csrc"  # of an unpacked source distribution
LIB = WITHIN / "lib" if WITHIN.is_dir() else ROOT / "lib"
FEED = HERE / "src" / "swaywatch" / "ecu" / "core_feed"
_SYSTEM_HEADERS = ("stdbool.h", "stddef.h", "stdint.h", "string.h", "limits.h", "stdlib.h")


def _folder(variable: str, default: Path, holds: str) -> Path:
    folder = Path(os.environ.get(variable) or default).resolve()
    if not (folder / holds).is_file():
        sys.exit(
            f"core_build: {folder / holds} is missing; run `make setup-run` at the top of the "
            f"repository, or set {variable}"
        )
    return folder


def _declarations(headers: list[str], include: list[Path]) -> str:
    """Typedefs, enums and prototypes of the headers, as cffi wants them."""
    compiler = os.environ.get("CC") or shutil.which("gcc") or shutil.which("cc") or "cc"
    with tempfile.TemporaryDirectory() as scratch:
        for name in _SYSTEM_HEADERS:  # cffi knows the standard types by itself
            (Path(scratch) / name).write_text("")
        source = "".join(f'#include "{header}"\n' for header in headers)
        command = [*compiler.split(), "-E", "-P", "-nostdinc", "-DFIXED_POINT=32", "-I", scratch]
        for folder in include:
            command += ["-I", str(folder)]
        text = subprocess.run(
            [*command, "-"], input=source, capture_output=True, text=True, check=True
        ).stdout
    text = re.sub(r"\(uint32_t\)(\d+)U\b", r"\1", text)
    text = re.sub(r"\b(\d+)U?L?L?\b(?=\s*<<)", r"\1", text)
    text = text.replace("__attribute__((always_inline))", "")
    return re.sub(r"static inline([^{;]*)\{[^}]*\}", r"\1;", text)


def make_builder() -> cffi.FFI:
    """Builder that setuptools runs."""
    own = WITHIN.is_dir()
    kissfft = _folder(
        "KISSFFT_DIR", WITHIN / "kissfft" if own else ROOT / "build/third_party/kissfft",
        "kiss_fft.h",
    )  # fmt: skip
    codec = _folder(
        "SWAYWATCH_CODEC_DIR", WITHIN / "codec" if own else ROOT / "build/codec", "swaywatch_dbc.h"
    )  # fmt: skip
    include = [LIB, codec, FEED.parent, kissfft]
    headers = [
        "sway_node.h",
        "bus/sway_map.h",
        "model/sway_margin.h",
        "model/sway_single_track.h",
        f"{FEED.name}.h",
    ]
    includes = "".join(f'#include "{header}"\n' for header in headers)
    builder = cffi.FFI()
    builder.cdef(_declarations(headers, include))
    sources = [*sorted(LIB.glob("*/*.c")), codec / "swaywatch_dbc.c", FEED.with_suffix(".c")]
    sources.append(kissfft / "kiss_fft.c")
    builder.set_source(
        "swaywatch.ecu._core",
        includes,
        sources=[os.path.relpath(source, HERE) for source in sources],
        include_dirs=[str(folder) for folder in include],
        define_macros=[("FIXED_POINT", "32")],
        extra_compile_args=["-O2", "-std=gnu99", "-w"],
    )
    return builder


FFI_BUILDER = make_builder()

if __name__ == "__main__":
    FFI_BUILDER.compile(verbose=True)
