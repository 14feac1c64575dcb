# make coverage: lines and branches of lib/ that the unit tests run; build/coverage/index.html shows
# them. It fails below 100 % of either, but for what tests/coverage/allowed.txt allows.
# tests/small holds the tests of the smallest configuration, which has code of its own.
SMALL := $(B)/coverage-small
SMALL_FLAGS = -std=c99 -Wall -Wextra -D_GNU_SOURCE $(FW_SIZES_small) $(DEFINE) $(INCLUDE) -Itests/unit \
    -I$(UNITY_DIR) -DUNITY_INCLUDE_DOUBLE
$(SMALL)/test_small: tests/small/test_small.c $(LIB_NAMES:%=lib/%.c) $(wildcard lib/*.h lib/*/*.h) \
    $(CODEC).c $(B)/coverage/kissfft/kiss_fft.o | $(UNITY_DIR)/unity.h
	@mkdir -p $(@D)
	@echo "CC $@"
	@gcc $(SMALL_FLAGS) $(CFLAGS_coverage) $< $(LIB_NAMES:%=lib/%.c) $(CODEC).c \
	    $(B)/coverage/kissfft/kiss_fft.o $(UNITY_DIR)/unity.c -lm -o $@

.PHONY: coverage
coverage: setup-test $(UNIT_NAMES:%=$(B)/coverage/unit/%) $(SMALL)/test_small
	@find $(B)/coverage $(SMALL) -name '*.gcda' -delete
	$(call run-unit,coverage)
	@$(SMALL)/test_small >$(SMALL)/out.txt || { cat $(SMALL)/out.txt; exit 1; }
	@$(VENV)/bin/gcovr --root . --filter 'lib/' --merge-mode-functions=separate \
	    --json $(B)/coverage/lib.json --html-details $(B)/coverage/index.html $(B)/coverage $(SMALL)
	@$(PY) tests/coverage/gate.py $(B)/coverage/lib.json tests/coverage/allowed.txt
checks: coverage
