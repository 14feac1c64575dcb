# Warning campaign: how soon the alarm warns and how often for nothing, beside three other detectors.
# The whole campaign takes half an hour of one idle core, and goes on where it was stopped; `make
# bench` runs a small one.
.PHONY: bench-warning
WARNING := $(PY) tests/bench/warning_campaign.py --done $(B)/bench/warning.jsonl
warning-files = --output $(B)/bench/$1.json --markdown $(B)/bench/$1.md

bench-warning: setup-test
	@$(WARNING) $(call warning-files,warning) --drives 500 --hours 200 \
	    --workers $${SWAYWATCH_WORKERS:-1}

# The same unstable drives with one input lost, and with two.
.PHONY: bench-losses
bench-losses: setup-test
	@$(PY) tests/bench/warning_losses.py --output $(B)/bench/losses.md

# Broken sensors and other vehicles: how soon they are found and correctly named.
.PHONY: bench-supervision
bench-supervision: setup-test
	@$(PY) tests/bench/supervision.py --output $(B)/bench/supervision.md

bench::
	@$(WARNING) $(call warning-files,warning-small) --drives 60 --hours 2

# Every golden value of the reference beside what the core says; a miss fails.
.PHONY: bench-golden
$(B)/bench/golden: tests/bench/golden.c tests/unit/sway_test.h $(B)/gcc/libsway.a
	@mkdir -p $(@D)
	@echo "CC $@"
	@gcc -std=c99 -Wall -Wextra -D_GNU_SOURCE $(CFLAGS_gcc) $(DEFINE) $(INCLUDE) -Itests/unit \
	    $< $(B)/gcc/libsway.a -lm -o $@

bench-golden: $(B)/bench/golden
	@$< >$(B)/bench/golden.md || { cat $(B)/bench/golden.md; exit 1; }
	@tail -n 1 $(B)/bench/golden.md

checks: bench-golden
bench:: bench-golden
