# A survey of a generated fleet on a dask cluster of this machine: 1, 2 and 4 workers, one killed.
.PHONY: bench-fleet
FLEET ?=
bench-fleet: setup-test
	@$(PY) tests/bench/fleet.py --out $(B)/fleet --report $(B)/bench/fleet.md $(FLEET)
bench:: bench-fleet
