# Firmware: the same ECU program built for seven machines and run on all of them.
#   make firmware-test   answers byte for byte the same; drivers; faults; sizes (part of `make test`)
#   make firmware-bench  the same with whole recordings, and the long soak (part of `make bench`)
#   make firmware        the images alone; build/firmware/table.md is README's table
SYSTEM_TEST += arm-none-eabi-gcc=gcc-arm-none-eabi \
    /usr/lib/arm-none-eabi/include/string.h=libnewlib-arm-none-eabi \
    qemu-system-arm=qemu-system-arm qemu-system-aarch64=qemu-system-arm \
    qemu-mips-static=qemu-user-static mips-linux-gnu-gcc=gcc-mips-linux-gnu \
    /usr/mips-linux-gnu/include/bits/libc-header-start.h=libc6-dev-mips-cross \
    llvm-objcopy=llvm

FW := $(B)/firmware
FW_INCLUDE := -Ilib -Iport -Iport/replay -Iport/semihosting -I$(B)/codec -I$(KISSFFT_DIR)
# kissfft is never asked to allocate: without its allocator there is no heap to link.
FW_DEFINE := -DFIXED_POINT=32 -D'KISS_FFT_MALLOC(size)=NULL' -D'KISS_FFT_FREE(pointer)=((void)(pointer))'
FW_WARN := -std=c99 -pedantic -Wall -Wextra -Wconversion -Wshadow -Werror
FW_ECU := $(addprefix port/sway_,ecu.c access.c siphash.c block.c checks.c remember.c store.c)
FW_REPLAY := port/replay/candump.c port/replay/pages.c port/replay/replay.c
FW_EMBEDDED := -Os -g -ffunction-sections -fdata-sections -fstack-usage

# NAME: compiler, flags, sources beyond lib/ and the ECU, how to link
FW_CORTEX_M := port/cortex_m/startup.c port/cortex_m/memory.S port/mps2/bench.c port/mps2/figures.c port/mps2/main.c \
    port/semihosting/semihosting.c
FW_CORTEX_M_INCLUDE := -mthumb -Iport/cortex_m -Iport/mps2
FW_LINK_M = -nostartfiles --specs=nano.specs -Wl,--gc-sections -T port/mps2/mps2.ld \
    -Wl,--defsym=flash_size=96K,--defsym=ram_size=$(or $(FW_RAM_$(1)),80K),--defsym=stack_size=$(or $(FW_STACK_$(1)),4096)

FW_CC_x86 := gcc
FW_FLAGS_x86 := -O2 -g -D_POSIX_C_SOURCE=200809L
FW_SOURCES_x86 := $(FW_REPLAY) port/replay/main_posix.c

FW_CC_mips := mips-linux-gnu-gcc
FW_FLAGS_mips := -O2 -g -D_POSIX_C_SOURCE=200809L
FW_SOURCES_mips := $(FW_REPLAY) port/replay/main_posix.c
FW_LINK_mips := -static -lm
FW_LINK_x86 := -lm

# The trailer from the car's own sensors (SWAY_TRAILER) does not fit into 64 KiB of flash and RAM
# beside the rest, nor does the supervision of the relations (SWAY_SUPERVISION); the M7 and the hosts
# have both, the R5 (128 KiB for all) the first. A car's own bus (SWAY_MAP) is left out with them.
FW_LEAN := -DSWAY_TRAILER=0 -DSWAY_SUPERVISION=0 -DSWAY_MAP=0
FW_CPU_m0plus := -mcpu=cortex-m0plus $(FW_LEAN)
FW_CPU_m3 := -mcpu=cortex-m3 $(FW_LEAN)
FW_CPU_m4f := $(FW_LEAN) -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard
# The M7 is the whole core within 96 KiB of flash. Like the R5 it has no memory to keep a trailer in
# (SWAY_REMEMBER); XCP is on the M3.
FW_CPU_m7 := -DSWAY_REMEMBER=0 -mcpu=cortex-m7 -mfpu=fpv5-d16 -mfloat-abi=hard
# The small one: steering, yaw rate and acceleration of the car, yaw rate of the trailer; rows at
# 50 Hz, the last 2.5 s of them. On the host, too, to compare with.
FW_SIZES_small := -DSWAY_TRAILER=0 -DSWAY_MAP=0 -DSWAY_CHANNELS=4 -DSWAY_RING_SAMPLES=128 -DSWAY_FIT_BLOCKS=32 -DSWAY_GRID_ROWS=8
FW_CPU_small := -mcpu=cortex-m0plus $(FW_SIZES_small) -DMAILBOX_FRAMES=8
FW_CC_x86small := gcc
FW_FLAGS_x86small := $(FW_FLAGS_x86) $(FW_SIZES_small)
FW_SOURCES_x86small := $(FW_SOURCES_x86)
FW_LINK_x86small := $(FW_LINK_x86)
FW_RAM_small := 64K
FW_RAM_m7 := 96K
FW_STACK_small := 2560
FW_M := m0plus m3 m4f m7 small
$(foreach t,$(FW_M),$(eval FW_CC_$t := arm-none-eabi-gcc)\
    $(eval FW_FLAGS_$t := $(FW_CPU_$t) $(FW_CORTEX_M_INCLUDE) $(FW_EMBEDDED))\
    $(eval FW_SOURCES_$t := $(FW_REPLAY) $(FW_CORTEX_M))\
    $(eval FW_START_$t := code_start)$(eval FW_LINK_$t = $(call FW_LINK_M,$t)))

FW_CC_r5 := arm-none-eabi-gcc
FW_START_r5 := image_start
FW_FLAGS_r5 := -DSWAY_SUPERVISION=0 -DSWAY_REMEMBER=0 -mcpu=cortex-r5 -mthumb -mfloat-abi=soft -Iport/zynqmp_r5 $(FW_EMBEDDED)
FW_SOURCES_r5 := $(FW_REPLAY) port/sway_bit_timing.c port/can.c port/zynqmp_r5/startup.S port/zynqmp_r5/r5.c \
    port/zynqmp_r5/can.c port/zynqmp_r5/main.c port/semihosting/semihosting.c
# These two can be measured and calibrated over XCP; they are of both byte orders.
FW_XCP := mips m3
$(foreach t,$(FW_XCP),$(eval FW_FLAGS_$t += -DREPLAY_XCP=1 -Iport/xcp)\
    $(eval FW_SOURCES_$t += port/xcp/sway_xcp.c port/xcp/sway_xcp_daq.c))
FW_LINK_r5 := -nostartfiles --specs=nano.specs -Wl,--gc-sections -T port/zynqmp_r5/zynqmp_r5.ld

FW_TARGETS := x86 x86small mips $(FW_M) r5
FW_COMMON := $(LIB_NAMES:%=lib/%.c) $(FW_ECU)

# The search transforms 64 points, three stages of radix 4: without the other stages kissfft takes
# 1 KiB of flash instead of 4.
$(FW)/kiss_fft.c: $(KISSFFT_DIR)/kiss_fft.h
	@mkdir -p $(@D)
	@sed -E '/(case [235]|default): kf_bfly/d' $(KISSFFT_DIR)/kiss_fft.c >$@

# $(1): target. Generated and foreign code is compiled without the warnings.
define firmware_target
FW_OBJECTS_$(1) := $$(patsubst %,$(FW)/$(1)/%.o,$$(basename $$(FW_COMMON) $$(FW_SOURCES_$(1)))) \
    $(FW)/$(1)/codec.o $(FW)/$(1)/kiss_fft.o
$(FW)/$(1)/%.o: %.c tests/mk/firmware.mk | $(KISSFFT_DIR)/kiss_fft.h $(CODEC).c
	@mkdir -p $$(@D)
	@$$(FW_CC_$(1)) $$(FW_WARN) $$(FW_FLAGS_$(1)) $$(FW_DEFINE) $$(FW_INCLUDE) -MMD -MP -c $$< -o $$@
$(FW)/$(1)/%.o: %.S tests/mk/firmware.mk
	@mkdir -p $$(@D)
	@$$(FW_CC_$(1)) $$(FW_FLAGS_$(1)) -c $$< -o $$@
$(FW)/$(1)/codec.o: $(CODEC).c
	@mkdir -p $$(@D)
	@$$(FW_CC_$(1)) -std=c99 -w $$(FW_FLAGS_$(1)) -c $$< -o $$@
$(FW)/$(1)/kiss_fft.o: $(FW)/kiss_fft.c
	@mkdir -p $$(@D)
	@$$(FW_CC_$(1)) -std=gnu99 -w -DNDEBUG $$(FW_FLAGS_$(1)) $$(FW_DEFINE) -I$(KISSFFT_DIR) -c $$< -o $$@
$(FW)/replay_$(1).elf: $$(FW_OBJECTS_$(1)) $(wildcard port/*/*.ld)
	@echo "linking $$@"
	@$$(FW_CC_$(1)) $$(FW_FLAGS_$(1)) $$(FW_OBJECTS_$(1)) $$(FW_LINK_$(1)) -Wl,-Map=$$@.map -o $$@
	@$$(if $$(FW_START_$(1)),python3 tests/firmware/seal.py arm-none-eabi-objcopy $$@ $$(FW_START_$(1)))
-include $$(FW_OBJECTS_$(1):.o=.d)
endef
$(foreach t,$(FW_TARGETS),$(eval $(call firmware_target,$(t))))

# The ECU alone, for the table of sizes, optimised as a whole, without what makes code
# longer (each tried alone): an eighth less flash.
FW_ECU_SOURCES := $(FW_COMMON) port/cortex_m/startup.c port/cortex_m/memory.S port/mps2/mailbox.c $(CODEC).c \
    $(FW)/kiss_fft.c
FW_LTO := -flto=1 -fno-inline-small-functions -fno-ipa-cp -fno-ipa-sra -fno-tree-ch -fno-thread-jumps \
    -fno-tree-forwprop -fno-tree-dominator-opts -fno-tree-loop-im -fno-move-loop-invariants \
    -fno-ipa-icf -DNDEBUG -w
$(FW)/ecu_%.elf: $(FW_ECU_SOURCES) tests/mk/firmware.mk $(wildcard lib/*.h lib/*/*.h port/*.h)
	@echo "linking $@"
	@mkdir -p $(@D)
	@$(FW_CC_$*) -std=gnu99 $(filter-out -fstack-usage,$(FW_FLAGS_$*)) $(FW_LTO) $(FW_DEFINE) $(FW_INCLUDE) $(FW_ECU_SOURCES) \
	    $(FW_LINK_$*) -o $@ 2>/dev/null
	@python3 tests/firmware/seal.py arm-none-eabi-objcopy $@ code_start
FW_ECUS := $(foreach t,m0plus m4f small,$(FW)/ecu_$t.elf)

# The processor that the emulator starts first, which starts the R5.
$(FW)/a53.bin: port/zynqmp_r5/a53_start.S
	@mkdir -p $(@D)
	@clang --target=aarch64-none-elf -c $< -o $(FW)/a53.o
	@llvm-objcopy -O binary -j .text $(FW)/a53.o $@

$(FW)/make_block: port/replay/make_block.c port/sway_block.c port/vehicle_file.c port/names.c $(B)/gcc/libsway.a
	@mkdir -p $(@D)
	@gcc $(FW_WARN) -O2 $(FW_INCLUDE) $(filter %.c,$^) $(B)/gcc/libsway.a -lm -o $@

.PHONY: firmware firmware-test firmware-bench firmware-built
firmware: $(FW_TARGETS:%=$(FW)/replay_%.elf) $(FW)/replay_stm32g4.elf $(FW_ECUS) $(FW)/a53.bin $(FW)/make_block

# --- recordings and parameter blocks --------------------------------------------------------------
# Three practice recordings as frames of dbc/swaywatch.dbc; for the tests their first 15 s.
FW_CASES := p01-run1 p01-run2 p03-run1
FW_SOURCE_p01-run1 := tests/data/practice/p01/run1.blf
FW_SOURCE_p01-run2 := tests/data/practice/p01/run2.blf
FW_SOURCE_p03-run1 := tests/data/practice/p03/run1.asc
FW_SECONDS ?= 15
define firmware_case
$(FW)/cases/$(1).log: $(FW_SOURCE_$(1)) lib/bus/sway_e2e.c dbc/swaywatch.dbc | $(VENV)/stamp-package
	@mkdir -p $$(@D)
	@$(VENV)/bin/swaywatch convert $$< --signals $(dir $(FW_SOURCE_$(1)))signals.toml --to $$@
$(FW)/cases/$(1).short.log: $(FW)/cases/$(1).log
	@awk -v limit=$(FW_SECONDS) '{ t = substr($$$$1, 2) + 0 } NR == 1 { t0 = t } t - t0 < limit' \
	    $$< >$$@
$(FW)/cases/$(1).block: $(dir $(FW_SOURCE_$(1)))vehicle.toml $(FW)/make_block
	@mkdir -p $$(@D)
	@$(FW)/make_block $$< $$@ car.lateral_acceleration_position=-1.383
$(FW)/cases/$(1).small.block: $(dir $(FW_SOURCE_$(1)))vehicle.toml $(FW)/make_block
	@mkdir -p $$(@D)
	@$(FW)/make_block $$< $$@ sample_period_us=20000 car.lateral_acceleration_position=-1.383
FW_INPUTS += $(FW)/cases/$(1).small.block $(FW)/cases/$(1).log $(FW)/cases/$(1).short.log $(FW)/cases/$(1).block
endef
$(foreach c,$(FW_CASES),$(eval $(call firmware_case,$(c))))

# --- tests ----------------------------------------------------------------------------------------
# The functions of memory.S, which is Thumb code that Linux on ARM runs, too.
FW_MEMORY := $(FW)/memory_functions.elf
$(FW_MEMORY): tests/firmware/memory.c port/cortex_m/memory.S
	@mkdir -p $(@D)
	@arm-none-eabi-gcc -mcpu=cortex-m0plus -Wall -Wextra -Werror -std=c11 -O1 -ffreestanding \
	    -fno-tree-loop-distribute-patterns -nostdlib -Dmemcpy=tested_memcpy -Dmemset=tested_memset \
	    -Dmemcmp=tested_memcmp $^ -o $@

FW_SHORT := $(FW_CASES:%=$(FW)/cases/%.short.log)
FW_WHOLE := $(FW_CASES:%=$(FW)/cases/%.log)
# Linking the images is most of the work: side by side, here or in the make that asked for it. What
# others build too is there before.
firmware-built: setup-test $(CODEC).c $(FW)/kiss_fft.c $(FW)/make_block $(B)/gcc/libsway.a
	@$(MAKE) --no-print-directory $(if $(findstring jobserver,$(MAKEFLAGS)),,-j$(shell nproc)) firmware

firmware-test: setup-test firmware-built $(FW)/soak $(FW_SHORT) $(FW_CASES:%=$(FW)/cases/%.block) \
    $(FW_CASES:%=$(FW)/cases/%.small.block) $(FW_MEMORY) board-images
	@qemu-arm-static $(FW_MEMORY) || { echo "port/cortex_m/memory.S is wrong"; exit 1; }
	@$(PY) tests/firmware/boards.py $(FW)
	@$(PY) tests/firmware/identical.py $(FW) $(FW_SHORT)
	@$(PY) tests/firmware/faults.py $(FW) $(firstword $(FW_SHORT))
	@$(PY) tests/firmware/report.py $(FW) $(firstword $(FW_SHORT))
	@$(FW)/soak 14 $(FW)/soak-short.md
	@$(PY) tests/firmware/soak_machines.py $(FW)

firmware-bench: setup-test firmware $(FW)/soak $(FW_WHOLE) $(FW_CASES:%=$(FW)/cases/%.block)
	@$(PY) tests/firmware/identical.py $(FW) $(FW_WHOLE)
	@nice -n 19 $(FW)/soak 600 $(FW)/soak.md

# Driving with a fault a minute: each kind once in the tests; ten hours by `make soak`.
$(FW)/soak: tests/firmware/soak.c $(FW_ECU) port/replay/candump.c $(B)/gcc/libsway.a
	@mkdir -p $(@D)
	@gcc -std=c99 -Wall -Wextra -Wconversion -Werror -O2 $(FW_DEFINE) $(FW_INCLUDE) $(filter %.c,$^) \
	    $(B)/gcc/libsway.a -lm -o $@

.PHONY: soak
soak: setup-test $(FW)/soak
	@nice -n 19 $(FW)/soak 600 $(FW)/soak.md
	@cat $(FW)/soak.md

bench:: firmware-bench
