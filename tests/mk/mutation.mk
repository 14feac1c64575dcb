# make mutation: wrong tokens in lib/ must make a unit test fail. A sample of each file, always the
# same; MUTATION_SAMPLE=0 tries all of them. At the lowest priority: it may take an hour.
MUTATION_SAMPLE ?= 20
MUTATE ?= $(addprefix sway_,grid:test_grid ring:test_grid,test_line spectrum:test_spectrum \
    fit:test_line break:test_line line:test_line line_read:test_line seek:test_line \
    track:test_line real:test_real,test_line stm:test_stm e2e:test_node node:test_node \
    frames:test_node)
.PHONY: mutation
mutation: setup-test $(B)/gcc/libsway.a $(UNITY_DIR)/unity.h
	@nice -n 19 $(PY) tests/mutation/mutate.py $(MUTATE) --sample $(MUTATION_SAMPLE) \
	    --report $(B)/bench/mutation.md
