# make bench-plan: errors that `swaywatch plan` predicts beside those of simulated tests.
.PHONY: bench-plan
bench-plan: setup-test
	@$(PY) tests/bench/plan_repeats.py --report $(B)/bench/plan.md
bench:: bench-plan
