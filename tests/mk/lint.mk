# make lint: formatting, static analysis and types, each a target of its own.
C_SOURCES := $(shell git ls-files '*.c' '*.h' 2>/dev/null)
PY_SOURCES := $(shell git ls-files '*.py' 2>/dev/null)
LINT_PYTHON := $(if $(PY_SOURCES),lint-ruff-format lint-ruff lint-mypy)

.PHONY: lint-misra lint-clang-format lint-cppcheck $(LINT_PYTHON)
lint: lint-misra lint-cppcheck lint-clang-format $(LINT_PYTHON)
lint-clang-format: setup-test
	clang-format --dry-run --Werror $(C_SOURCES)
lint-cppcheck: setup-test $(CODEC).c
	cppcheck --quiet --std=c99 --enable=warning,performance,portability --error-exitcode=1 \
	    --inline-suppr --suppress=missingIncludeSystem -Ilib -I$(B)/codec $(wildcard lib/*/*.c)
MISRA := tests/lint/misra_deviations.txt
lint-misra: setup-test $(CODEC).c
	@$(PY) tests/lint/misra.py $(MISRA) $(PORT_COMMON) $(PORT_SOURCES_xcp) -Iport -Iport/xcp -Ilib -I$(B)/codec \
	    --suppress=missingIncludeSystem
lint-ruff-format: setup-test
	$(VENV)/bin/ruff format --check $(PY_SOURCES)
lint-ruff: setup-test
	$(VENV)/bin/ruff check $(PY_SOURCES)
lint-mypy: setup-test
	$(VENV)/bin/mypy $(wildcard sim_host/src/swaywatch)
