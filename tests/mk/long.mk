# make long: tests of the host that take a minute or more and that `make test` leaves out: further
# laws to be found, and the two practice cases that are searched longest.
.PHONY: long
long: setup-test
	@$(VENV)/bin/pytest -q -n $(PYTEST_WORKERS) -m long --durations=40 tests/host
