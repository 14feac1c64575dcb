# bench-diagnosis: seconds and memory of a diagnosis; with the recordings every practice and Chrono
# case, else the committed ones. To be run alone: wall-clock seconds are given.
.PHONY: bench-diagnosis
bench-diagnosis: setup-test
	@$(PY) tests/bench/diagnosis_cost.py --out $(B)/bench/diagnosis_cost.md \
	    $(addprefix --recordings ,$(firstword $(SWAYWATCH_RECORDINGS) \
	        $(wildcard ../shared/recordings) $(wildcard ../../shared/recordings)))
	@cat $(B)/bench/diagnosis_cost.md
bench:: bench-diagnosis
