# make proofs-any: no overflow, no access out of bounds and nothing else undefined in what takes bytes
# from outside, for every input within the bounds in tests/proofs/any.c. Needs frama-c-base, a second
# or two each; in `make test` where it is installed.
ANY := tests/proofs/any.c
ANY_NAMES := $(shell sed -n 's/^void prove_\([a-z0-9_]*\)(void)$$/\1/p' $(ANY))
ANY_SOURCES := $(ANY) $(wildcard lib/arithmetic/*.c) lib/bus/sway_e2e.c lib/bus/sway_frames.c \
    lib/model/sway_vehicle.c port/replay/candump.c port/sway_block.c port/sway_siphash.c
ANY_PROVE := frama-c -eva -eva-precision 5 -eva-verbose 0 -machdep gcc_x86_64 \
    -warn-right-shift-negative -cpp-extra-args="-Ilib -Iport -Iport/replay -I$(B)/codec $(DEFINE)"
.PHONY: proofs-any
proofs-any: $(CODEC).c
	@mkdir -p $(B)/proofs
	@for name in $(ANY_NAMES); do log=$(B)/proofs/any-$$name.log; \
	    $(ANY_PROVE) -main prove_$$name $(ANY_SOURCES) $(CODEC).c >$$log 2>&1 || { cat $$log; exit 1; }; \
	    ! grep -qE 'eva:alarm|eva:garbled|No code nor implicit' $$log || { cat $$log; exit 1; }; done
	@echo "proofs-any: $(words $(ANY_NAMES)) of $(words $(ANY_NAMES)) proved: $(ANY_NAMES)"
checks::
	@if command -v frama-c >/dev/null; then $(MAKE) --no-print-directory -s proofs-any; \
	    else echo "proofs-any: not run, frama-c is not here"; fi
