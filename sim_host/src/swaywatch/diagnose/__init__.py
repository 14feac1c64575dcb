"""Diagnosis: where a simulation and a recording differ, and what physics was left out."""

import os

# A diagnosis solves many small systems: threads of the linear algebra only wait for each other
# (half of the CPU time). They are set up when numpy is first imported, which is below.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
