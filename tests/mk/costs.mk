# make bench-costs: what findings cost in km/h beside the plant's own critical speeds; half an hour
# of one core the first time (the diagnoses are kept in build/bench/costs).
.PHONY: bench-costs
bench-costs: setup-test
	@test -n "$(PROOF_RECORDINGS)" || { echo "bench-costs: no recordings; set SWAYWATCH_RECORDINGS"; exit 1; }
	@$(PY) tests/bench/costs.py --recordings $(PROOF_RECORDINGS) --kept $(B)/bench/costs \
	    --report $(B)/bench/costs.md
