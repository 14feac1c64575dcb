"""What the check of the Cortex-M0+ image calls floating point or heap."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

IMAGE = Path(__file__).resolve().parents[1] / "firmware" / "image.py"


def forbidden(name: str) -> bool:
    """Whether the image must not hold a symbol."""
    spec = importlib.util.spec_from_file_location("firmware_image", IMAGE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["firmware_image"] = module
    spec.loader.exec_module(module)
    return bool(module.FORBIDDEN.match(name))


FLOATING = """
__aeabi_dadd __aeabi_fmul __aeabi_ddiv __aeabi_i2d __aeabi_ui2d __aeabi_ui2f __aeabi_l2f
__aeabi_ul2d __aeabi_d2iz __aeabi_f2uiz __aeabi_cdcmple __aeabi_fcmpeq __aeabi_drsub
__adddf3 __mulsf3 __divdf3 __fixdfsi __fixunssfdi __floatsidf __floatundisf __extendsfdf2
__truncdfsf2 __unorddf2 sin cosf sqrt sqrtf exp log10 pow atan2 floor
"""
HEAP = "malloc calloc realloc free _malloc_r _free_r sbrk _sbrk _sbrk_r"
INTEGERS = """
__aeabi_lmul __aeabi_uidiv __aeabi_ldivmod __udivsi3 __divdi3 __muldi3 __clzsi2 memcpy memset
sway_real_word_exp sway_fit_factor square lateral free_line fixed_rows
"""


def test_floating_point_and_heap_are_found() -> None:
    """Software floating point, its mathematics, the heap."""
    assert [name for name in f"{FLOATING} {HEAP}".split() if not forbidden(name)] == []


def test_integers_are_allowed() -> None:
    """Integer helpers and what is ours."""
    assert [name for name in INTEGERS.split() if forbidden(name)] == []
