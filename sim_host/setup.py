"""Builds the binding to the C core with the package (see core_build.py)."""

from setuptools import setup

setup(cffi_modules=["core_build.py:FFI_BUILDER"])
