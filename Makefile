# Swaywatch. `make run` does the main job, `make test` runs every test; both set up what they need
# first. `make help` lists the targets.
#
# A part of the project adds its own recipes in tests/mk/NAME.mk or port/NAME/rules.mk:
# prerequisites of `quick`, `checks` and `lint` (each a target of its own: they run side by side),
# double-colon rules for `bench` (one after the other), and items for SYSTEM_TEST.

SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DELETE_ON_ERROR:
MAKEFLAGS += --no-builtin-rules
.DEFAULT_GOAL := help

B := build
STAMP := $(B)/stamp
VENV := .venv
PY := $(VENV)/bin/python

# The newest interpreter that will do, first the plain name.
PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11; do \
    $$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && { echo $$p; break; }; \
    done)

.PHONY: help setup setup-run setup-test lib codec clean lock
help:
	@echo "Start here:"
	@echo "  make run            set up, analyse a recording of this repository (about a minute)"
	@echo "  make diagnosis      compare it with a simulation: where they differ, what is missing"
	@echo "  make test           set up and run every test (long)"
	@echo "Develop:"
	@echo "  make setup          everything that tests need"
	@echo "  make quick          unit tests of the core, under a minute"
	@echo "  make lint           compilers' warnings, MISRA, ruff, mypy, formats"
	@echo "  make coverage       lines and branches of lib/ that unit tests leave out"
	@echo "  make docs           documentation as a site in build/"
	@echo "Hardware:"
	@echo "  make hil            daemon and hardware in the loop on a real kernel CAN"
	@echo "  make firmware-test  the ECU under emulation: Cortex-M, Cortex-R5, MIPS"
	@echo "  make board-images   images for ST's NUCLEO-G474RE"
	@echo "Figures of README.md and sim_host/docs/benchmarks.md:"
	@echo "  make bench          benchmarks; make bench-NAME for one"
	@echo "  make proof          diagnosis of recordings with published true values"
	@echo "  make proof-blind    the same on concealed cases, each with the limit of what it can tell"
	@echo "Deliver:"
	@echo "  make package dist   Python wheel; sources for CMake, Zephyr, PlatformIO, ESP-IDF"
	@echo "  make lock clean     renew the list of Python packages; remove everything built"

# --- what the machine must have -------------------------------------------------------------------
SYSTEM_CODEC := python3=python3 py:ensurepip=python3-venv \
    /etc/ssl/certs/ca-certificates.crt=ca-certificates
SYSTEM_RUN := $(SYSTEM_CODEC) gcc=gcc /usr/include/stdio.h=libc6-dev ar=binutils \
    py:Python.h=python3-dev dpkg-source=dpkg-dev xz=xz-utils
SYSTEM_TEST := clang=clang g++=g++ clang-format=clang-format cppcheck=cppcheck git=git

$(STAMP)/system-codec: Makefile
	@mkdir -p $(@D)
	@tests/tools/need $(SYSTEM_CODEC)
	@touch $@

$(STAMP)/system-run: Makefile
	@mkdir -p $(@D)
	@tests/tools/need $(SYSTEM_RUN)
	@touch $@

$(STAMP)/system-test: $(STAMP)/system-run $(wildcard tests/mk/*.mk port/*/rules.mk)
	@tests/tools/need $(SYSTEM_TEST)
	@touch $@

# --- third-party sources, never committed ---------------------------------------------------------
KISSFFT_DIR ?= $(B)/third_party/kissfft
UNITY_DIR ?= $(B)/third_party/ntpsec/tests/unity

$(B)/third_party/kissfft/kiss_fft.h: | $(STAMP)/system-run
	@echo "fetching kissfft"
	@tests/tools/fetch-source kissfft kissfft_131.1.0 \
	    76c1aac87ddb7258f34b08a13f0eebf9e53afa299857568346aa5c82bcafaf1a $(B)/third_party/kissfft

$(B)/third_party/ntpsec/tests/unity/unity.h: | $(STAMP)/system-run
	@echo "fetching Unity"
	@tests/tools/fetch-source ntpsec ntpsec_1.2.2 \
	    53e527e3d04d551d41af2d359c2715c2de5f5bfa2a695d4ec1a811b3e9137f63 $(B)/third_party/ntpsec

# --- Python ---------------------------------------------------------------------------------------
REQUIREMENTS := sim_host/requirements
PIP := $(PY) -m pip install --quiet --disable-pip-version-check --no-input

$(VENV)/stamp-codec: $(REQUIREMENTS)/codec.lock | $(STAMP)/system-codec
	@[ -x $(PY) ] || "$(or $(PYTHON),python3)" -m venv $(VENV)
	@$(PIP) --require-hashes -r $<
	@touch $@

$(VENV)/stamp-run: $(REQUIREMENTS)/run.lock | $(STAMP)/system-run $(VENV)/stamp-codec
	@echo "setting up Python packages"
	@$(PIP) --require-hashes -r $<
	@touch $@

$(VENV)/stamp-test: $(REQUIREMENTS)/test.lock $(VENV)/stamp-run
	@echo "setting up Python packages for tests"
	@$(PIP) --require-hashes -r $<
	@touch $@

# The package is built again when the C core that it wraps has changed.
PACKAGE_SOURCES := $(wildcard sim_host/pyproject.toml sim_host/setup.py sim_host/*build*.py \
    sim_host/src/swaywatch/*/*.[ch])
$(VENV)/stamp-package: $(VENV)/stamp-run $(PACKAGE_SOURCES) $(wildcard lib/*.h lib/*/*.[ch]) \
    $(B)/codec/swaywatch_dbc.c $(KISSFFT_DIR)/kiss_fft.h
ifneq ($(wildcard sim_host/pyproject.toml),)
	@echo "building the Python package"
	@rm -rf $(B)/pip && mkdir -p $(B)/pip # objects of ../lib land beside the temporary folder
	@TMPDIR="$(abspath $(B)/pip)" KISSFFT_DIR="$(abspath $(KISSFFT_DIR))" \
	    SWAYWATCH_CODEC_DIR="$(abspath $(B)/codec)" $(PIP) --no-deps --no-build-isolation -e sim_host
endif
	@touch $@

lock:
	@rm -rf $(B)/uv && $(or $(PYTHON),python3) -m venv $(B)/uv && $(B)/uv/bin/pip install -q uv
	@cd $(REQUIREMENTS) && for set in test run codec; do UV_CUSTOM_COMPILE_COMMAND="make lock" \
	    $(abspath $(B))/uv/bin/uv pip compile --quiet --universal --python-version 3.11 \
	    --generate-hashes $${set}.in -o $$set.lock $(LOCK_FLAGS) \
	    $$([ $$set = test ] || echo -c test.lock); done

# --- the codec, generated from the bus description ------------------------------------------------
CODEC := $(B)/codec/swaywatch_dbc
codec: $(CODEC).c
$(CODEC).c: dbc/swaywatch.dbc | $(VENV)/stamp-codec
	@mkdir -p $(@D)
	@$(VENV)/bin/cantools generate_c_source --no-floating-point-numbers \
	    --database-name swaywatch_dbc --output-directory $(@D) $< >/dev/null
	@sed -i -e '/_is_in_phys_range(double value)$$/,/^}/d' \
	    -e '/_is_in_phys_range(double value);$$/d' $(CODEC).c $(CODEC).h # the last floats
$(CODEC).h: $(CODEC).c

# --- the C core, by two compilers -----------------------------------------------------------------
WARN := -std=c99 -pedantic -Wall -Wextra -Wconversion -Wshadow -Werror
INCLUDE := -Ilib -I$(KISSFFT_DIR) -I$(B)/codec
DEFINE := -DFIXED_POINT=32
# Only kiss_fft() is used: no memory is taken, nothing is printed.
KISSFFT_FLAGS := -DNDEBUG '-DKISS_FFT_MALLOC(n)=((void *)0)' '-DKISS_FFT_FREE(p)=((void)(p))'
LIB_NAMES := $(sort $(patsubst lib/%.c,%,$(wildcard lib/*/*.c)))
CFLAGS_gcc := -O2 -g
CFLAGS_clang := -O2 -g
# Not every clang comes with the sanitizers' runtime; gcc does.
CFLAGS_sanitize := -O1 -g -fno-omit-frame-pointer -fsanitize=address,undefined \
    -fno-sanitize-recover=all
CFLAGS_coverage := -O0 -g --coverage
CC_gcc := gcc
CC_clang := clang
CC_sanitize := gcc
CC_coverage := gcc

# Every level of optimisation of both, for `make unit-levels`: gcc-O0 to clang-Os.
LEVELS := $(foreach c,gcc clang,$(addprefix $c-O,0 1 2 3 s))
$(foreach l,$(LEVELS),$(eval CC_$l := $(firstword $(subst -, ,$l)))$(eval CFLAGS_$l := -$(lastword $(subst -, ,$l))))

# FLAVOUR: gcc, clang, sanitize, coverage, a level. build/FLAVOUR/libsway.a holds lib/, the codec,
# kissfft.
define flavour
$(B)/$(1)/lib/%.o: lib/%.c | $(KISSFFT_DIR)/kiss_fft.h $(CODEC).c
	@mkdir -p $$(@D)
	@echo "CC $$@"
	@$$(CC_$(1)) $$(WARN) $$(CFLAGS_$(1)) $$(DEFINE) $$(INCLUDE) -MMD -MP -c $$< -o $$@
$(B)/$(1)/codec/swaywatch_dbc.o: $(CODEC).c
	@mkdir -p $$(@D)
	@echo "CC $$@"
	@$$(CC_$(1)) -std=c99 -w $$(CFLAGS_$(1)) -c $$< -o $$@
$(B)/$(1)/kissfft/kiss_fft.o: $(KISSFFT_DIR)/kiss_fft.h
	@mkdir -p $$(@D)
	@echo "CC $$@"
	@$$(CC_$(1)) -std=gnu99 -w $$(CFLAGS_$(1)) $$(DEFINE) $$(KISSFFT_FLAGS) \
	    -c $(KISSFFT_DIR)/kiss_fft.c -o $$@
$(B)/$(1)/libsway.a: $$(LIB_NAMES:%=$(B)/$(1)/lib/%.o) $(B)/$(1)/codec/swaywatch_dbc.o \
    $(B)/$(1)/kissfft/kiss_fft.o
	@rm -f $$@
	@ar rcs $$@ $$^
$(B)/$(1)/unity.o: $(UNITY_DIR)/unity.h
	@mkdir -p $$(@D)
	@$$(CC_$(1)) -std=c99 $$(CFLAGS_$(1)) -DUNITY_INCLUDE_DOUBLE -c $(UNITY_DIR)/unity.c -o $$@
$(B)/$(1)/unit/%: tests/unit/%.c $(B)/$(1)/libsway.a $(B)/$(1)/unity.o
	@mkdir -p $$(@D)
	@echo "CC $$@"
	@$$(CC_$(1)) -std=c99 -Wall -Wextra -D_GNU_SOURCE $$(CFLAGS_$(1)) $$(DEFINE) $$(INCLUDE) -Itests/unit \
	    -I$(UNITY_DIR) -DUNITY_INCLUDE_DOUBLE -MMD -MP $$< $(B)/$(1)/unity.o \
	    $(B)/$(1)/libsway.a -lm -o $$@
-include $$(wildcard $(B)/$(1)/lib/*/*.d $(B)/$(1)/unit/*.d)
endef
$(foreach f,gcc clang sanitize coverage $(LEVELS),$(eval $(call flavour,$f)))

lib: $(B)/gcc/libsway.a $(B)/clang/libsway.a

UNIT_NAMES := $(sort $(patsubst tests/unit/%.c,%,$(wildcard tests/unit/test_*.c)))
# $(call run-unit,FLAVOUR): every unit test program; all are run, then any failure ends make.
run-unit = @status=0; for t in $(UNIT_NAMES:%=$(B)/$1/unit/%); do \
    out=$$($$t 2>&1) || { status=1; echo "$$out"; }; \
    echo "$${t\#$(B)/}: $$(grep -E 'Tests [0-9]+ Failures' <<<"$$out" || tail -n 1 <<<"$$out")"; \
    done; exit $$status

# --- set up, run ----------------------------------------------------------------------------------
setup: setup-test
setup-run: $(VENV)/stamp-package
setup-test: $(STAMP)/system-test $(VENV)/stamp-test $(VENV)/stamp-package $(UNITY_DIR)/unity.h

DEMO := tests/data/practice/p03
.PHONY: run diagnosis
run: setup-run
	@$(VENV)/bin/swaywatch analyze $(DEMO)/run1.asc $(DEMO)/run2.asc \
	    --vehicle $(DEMO)/vehicle.toml --signals $(DEMO)/signals.toml --out $(B)/run

# The same drive against the simulation: where they differ, what the simulation left out.
diagnosis: $(VENV)/stamp-test $(VENV)/stamp-package
	@$(VENV)/bin/swaywatch diagnose $(DEMO)/run1.asc $(DEMO)/run2.asc \
	    --vehicle $(DEMO)/vehicle.toml --signals $(DEMO)/signals.toml --out $(B)/diagnosis
	@echo "$(B)/diagnosis/report.html"

# --- tests ----------------------------------------------------------------------------------------
# quick: under a minute; test: all of it. Fragments add prerequisites to quick, checks and lint.
.PHONY: quick test checks hil-checks lint bench

# unit-FLAVOUR: the unit tests so built.
define unit
.PHONY: unit-$(1)
unit-$(1): $(UNIT_NAMES:%=$(B)/$(1)/unit/%)
	$$(call run-unit,$(1))
endef
$(foreach f,sanitize clang gcc $(LEVELS),$(eval $(call unit,$f)))
quick: unit-sanitize
# The firmware is the longest of them: begun first, nobody waits for it at the end.
checks: firmware-test unit-sanitize unit-clang unit-gcc

# The unit tests at every level of optimisation, without a sanitizer or -fwrapv: what is undefined
# would show as a difference. In `make test` gcc's -O2, of the objects that are there.
.PHONY: unit-levels
unit-levels: $(LEVELS:%=unit-%)

lint: lib

bench:: setup-test

-include $(sort $(wildcard port/*/rules.mk)) $(sort $(wildcard tests/mk/*.mk))

checks: lint

# The loop with hardware waits for real time more than it works: the other checks run beside it, two
# at a time.
# pytest is last, so that a test run ends with its line. A file of tests runs in one process, those
# that take longest first (tests/host/conftest.py); PYTEST_WORKERS=0 runs all of them in this one.
PYTEST_WORKERS ?= 2
test:: setup-test
	@$(MAKE) --no-print-directory -j3 -Otarget hil-checks checks
ifneq ($(wildcard tests/host/test_*.py),)
test::
	@$(VENV)/bin/pytest -q -n $(PYTEST_WORKERS) --dist loadfile --no-loadscope-reorder \
	    -m "not long" --durations=40 tests/host
endif

clean:
	rm -rf $(B) $(VENV) .pytest_cache .mypy_cache .ruff_cache .hypothesis
