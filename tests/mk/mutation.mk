# make mutation: wrong tokens and left out statements in lib/ and port/ must make a unit test fail
# (tests/mutation/files.txt says which). MUTATION_SECONDS and MUTATION_SAMPLE bound a run; the next
# one goes on where it stopped. The last result is tests/mutation/RESULT.md.
MUTATION_SECONDS ?= 3600
MUTATION_SAMPLE ?= 0
MUTATE ?=
.PHONY: mutation
mutation: setup-test $(B)/gcc/libsway.a $(UNITY_DIR)/unity.h
	@nice -n 10 $(PY) tests/mutation/mutate.py $(MUTATE) --sample $(MUTATION_SAMPLE) \
	    --seconds $(MUTATION_SECONDS) --keep $(B)/mutation/outcomes.json --again \
	    --report tests/mutation/RESULT.md
