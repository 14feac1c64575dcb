"""How a page looks, small enough to keep: pictures 64 pixels wide, compared with kept ones.

A kept picture holds layout, colours and where plots are, not letters: fonts differ from machine to
machine and figures from version to version. ``KEEP_LOOKS=1 pytest tests/host/test_looks.py`` keeps
those of now, to be looked at before they are committed.
"""

from __future__ import annotations

import io

import numpy as np
import numpy.typing as npt
from PIL import Image

FloatArray = npt.NDArray[np.float64]

WIDTH = 64
HEIGHT_OFF = 0.08
"""Part of its height by which a page may be longer or shorter: lines break elsewhere."""
MEAN_OFF = 9.0
"""Mean difference of 255 once both are blurred and the lines brought into step."""
STRIPE = 24
"""Rows that are compared together; each may stand a little higher or lower."""


def look_of(png: bytes) -> Image.Image:
    """The small picture of a large one."""
    with Image.open(io.BytesIO(png)) as picture:
        height = max(8, round(picture.height * WIDTH / picture.width))
        return picture.convert("RGB").resize((WIDTH, height), Image.Resampling.BOX)


def differs(now: Image.Image, kept: Image.Image) -> str:
    """What is different, in words; empty: it looks the same."""
    off = now.height / kept.height - 1.0
    if abs(off) > HEIGHT_OFF:
        return f"{abs(off):.0%} {'longer' if off > 0 else 'shorter'}"
    size = (WIDTH // 4, max(8, kept.height // 4))
    first, second = (
        np.asarray(one.resize(size, Image.Resampling.BOX), dtype=np.float64) for one in (now, kept)
    )
    worst, where = 0.0, 0
    for top in range(0, size[1], STRIPE // 4):
        own = second[top : top + STRIPE // 4]
        rest = min(_distance(first, own, top + shift) for shift in range(-4, 5))
        if rest > worst:
            worst, where = rest, top
    if worst > MEAN_OFF:
        return f"off by {worst:.0f} of 255 at {where / size[1]:.0%} of its height"
    return ""


def _distance(picture: FloatArray, stripe: FloatArray, top: int) -> float:
    """Mean difference of a stripe and as many rows of a picture, from `top` on or near it."""
    first = min(max(0, top), max(0, len(picture) - len(stripe)))
    part = picture[first : first + len(stripe)]
    return float(np.mean(np.abs(part - stripe[: len(part)])))
