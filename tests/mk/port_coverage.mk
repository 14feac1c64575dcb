# make coverage-port: lines of port/ that its unit tests run (what a board alone can run is left
# out: start-up code, the emulated machines, Linux' sockets; so is the R5's driver, whose file has the
# name of another); build/port-coverage/index.html shows them. It fails below the limits, which go
# up with the tests and not down.
PORT_COVERAGE_LINES ?= 97.5
PORT_COVERAGE_BRANCHES ?= 91
PORT_COVERAGE_TESTS := stm32g4 stm32g4_trailer ecu ecu_access ecu_store ecu_trailer common xcp xcp_daq
PORT_COVERAGE := $(B)/port-coverage
PORT_COVERAGE_CC = gcc $(filter-out $(CFLAGS_sanitize),$(PORT_FLAGS)) -O0 -g --coverage $(PORT_INCLUDE)
.PHONY: coverage-port
coverage-port: setup-test $(B)/gcc/libsway.a
	@rm -rf $(PORT_COVERAGE) && mkdir -p $(PORT_COVERAGE)
	@$(foreach s,$(PORT_COMMON) $(UNITY_DIR)/unity.c,$(PORT_COVERAGE_CC) -c $s \
	    -o $(PORT_COVERAGE)/$(notdir $(s:.c=.o)) &&) true
	@$(foreach t,$(PORT_COVERAGE_TESTS),$(PORT_COVERAGE_CC) $(PORT_INCLUDE_$t) \
	    -o $(PORT_COVERAGE)/test_$t tests/port/test_$t.c $(PORT_SOURCES_$t) $(PORT_COVERAGE)/*.o \
	    $(B)/gcc/libsway.a -lm && $(PORT_COVERAGE)/test_$t >/dev/null &&) true
	@$(VENV)/bin/gcovr --root . --filter port/ --object-directory . \
	    --gcov-ignore-errors=no_working_dir_found --merge-mode-functions=separate \
	    --txt $(PORT_COVERAGE)/lines.txt --html-details $(PORT_COVERAGE)/index.html --txt-summary \
	    --fail-under-line $(PORT_COVERAGE_LINES) --fail-under-branch $(PORT_COVERAGE_BRANCHES) \
	    $(PORT_COVERAGE) >$(PORT_COVERAGE)/summary.txt 2>$(PORT_COVERAGE)/errors.txt \
	    || { cat $(PORT_COVERAGE)/lines.txt $(PORT_COVERAGE)/errors.txt; exit 1; }
	@sed 's/^/port\/ /' $(PORT_COVERAGE)/summary.txt
checks: coverage-port
