# The core as an FMU of FMI 2 and 3: make fmu. FMI_DIR: the standard's headers, else those that FMPy
# brings with it.
FMI_DIR ?= $(firstword $(wildcard $(VENV)/lib/python3*/site-packages/fmpy/c-code))
FMU_LIB := $(B)/fmu/libsway.a
FMU_OBJECTS := $(LIB_NAMES:%=$(B)/fmu/lib/%.o) $(B)/fmu/codec.o $(B)/fmu/kiss_fft.o
$(B)/fmu/lib/%.o: lib/%.c | $(KISSFFT_DIR)/kiss_fft.h $(CODEC).c
	@mkdir -p $(@D)
	@gcc $(WARN) -O2 -fPIC -fvisibility=hidden $(DEFINE) $(INCLUDE) -MMD -MP -c $< -o $@
$(B)/fmu/codec.o: $(CODEC).c
	@mkdir -p $(@D)
	@gcc -std=c99 -w -O2 -fPIC -fvisibility=hidden -c $< -o $@
$(B)/fmu/kiss_fft.o: $(KISSFFT_DIR)/kiss_fft.h
	@mkdir -p $(@D)
	@gcc -std=gnu99 -w -O2 -fPIC -fvisibility=hidden $(DEFINE) $(KISSFFT_FLAGS) -c $(KISSFFT_DIR)/kiss_fft.c -o $@
-include $(wildcard $(B)/fmu/lib/*/*.d)
$(FMU_LIB): $(FMU_OBJECTS)
	@rm -f $@ && ar rcs $@ $^
$(B)/fmu/list.txt: port/fmi/fmu_list.c port/fmi/fmu_model.c port/fmi/fmu_model.h $(FMU_LIB)
	@gcc $(WARN) -O2 -Ilib -Iport/fmi port/fmi/fmu_list.c port/fmi/fmu_model.c $(FMU_LIB) -lm -o $(B)/fmu/list
	@$(B)/fmu/list >$@
$(B)/fmu/swaywatch_fmi%.fmu: $(B)/fmu/list.txt $(wildcard port/fmi/*) | $(VENV)/stamp-test
	@echo "packing $@"
	@$(PY) port/fmi/make_fmu.py $* $(FMI_DIR) $< $(FMU_LIB) $@

.PHONY: fmu
fmu: $(B)/fmu/swaywatch_fmi2.fmu $(B)/fmu/swaywatch_fmi3.fmu
