# swaywatchd, the daemon.
SWAYWATCHD := $(B)/swaywatchd
SWAYWATCHD_SOURCES := $(wildcard port/socketcan/*.c port/xcp/*.c port/*.c) port/replay/candump.c
$(SWAYWATCHD): $(SWAYWATCHD_SOURCES) $(wildcard port/socketcan/*.h port/xcp/*.h port/*.h port/replay/*.h) \
    $(B)/gcc/libsway.a
	@echo "CC $@"
	@gcc -std=c99 -D_GNU_SOURCE -Wall -Wextra -Wconversion -Wshadow -Werror -O2 -g $(DEFINE) \
	    $(INCLUDE) -Iport -Iport/xcp -Iport/replay $(SWAYWATCHD_SOURCES) $(B)/gcc/libsway.a -lm -o $@

quick: $(SWAYWATCHD)
checks: $(SWAYWATCHD)
