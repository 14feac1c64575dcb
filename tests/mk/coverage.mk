# make coverage: which lines of lib/ the unit tests run; build/coverage/index.html shows them.
.PHONY: coverage
coverage: setup-test $(UNIT_NAMES:%=$(B)/coverage/unit/%)
	@find $(B)/coverage -name '*.gcda' -delete
	$(call run-unit,coverage)
	@$(VENV)/bin/gcovr --root . --filter 'lib/' --object-directory $(B)/coverage --txt \
	    --html-details $(B)/coverage/index.html --txt-summary
