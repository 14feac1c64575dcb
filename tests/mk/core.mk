# The estimator: its benchmark, its instruction counts, its proofs.
ESTIMATOR_SOURCES := $(wildcard lib/arithmetic/*.c lib/signal/*.c)
ESTIMATOR_SO := $(B)/bench/libestimator.so
BENCH_PYTHON := $(wildcard tests/bench/estimator*.py)

# A ring of 2048 rows holds 6 oscillations down to 0.3 Hz.
$(ESTIMATOR_SO): tests/bench/estimator_shim.c $(ESTIMATOR_SOURCES) $(wildcard lib/*.h lib/*/*.h) \
    | $(KISSFFT_DIR)/kiss_fft.h
	@mkdir -p $(@D)
	@echo "CC $@"
	@gcc -std=c99 -Wall -Wextra -O2 -g -shared -fPIC $(DEFINE) -DSWAY_RING_SAMPLES=2048 $(INCLUDE) $< \
	    $(ESTIMATOR_SOURCES) $(KISSFFT_DIR)/kiss_fft.c -lm -o $@

.PHONY: bench-estimator bench-cortex
bench-estimator: setup-test $(ESTIMATOR_SO) bench-cortex $(B)/bench/drift.txt
	@$(PY) tests/bench/estimator.py $(ESTIMATOR_SO) --drift $(B)/bench/drift.txt \
	    --report $(B)/bench/estimator.md
bench:: bench-estimator
.PHONY: estimator-quick
checks: estimator-quick
estimator-quick: $(ESTIMATOR_SO)
	@$(PY) tests/bench/estimator.py $(ESTIMATOR_SO) --quick >$(B)/bench/estimator-quick.md \
	    || { cat $(B)/bench/estimator-quick.md; exit 1; }
	@tail -n 1 $(B)/bench/estimator-quick.md

# --- instruction counts on emulated Cortex-M ------------------------------------------------------
include port/mps2/mps2.mk
# kissfft for a target: no heap, no printing.
KISSFFT_TARGET := -DNDEBUG '-DKISS_FFT_MALLOC(n)=((void *)0)' '-DKISS_FFT_FREE(p)=((void)(p))'
CORTEX_INCLUDE := -Ilib -isystem $(KISSFFT_DIR) $(DEFINE)

# CMSIS-DSP for comparison; its FFTs as a relocatable object per core.
CMSIS := $(B)/third_party/cmsisdsp
CMSIS_SOURCES := $(addprefix $(CMSIS)/Source/,CommonTables/arm_common_tables.c \
    CommonTables/arm_const_structs.c $(addprefix TransformFunctions/arm_,bitreversal.c \
    bitreversal2.c cfft_init_q15.c cfft_init_q31.c cfft_q15.c cfft_q31.c cfft_radix4_q15.c \
    cfft_radix4_q31.c))
CMSIS_INCLUDE := -isystem tests/bench/cmsis -isystem $(CMSIS)/Include -isystem $(CMSIS)/PrivateInclude

$(CMSIS)/Include/arm_math.h: tests/bench/cmsis/requirements.txt | $(VENV)/stamp-run
	@mkdir -p $(CMSIS)
	@echo "fetching CMSIS-DSP"
	@$(PY) -m pip download --quiet --disable-pip-version-check --no-deps --no-binary :all: --no-build-isolation --require-hashes -r $< \
	    -d $(CMSIS)
	@tar xzf $(CMSIS)/cmsisdsp-*.tar.gz --strip-components=1 -C $(CMSIS)
	@touch $@

$(B)/bench/cortex-%.elf: tests/bench/cortex.c $(ESTIMATOR_SOURCES) $(wildcard lib/*.h lib/*/*.h) \
    $(wildcard port/mps2/*) $(CMSIS)/Include/arm_math.h | $(KISSFFT_DIR)/kiss_fft.h
	@mkdir -p $(@D)/cortex-$*
	@echo "CC $@"
	@for source in $(KISSFFT_DIR)/kiss_fft.c $(CMSIS_SOURCES); do \
	    $(ARM_CC) $(MPS2_CPU_$*) -O2 -mthumb -ffunction-sections -fdata-sections -w $(DEFINE) \
	    $(KISSFFT_TARGET) $(CMSIS_INCLUDE) -c $$source \
	    -o $(@D)/cortex-$*/$$(basename $$source .c).o; done
	@$(call mps2_link,$*,$@,$< $(ESTIMATOR_SOURCES) $(@D)/cortex-$*/*.o,$(CORTEX_INCLUDE) \
	    $(CMSIS_INCLUDE) -DWITH_CMSIS) -lm

# Objects of the estimator alone as a product would build them, for their size.
$(B)/bench/size-%/stamp: $(ESTIMATOR_SOURCES) $(wildcard lib/*.h lib/*/*.h) | $(KISSFFT_DIR)/kiss_fft.h
	@mkdir -p $(@D)
	@for source in $(KISSFFT_DIR)/kiss_fft.c $(ESTIMATOR_SOURCES); do \
	    $(ARM_CC) $(MPS2_CPU_$*) -Os -mthumb -ffunction-sections -std=gnu99 -w $(KISSFFT_TARGET) $(CORTEX_INCLUDE) \
	    -c $$source -o $(@D)/$$(basename $$source .c).o; done
	@touch $@

$(B)/bench/cortex-%.txt: $(B)/bench/cortex-%.elf
	@$(call mps2_run,$*,$<,) >$@

CORTEX_CORES := m4f m0plus
bench-cortex: setup-test $(CORTEX_CORES:%=$(B)/bench/cortex-%.txt) \
    $(CORTEX_CORES:%=$(B)/bench/size-%/stamp)
	@$(PY) tests/bench/cortex.py $(B)/bench/cortex.md \
	    Cortex-M4=$(B)/bench/cortex-m4f.txt=$(B)/bench/size-m4f \
	    Cortex-M0+=$(B)/bench/cortex-m0plus.txt=$(B)/bench/size-m0plus

# --- no drift: a short run in the tests, 1e9 rows in the benchmark --------------------------------
FAST_FORWARD := $(B)/bench/fast_forward
$(FAST_FORWARD): tests/proofs/fast_forward.c lib/signal/sway_spectrum.c \
    lib/signal/sway_ring.c lib/arithmetic/sway_real.c $(wildcard lib/*.h lib/*/*.h)
	@mkdir -p $(@D)
	@gcc -std=c99 -Wall -Wextra -O2 -DSWAY_CHANNELS=4 -Ilib $(filter %.c,$^) -o $@

.PHONY: bench-drift
bench-drift: $(B)/bench/drift.txt
	@cat $<
$(B)/bench/drift.txt: $(FAST_FORWARD)
	@$< 1000000000 >$@
.PHONY: drift-quick
checks: drift-quick
drift-quick: $(FAST_FORWARD)
	@$< 2000000

# --- proofs of the bounds: needs frama-c-base, why3 and z3 (`why3 config detect` once) ------------
PROVE := frama-c -wp -wp-rte -wp-prover z3 -wp-timeout 60 -wp-fct fresh_sum,slide,block_product
PROOF_ROWS ?= 64 128 256 512 1024 2048 4096 8192
.PHONY: proofs proofs-quick
proofs:
	@mkdir -p $(B)/proofs; test -e ~/.why3.conf || why3 config detect >/dev/null
	@for rows in $(PROOF_ROWS); do \
	    $(PROVE) -cpp-extra-args="-Ilib -DSWAY_RING_SAMPLES=$$rows" tests/proofs/sliding_sum.c \
	    >$(B)/proofs/$$rows.log 2>&1 || { cat $(B)/proofs/$$rows.log; exit 1; }; \
	    awk -v rows=$$rows '/Proved goals/{split($$0,g,/[:\/]/); \
	    print "ring of " rows " rows:" g[2] "/" g[3] " goals proved"; bad = g[2]+0 != g[3]+0} \
	    END{exit bad}' $(B)/proofs/$$rows.log || { cat $(B)/proofs/$$rows.log; exit 1; }; done
checks: proofs-quick
proofs-quick:
	@if command -v frama-c >/dev/null && command -v why3 >/dev/null && command -v z3 >/dev/null; then \
	    $(MAKE) --no-print-directory -s proofs PROOF_ROWS=512; \
	    else echo "proofs: not run, frama-c why3 z3 are not all here"; fi
