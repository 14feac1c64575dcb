# make mutation: wrong tokens in lib/ must make a unit test fail. A sample of each file, always the
# same; MUTATION_SAMPLE=0 tries all of them. At the lowest priority: it may take an hour.
MUTATION_SAMPLE ?= 10
MUTATE ?= $(addprefix sway_,grid:test_grid ring:test_grid,test_line_bits spectrum:test_spectrum \
    $(patsubst %,%:test_line_bits$(comma)test_line,fit break line line_read seek track) \
    real:test_real,test_line_bits stm:test_stm e2e:test_e2e node:test_node frames:test_frames)
.PHONY: mutation
mutation: setup-test $(B)/gcc/libsway.a $(UNITY_DIR)/unity.h
	@nice -n 19 $(PY) tests/mutation/mutate.py $(MUTATE) --sample $(MUTATION_SAMPLE) \
	    --report $(B)/bench/mutation.md
