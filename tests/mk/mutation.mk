# make mutation: wrong tokens in the code between bus and core must make its unit test fail.
.PHONY: mutation
mutation: setup-test $(B)/gcc/libsway.a $(UNITY_DIR)/unity.h
	@$(VENV)/bin/python tests/mutation/mutate.py $(or $(MUTATE),sway_e2e:test_node \
	    sway_node:test_node sway_frames:test_node) $(MUTATION_FLAGS)
