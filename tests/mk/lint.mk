# make lint: formatting, static analysis and types.
C_SOURCES := $(shell git ls-files '*.c' '*.h' 2>/dev/null)
PY_SOURCES := $(shell git ls-files '*.py' 2>/dev/null)

lint::
	clang-format --dry-run --Werror $(C_SOURCES)
lint::
	cppcheck --quiet --std=c99 --enable=warning,performance,portability --error-exitcode=1 \
	    --inline-suppr --suppress=missingIncludeSystem -Ilib -I$(B)/codec $(wildcard lib/*/*.c)
MISRA := tests/lint/misra_deviations.txt
lint::
	@$(PY) tests/lint/misra.py $(MISRA) $(PORT_COMMON) $(PORT_SOURCES_xcp) -Iport -Iport/xcp -Ilib -I$(B)/codec \
	    --suppress=missingIncludeSystem
ifneq ($(PY_SOURCES),)
lint::
	$(VENV)/bin/ruff format --check $(PY_SOURCES)
lint::
	$(VENV)/bin/ruff check $(PY_SOURCES)
lint::
	$(VENV)/bin/mypy $(wildcard sim_host/src/swaywatch)
endif
