# The documentation as a site that needs no network: build/docs/site/index.html.
.PHONY: docs
docs: setup-test
	@$(PY) sim_host/docs/build.py --out $(B)/docs
