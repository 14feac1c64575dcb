"""Builds the bindings to the C core and to the plant with the package."""

from setuptools import setup

setup(cffi_modules=["core_build.py:FFI_BUILDER", "plant_build.py:FFI_BUILDER"])
