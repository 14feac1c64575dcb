# Ports: their drivers on the host against models of the registers, and the image for a board.
#   make port-test     unit tests of port/ (part of `make quick` and `make test`)
#   make board-images  .elf, .hex and .bin for the boards that are not emulated here
PORT_INCLUDE := -Iport -Iport/cortex_m -Itests/port -Ilib -I$(B)/codec -I$(KISSFFT_DIR) -I$(UNITY_DIR)
PORT_FLAGS := -std=c99 -Wall -Wextra -Wshadow -Werror -D_GNU_SOURCE -DUNITY_SUPPORT_64 \
    -DSWAY_REGISTER_MODEL $(CFLAGS_sanitize) $(DEFINE)
PORT_COMMON := $(addprefix port/,sway_ecu.c sway_access.c sway_siphash.c sway_block.c \
    sway_remember.c sway_store.c sway_checks.c sway_bit_timing.c can.c)
PORT_STM32G4 := $(addprefix port/stm32g4/,board.c fdcan.c flash.c program.c)

PORT_TESTS := stm32g4 stm32g4_trailer zynqmp_can ecu ecu_access ecu_store ecu_trailer common xcp xcp_daq
PORT_SOURCES_xcp := port/xcp/sway_xcp.c port/xcp/sway_xcp_daq.c
PORT_INCLUDE_xcp := -Iport/xcp
PORT_SOURCES_xcp_daq := $(PORT_SOURCES_xcp)
PORT_INCLUDE_xcp_daq := $(PORT_INCLUDE_xcp)
PORT_SOURCES_stm32g4 := tests/port/model_stm32g4.c $(PORT_STM32G4)
PORT_SOURCES_stm32g4_trailer := $(PORT_SOURCES_stm32g4)
PORT_SOURCES_zynqmp_can := port/zynqmp_r5/can.c

# What all of them have in common is compiled once.
PORT_HEADERS := $(wildcard port/*.h port/*/*.h tests/port/*.h lib/*.h lib/*/*.h)
PORT_OBJECTS := $(PORT_COMMON:%.c=$(B)/port/%.o) $(B)/port/unity.o
$(B)/port/port/%.o: port/%.c $(PORT_HEADERS) $(CODEC).c | $(UNITY_DIR)/unity.h $(KISSFFT_DIR)/kiss_fft.h
	@mkdir -p $(@D)
	@gcc $(PORT_FLAGS) $(PORT_INCLUDE) -c $< -o $@
$(B)/port/unity.o: $(UNITY_DIR)/unity.h
	@mkdir -p $(@D)
	@gcc $(PORT_FLAGS) $(PORT_INCLUDE) -c $(UNITY_DIR)/unity.c -o $@
define port_test
$(B)/port/test_$(1): tests/port/test_$(1).c $$(PORT_SOURCES_$(1)) $(PORT_HEADERS) $(PORT_OBJECTS) \
    $(B)/sanitize/libsway.a
	@mkdir -p $$(@D)
	@echo "CC $$@"
	@gcc $$(PORT_FLAGS) $$(PORT_INCLUDE) $$(PORT_INCLUDE_$(1)) -o $$@ $$(filter %.c,$$^) \
	    $(PORT_OBJECTS) $(B)/sanitize/libsway.a -lm
endef
$(foreach t,$(PORT_TESTS),$(eval $(call port_test,$(t))))
PORT_INCLUDE_stm32g4 := -Iport/stm32g4
PORT_INCLUDE_stm32g4_trailer := $(PORT_INCLUDE_stm32g4)

.PHONY: port-test board-images
port-test: $(PORT_TESTS:%=$(B)/port/test_%)
	@status=0; for t in $^; do out=$$($$t 2>&1) || { status=1; echo "$$out"; }; \
	    echo "$${t#$(B)/}: $$(grep -E 'Tests [0-9]+ Failures' <<<"$$out" || tail -n 1 <<<"$$out")"; \
	    done; exit $$status
quick: port-test
checks: port-test

# --- NUCLEO-G474RE --------------------------------------------------------------------------------
BOARD_FLAGS := -std=gnu99 -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard -mthumb -Os -g \
    -ffunction-sections -fdata-sections -DMPU_FLASH_LOG2=18U
BOARD_SOURCES := $(LIB_NAMES:%=lib/%.c) $(PORT_COMMON) port/cortex_m/startup.c $(PORT_STM32G4) \
    port/stm32g4/main.c
$(FW)/sway_stm32g474re.elf: $(BOARD_SOURCES) $(CODEC).c port/stm32g4/stm32g474re.ld \
    $(wildcard port/cortex_m/* port/*.h port/stm32g4/*.h lib/*.h lib/*/*.h tests/firmware/seal.py) \
    | $(KISSFFT_DIR)/kiss_fft.h
	@mkdir -p $(FW)/stm32g474re
	@echo "linking $@"
	@cd $(FW)/stm32g474re && for source in $(abspath $(CODEC).c $(KISSFFT_DIR)/kiss_fft.c); do \
	    arm-none-eabi-gcc $(BOARD_FLAGS) -w -DNDEBUG $(FW_DEFINE) -c $$source; done
	@arm-none-eabi-gcc $(filter-out -std=gnu99,$(BOARD_FLAGS)) $(FW_WARN) $(FW_DEFINE) $(FW_INCLUDE) \
	    -Iport/cortex_m -Iport/stm32g4 $(BOARD_SOURCES) $(FW)/stm32g474re/*.o \
	    -nostartfiles --specs=nano.specs -Wl,--gc-sections -T port/stm32g4/stm32g474re.ld \
	    -Wl,-Map=$@.map -o $@
	@python3 tests/firmware/seal.py arm-none-eabi-objcopy $@ code_start
$(FW)/sway_stm32g474re.hex: $(FW)/sway_stm32g474re.elf
	@arm-none-eabi-objcopy -O ihex $< $@
$(FW)/sway_stm32g474re.bin: $(FW)/sway_stm32g474re.elf
	@arm-none-eabi-objcopy -O binary $< $@
board-images: $(FW)/sway_stm32g474re.elf $(FW)/sway_stm32g474re.hex $(FW)/sway_stm32g474re.bin

# Its program on the host, on the model, for `make firmware-test`.
$(FW)/replay_stm32g4.elf: tests/port/replay_stm32g4.c $(PORT_SOURCES_stm32g4) $(PORT_COMMON) \
    port/replay/candump.c $(wildcard port/*.h port/*/*.h tests/port/*.h) $(B)/gcc/libsway.a
	@mkdir -p $(@D)
	@echo "linking $@"
	@gcc -std=c99 -Wall -Wextra -Werror -O2 -DSWAY_REGISTER_MODEL $(DEFINE) $(PORT_INCLUDE) \
	    -Iport/stm32g4 -Iport/replay $(filter %.c,$^) $(B)/gcc/libsway.a -lm -o $@
