# make dist: the core as a tarball for other build systems (CMake, pkg-config, Zephyr, PlatformIO,
# ESP-IDF); make dist-test: built by them, outside this repository.
SYSTEM_TEST += cmake=cmake pkg-config=pkg-config

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
	@tests/package/run $(DIST) $(B)/dist-test
test:: dist-test
