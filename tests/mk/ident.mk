# Warning campaign: how soon the alarm warns and how often for nothing, beside three other detectors.
# The whole campaign takes an hour or two of one core; `make bench` runs a small one.
.PHONY: bench-warning
WARNING := $(PY) tests/bench/warning_campaign.py --output $(B)/bench/warning.json \
    --markdown $(B)/bench/warning.md

bench-warning: setup-test
	@$(WARNING) --drives 500 --hours 200 --workers $${SWAYWATCH_WORKERS:-1}

bench::
	@$(WARNING) --drives 60 --hours 2
