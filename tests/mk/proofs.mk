# make proofs-any: no overflow, no access out of bounds and nothing else undefined in what takes bytes
# from outside, for every input within the bounds in tests/proofs/any.c. Needs frama-c-base, 2 to 10
# seconds each; in `make test` where it is installed.
ANY := tests/proofs/any.c
ANY_NAMES := $(shell sed -n 's/^void prove_\([a-z0-9_]*\)(void)$$/\1/p' $(ANY))
ANY_SOURCES := $(ANY) $(wildcard lib/arithmetic/*.c) lib/bus/sway_e2e.c lib/bus/sway_frames.c \
    lib/bus/sway_map.c lib/model/sway_vehicle.c port/replay/candump.c port/sway_bit_timing.c \
    port/sway_block.c port/sway_siphash.c port/xcp/sway_xcp_daq.c
ANY_PROVE := frama-c -eva -eva-precision 5 -eva-verbose 0 -machdep gcc_x86_64 \
    -warn-right-shift-negative -cpp-extra-args="-Ilib -Iport -Iport/replay -Iport/xcp \
    -I$(KISSFFT_DIR) -I$(B)/codec $(DEFINE)"
ANY_MORE_e2e_step := -eva-min-loop-unroll 64 # the steps of a division apart
ANY_MORE_xcp_daq := -eva-slevel 5000 # every size of every entry apart
.PHONY: proofs-any $(ANY_NAMES:%=proof-any-%)
$(ANY_NAMES:%=proof-any-%): proof-any-%: $(CODEC).c | $(KISSFFT_DIR)/kiss_fft.h
	@mkdir -p $(B)/proofs
	@log=$(B)/proofs/any-$*.log; \
	    $(ANY_PROVE) $(ANY_MORE_$*) -main prove_$* $(ANY_SOURCES) $(CODEC).c >$$log 2>&1 || { cat $$log; exit 1; }; \
	    ! grep -qE 'eva:alarm|eva:garbled|No code nor implicit' $$log || { cat $$log; exit 1; }
proofs-any: $(ANY_NAMES:%=proof-any-%)
	@echo "proofs-any: $(words $(ANY_NAMES)) of $(words $(ANY_NAMES)) proved: $(ANY_NAMES)"
.PHONY: proofs-any-here
checks: proofs-any-here
proofs-any-here: $(CODEC).c | $(KISSFFT_DIR)/kiss_fft.h
	@if command -v frama-c >/dev/null; then $(MAKE) --no-print-directory -s proofs-any; \
	    else echo "proofs-any: not run, frama-c is not here"; fi
