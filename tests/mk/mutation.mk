# make mutation: wrong tokens and left out statements in lib/ and port/ must make a unit test fail
# (tests/mutation/files.txt says which are those of a file). All of them are tried: first on the tests
# of the file and all quick ones, then what survives on every test that reaches it, and under the
# sanitizers. The next run goes on where this one stopped (after MUTATION_SECONDS); without
# build/mutation/outcomes.json it begins anew. The last result is tests/mutation/RESULT.md.
MUTATION_SECONDS ?= 14400
MUTATE ?=
MUTATION := nice -n 10 $(PY) tests/mutation/mutate.py $(MUTATE) --seconds $(MUTATION_SECONDS) \
    --keep $(B)/mutation/outcomes.json
.PHONY: mutation
mutation: setup-test $(UNITY_DIR)/unity.h $(CODEC).c
	@$(MUTATION) || [ $$? = 1 ] # survivors: the sanitizers may stop them
	@$(MUTATION) --again --thorough --report tests/mutation/RESULT.md
