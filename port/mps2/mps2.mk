# Building and running an image for an emulated Cortex-M. Include it, then use
#   $(call mps2_link,CORE,IMAGE.elf,SOURCES,FLAGS)   one recipe line: compiles and links
#   $(call mps2_run,CORE,IMAGE.elf,ARGUMENTS)        one recipe line: runs it, counting instructions
# CORE: m0plus (ARMv6-M code, on the M3), m3, m4f, m7.
comma := ,
empty :=
space := $(empty) $(empty)
MPS2_DIR := $(patsubst %/,%,$(dir $(lastword $(MAKEFILE_LIST))))
ARM_CC ?= arm-none-eabi-gcc

MPS2_CPU_m0plus := -mcpu=cortex-m0plus
MPS2_CPU_m3 := -mcpu=cortex-m3
MPS2_CPU_m4f := -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard
MPS2_CPU_m7 := -mcpu=cortex-m7 -mfpu=fpv5-d16 -mfloat-abi=hard
MPS2_MACHINE_m0plus := mps2-an385
MPS2_MACHINE_m3 := mps2-an385
MPS2_MACHINE_m4f := mps2-an386
MPS2_MACHINE_m7 := mps2-an500

MPS2_FLASH ?= 4M
MPS2_RAM ?= 4M
MPS2_STACK ?= 8K
MPS2_START := $(addprefix $(MPS2_DIR)/,../cortex_m/startup.c bench.c ../semihosting/semihosting.c)
MPS2_WARNINGS := -std=c99 -pedantic -Wall -Wextra -Wconversion -Wshadow -Werror
MPS2_FLAGS := -O2 -g -mthumb -ffunction-sections -fdata-sections $(MPS2_WARNINGS) -I$(MPS2_DIR) \
	-I$(MPS2_DIR)/../semihosting -I$(MPS2_DIR)/../cortex_m
MPS2_LINK = -nostartfiles --specs=nano.specs -Wl,--gc-sections -T $(MPS2_DIR)/mps2.ld \
	-Wl,--defsym=flash_size=$(MPS2_FLASH),--defsym=ram_size=$(MPS2_RAM) \
	-Wl,--defsym=stack_size=$(MPS2_STACK)

mps2_link = $(ARM_CC) $(MPS2_CPU_$(1)) $(MPS2_FLAGS) $(4) $(MPS2_START) $(3) $(MPS2_LINK) -o $(2)
mps2_run = timeout 600 qemu-system-arm -M $(MPS2_MACHINE_$(1)) -nographic -monitor none \
	-serial none -icount shift=8 -semihosting-config enable=on,target=native,arg=$(subst $(space),$(comma)arg=,$(3)) \
	-kernel $(2)
