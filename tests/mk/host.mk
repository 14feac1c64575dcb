# Throughput of the analysis: times faster than real time, for each format.
.PHONY: bench-throughput
bench-throughput: setup-run
	@$(VENV)/bin/python tests/bench/throughput.py --markdown $(B)/bench/throughput.md $(THROUGHPUT)
bench:: bench-throughput
