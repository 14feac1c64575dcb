# make steady: what depends on time, again and again (TIMES=20), best beside other load: the loop with
# hardware, the firmware under emulation, the daemon, the live view, the survey. Ends at a failure.
TIMES ?= 20
STEADY := tests/host/test_daemon.py tests/host/test_hil.py tests/host/test_live.py \
    tests/host/test_live_page.py tests/host/test_survey.py
.PHONY: steady
steady: setup-test
	@for i in $$(seq $(TIMES)); do \
	    $(MAKE) --no-print-directory hil-checks firmware-test && \
	    $(VENV)/bin/pytest -q -p no:cacheprovider $(STEADY) || \
	    { echo "steady: run $$i of $(TIMES) failed"; exit 1; }; \
	    echo "steady: run $$i of $(TIMES) passed, load $$(cut -d' ' -f1 /proc/loadavg)"; done
