# make dist: the core as a tarball for other build systems (CMake, pkg-config, Zephyr, PlatformIO,
# ESP-IDF); make dist-test: built by them, outside this repository; make dist-tools: its
# manifests by the tools of PlatformIO, ESP-IDF and Kconfig.
SYSTEM_DIST := cmake=cmake pkg-config=pkg-config g++=g++ arm-none-eabi-gcc=gcc-arm-none-eabi \
    /usr/lib/arm-none-eabi/include/string.h=libnewlib-arm-none-eabi
SYSTEM_TEST += $(SYSTEM_DIST)

DIST := $(B)/dist
DIST_SOURCES := $(wildcard lib/*.h lib/*/*.[ch] port/sway_*.[ch] dbc/*.dbc port/package/* \
    port/package/zephyr/*) CHANGELOG.md LICENSE
$(DIST)/stamp: $(DIST_SOURCES) $(CODEC).c | $(KISSFFT_DIR)/kiss_fft.h
	@mkdir -p $(DIST)
	@$(or $(PYTHON),python3) port/package/make-dist $(DIST) $(KISSFFT_DIR) $(B)/codec
	@touch $@

.PHONY: dist dist-test
dist: $(DIST)/stamp
dist-test: $(DIST)/stamp
	@tests/tools/need $(SYSTEM_DIST)
	@tests/package/run $(DIST) $(B)/dist-test
checks: dist-test

# The manifests by the tools of their own systems (from PyPI, in a folder of their own).
DIST_TOOLS := platformio==6.2.0 idf-component-manager==3.1.2 kconfiglib==14.1.0
.PHONY: dist-tools
dist-tools: dist-test
	@[ -e $(B)/dist-tools/whole ] || { $(or $(PYTHON),python3) -m venv $(B)/dist-tools && \
	    $(B)/dist-tools/bin/pip install -q --disable-pip-version-check $(DIST_TOOLS) && \
	    touch $(B)/dist-tools/whole; }
	@$(B)/dist-tools/bin/python tests/package/manifests.py $(B)/dist-test/swaywatch
