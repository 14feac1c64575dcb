# make fuzz-recordings: mutated recordings, DBCs and TOMLs for FUZZ_SECONDS; findings are kept in
# build/fuzz-recordings. The quick test of the host runs a fixed few.
FUZZ_SECONDS ?= 3600
FUZZ_SEED ?= 1
.PHONY: fuzz-recordings
fuzz-recordings: setup
	@$(PY) tests/fuzz/fuzz_recordings.py --seconds $(FUZZ_SECONDS) --seed $(FUZZ_SEED) \
	    --out $(B)/fuzz-recordings
