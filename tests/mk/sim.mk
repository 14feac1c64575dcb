# The simulator: real-time factors, a campaign of 500 drives, the chapters of the reference.
.PHONY: bench-models reproduce
bench-models: setup-test
	@$(PY) tests/bench/models.py --report $(B)/bench/depths.md
bench:: bench-models

reproduce: setup-test
	@$(VENV)/bin/swaywatch reproduce --out $(B)/reproduce
