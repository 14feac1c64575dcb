# make hil: the daemon on a real kernel CAN, faults included (tests/hil).
SYSTEM_TEST += /usr/bin/linux.uml=user-mode-linux /bin/busybox=busybox-static ip=iproute2 \
    tc=iproute2 taskset=util-linux qemu-system-x86_64=qemu-system-x86 cpio=cpio

BUS_LOAD := $(B)/bus_load
$(BUS_LOAD): tests/hil/bus_load.c $(B)/gcc/libsway.a
	@echo "CC $@"
	@gcc -std=c99 -D_GNU_SOURCE -Wall -Wextra -O2 -g $(DEFINE) $(INCLUDE) $< $(B)/gcc/libsway.a \
	    -lm -o $@

# For the guest kernel's process, see there.
UML_PTRACE := $(B)/uml_ptrace.so
$(UML_PTRACE): tests/hil/uml_ptrace.c
	@echo "CC $@"
	@gcc $(WARN) -O2 -fPIC -shared $< -o $@

# Beside vcan: two emulated controllers under Linux's own driver, in a Debian kernel of their own.
KERNEL_DIR ?= $(B)/third_party/kernel
.PHONY: hil hil-bench hil-controllers
hil-controllers: setup-test $(SWAYWATCHD) $(BUS_LOAD)
	@if [ -d $(KERNEL_DIR)/boot ] || tests/tools/fetch-kernel $(KERNEL_DIR); then \
	    $(PY) tests/hil/controllers.py $(KERNEL_DIR); \
	    else echo "hil-controllers: not run, no Debian kernel image could be fetched"; fi

hil: setup-test $(SWAYWATCHD) $(B)/swaywatchd.a2l $(BUS_LOAD) $(UML_PTRACE)
	@tests/hil/run -q

# The long measurements: 8,000 frames/s over 60 s, latency.
hil-bench: setup-test $(SWAYWATCHD) $(BUS_LOAD) $(UML_PTRACE)
	@HIL_SECONDS=60 tests/hil/run -q -k "load or latency or rate"

# One after the other: each has its own idea of time.
hil-checks: hil
	@$(MAKE) --no-print-directory hil-controllers
bench:: hil-bench
