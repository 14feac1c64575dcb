# make bench-plan: errors that `swaywatch plan` foretells beside those of simulated tests.
.PHONY: bench-plan
bench-plan: setup-test
	@$(PY) tests/bench/plan_repeats.py --report $(B)/bench/plan.md
bench:: bench-plan
