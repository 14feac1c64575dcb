"""Build script of ``swaywatch.plant._plant``: the plant through cffi, API mode."""

from __future__ import annotations

from pathlib import Path

import cffi

HERE = Path(__file__).resolve().parent
SOURCES = Path("src") / "swaywatch" / "plant"


def make_builder() -> cffi.FFI:
    """Builder that setuptools runs."""
    header = (HERE / SOURCES / "plant_lanes.h").read_text()
    start, stop = header.index("#define PLANT_BODY"), header.rindex("#endif")
    builder = cffi.FFI()
    builder.cdef(header[start:stop])
    builder.set_source(
        "swaywatch.plant._plant",
        '#include "plant_lanes.h"\n',
        sources=[str(SOURCES / "plant_lanes.c")],
        include_dirs=[str(HERE / SOURCES)],
        extra_compile_args=[
            "-O3", "-std=gnu99", "-w", "-fno-math-errno", "-fno-trapping-math",
            "-ffp-contract=off",  # the same to the bit alone, beside others, on any machine
        ],
    )  # fmt: skip
    return builder


FFI_BUILDER = make_builder()

if __name__ == "__main__":
    FFI_BUILDER.compile(verbose=True)
