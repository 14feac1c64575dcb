# Attacks: fuzzers of everything that takes bytes from outside, and a campaign of faults.
#   make fuzz         FUZZ_SECONDS (60) of processor time for each of FUZZ (all); adds a row of each to
#                     tests/fuzz/RESULT.md; what is found is kept in build/fuzz
#   make fuzz-corpus  the corpora and some mutations of them by gcc's sanitizers (in `make test`)
FUZZERS := fuzz_node fuzz_ecu fuzz_xcp fuzz_files
FUZZ_PORT := $(PORT_COMMON) port/vehicle_file.c port/names.c port/socketcan/log_file.c port/replay/candump.c \
    $(PORT_SOURCES_xcp)
FUZZ_FLAGS := -std=c99 -Wall -Wextra -D_GNU_SOURCE -DUNITY_SUPPORT_64 $(DEFINE) $(INCLUDE) -Iport \
    -Iport/replay -Iport/socketcan -Iport/xcp -Itests/port -I$(UNITY_DIR)
FUZZ_RUNS ?= 150
FUZZ_NEEDS := tests/fuzz/fuzz.h tests/port/port_test.h $(FUZZ_PORT) \
    $(wildcard lib/*.h lib/*/*.h lib/*/*.c port/*.h port/*/*.h)

$(B)/fuzz/corpus_%: tests/fuzz/%.c tests/fuzz/corpus_run.c $(FUZZ_NEEDS) $(B)/sanitize/libsway.a \
    | $(UNITY_DIR)/unity.h
	@mkdir -p $(@D)
	@echo "CC $@"
	@gcc $(FUZZ_FLAGS) $(CFLAGS_sanitize) $< tests/fuzz/corpus_run.c $(FUZZ_PORT) \
	    $(UNITY_DIR)/unity.c $(B)/sanitize/libsway.a -lm -o $@

$(FUZZERS:%=$(B)/fuzz/libfuzzer_%): $(B)/fuzz/libfuzzer_%: tests/fuzz/%.c $(FUZZ_NEEDS) \
    | $(UNITY_DIR)/unity.h
	@mkdir -p $(@D)
	@echo "CC $@"
	@tests/tools/need /usr/lib/clang/14/lib/linux/libclang_rt.fuzzer-x86_64.a=libclang-rt-14-dev
	@clang $(FUZZ_FLAGS) -O1 -g -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all \
	    $< $(FUZZ_PORT) $(LIB_NAMES:%=lib/%.c) $(CODEC).c $(KISSFFT_FLAGS) $(KISSFFT_DIR)/kiss_fft.c \
	    $(UNITY_DIR)/unity.c -w -lm -o $@

# The estimator's need no port.
FUZZERS_CORE := fuzz_track fuzz_real
$(FUZZERS_CORE:%=$(B)/fuzz/libfuzzer_%): $(B)/fuzz/libfuzzer_%: tests/fuzz/%.c $(ESTIMATOR_SOURCES) \
    $(wildcard lib/*.h lib/*/*.h) | $(KISSFFT_DIR)/kiss_fft.h
	@mkdir -p $(@D)
	@echo "CC $@"
	@tests/tools/need /usr/lib/clang/14/lib/linux/libclang_rt.fuzzer-x86_64.a=libclang-rt-14-dev
	@clang -std=c99 -Wall -Wextra -O1 -g -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all \
	    -Wno-sign-compare $(DEFINE) $(INCLUDE) $< $(ESTIMATOR_SOURCES) $(KISSFFT_DIR)/kiss_fft.c -lm -o $@

FUZZ ?= $(FUZZERS_CORE) $(FUZZERS) fuzz_recordings
FUZZ_SECONDS ?= 60
.PHONY: fuzz fuzz-corpus
fuzz: setup-test $(patsubst %,$(B)/fuzz/libfuzzer_%,$(filter $(FUZZERS_CORE) $(FUZZERS),$(FUZZ)))
	@$(PY) tests/fuzz/run.py --seconds $(FUZZ_SECONDS) --build $(B)/fuzz --result tests/fuzz/RESULT.md $(FUZZ)

fuzz-corpus: $(FUZZERS:%=$(B)/fuzz/corpus_%)
	@for f in $(FUZZERS); do \
	    $(B)/fuzz/corpus_$$f $(FUZZ_RUNS) $$(find tests/fuzz/corpus/$$f -type f | sort) \
	    2>$(B)/fuzz/$$f.err || { tail -n 30 $(B)/fuzz/$$f.err; exit 1; }; done

checks: fuzz-corpus
# make fault-campaign: 10,000 faults of bus, sensors, time, power and logs, each in a drive of its
# own; build/bench/faults.md is the table. In the tests a few of each class.
CAMPAIGN := $(FW)/campaign
CAMPAIGN_SEED ?= 1
CAMPAIGN_FAULTS ?= 10000
$(CAMPAIGN): tests/firmware/campaign.c $(FUZZ_NEEDS) $(B)/gcc/libsway.a | $(UNITY_DIR)/unity.h
	@mkdir -p $(@D)
	@echo "CC $@"
	@gcc $(FUZZ_FLAGS) -Werror -Itests/fuzz -O2 -g $< $(FUZZ_PORT) $(UNITY_DIR)/unity.c \
	    $(B)/gcc/libsway.a -lm -o $@

.PHONY: fault-campaign
fault-campaign: setup-test $(CAMPAIGN)
	@mkdir -p $(B)/bench
	@nice -n 10 $(CAMPAIGN) $(CAMPAIGN_SEED) $(CAMPAIGN_FAULTS) $(B)/bench/faults.md \
	    || { cat $(B)/bench/faults.md; exit 1; }
	@cat $(B)/bench/faults.md

.PHONY: fault-campaign-quick
checks: fault-campaign-quick
fault-campaign-quick: $(CAMPAIGN)
	@$(CAMPAIGN) 2 115 $(FW)/campaign.md || { cat $(FW)/campaign.md; exit 1; }
