# `make package`: wheel and source distribution, installed in a clean environment outside the
# repository, where a recording is analysed. Needs the package index.
.PHONY: package
package: setup
	@tests/tools/package $(B)/package

# `make foreign`: 400 mistakes of foreign recordings, how each ends, and a table; minutes.
.PHONY: foreign
foreign: setup
	@$(PY) tests/host/foreign.py 400 1

# `make first-hour`: what a new user ran into, before and now, each by a command; some minutes.
.PHONY: first-hour
first-hour: setup $(SWAYWATCHD)
	@tests/tools/first-hour
