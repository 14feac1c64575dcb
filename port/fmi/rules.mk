# Core and plant as FMUs of FMI 2 and 3: make fmu. FMI_DIR: the standard's headers, else those that
# FMPy brings with it. FMU_VEHICLE: the combination that the plant starts with.
FMI_DIR ?= $(firstword $(wildcard $(VENV)/lib/python3*/site-packages/fmpy/c-code))
FMU_VEHICLE ?= tests/data/practice/p03/vehicle.toml
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
PLANT_DIR := sim_host/src/swaywatch/plant
# As sim_host/plant_build.py builds it, but for every machine alike.
PLANT_FLAGS := '-Dtarget_clones(...)=' -O1 -std=gnu99 -w -Wno-psabi -fno-math-errno -fno-trapping-math -ffp-contract=fast
FMU_CORE := -Ilib port/fmi/fmu_core.c $(FMU_LIB)
FMU_PLANT := -I$(B)/fmu -I$(PLANT_DIR) port/fmi/fmu_plant.c $(B)/fmu/plant_lanes.o
$(B)/fmu/plant_lanes.o: $(wildcard $(PLANT_DIR)/plant_*.[ch])
	@mkdir -p $(@D)
	@gcc $(PLANT_FLAGS) -fPIC -fvisibility=hidden -c $(PLANT_DIR)/plant_lanes.c -o $@
$(B)/fmu/plant_table.h: port/fmi/plant_table.py $(FMU_VEHICLE) $(wildcard $(PLANT_DIR)/*.py $(PLANT_DIR)/../models/*.py) | $(VENV)/stamp-package
	@mkdir -p $(@D)
	@$(PY) port/fmi/plant_table.py $(FMU_VEHICLE) $@
$(B)/fmu/core.txt: port/fmi/fmu_core.c $(FMU_LIB)
$(B)/fmu/plant.txt: port/fmi/fmu_plant.c $(B)/fmu/plant_table.h $(B)/fmu/plant_lanes.o
$(B)/fmu/core.txt: FMU_MODEL = $(FMU_CORE)
$(B)/fmu/plant.txt: FMU_MODEL = $(FMU_PLANT)
$(B)/fmu/%.txt: port/fmi/fmu_list.c port/fmi/fmu_model.h
	@mkdir -p $(@D)
	@gcc $(WARN) -O2 -Iport/fmi port/fmi/fmu_list.c $(FMU_MODEL) -lm -o $(B)/fmu/list_$*
	@$(B)/fmu/list_$* >$@
$(B)/fmu/swaywatch_fmi%.fmu: $(B)/fmu/core.txt $(wildcard port/fmi/*) | $(VENV)/stamp-test
	@echo "packing $@"
	@$(PY) port/fmi/make_fmu.py $* core $(FMI_DIR) $< $@ $(FMU_CORE)
$(B)/fmu/swaywatch_plant_fmi%.fmu: $(B)/fmu/plant.txt $(wildcard port/fmi/*) | $(VENV)/stamp-test
	@echo "packing $@"
	@$(PY) port/fmi/make_fmu.py $* plant $(FMI_DIR) $< $@ $(FMU_PLANT)

FMUS := $(foreach v,2 3,$(B)/fmu/swaywatch_fmi$(v).fmu $(B)/fmu/swaywatch_plant_fmi$(v).fmu)
.PHONY: fmu
fmu: $(FMUS)

# What checkers of others say of them. VDMCheck 2 comes from Maven Central, by SHA-256; VDMCHECK3,
# FMUCHECK and FMUSIM say where the programs of their GitHub releases are (else: said to be left out).
VDMCHECK3 ?=
FMUCHECK ?=
FMUSIM ?=
.PHONY: fmu-check
fmu-check: $(FMUS)
	@tests/tools/need java=default-jre-headless mvn=maven || true
	@$(PY) tests/tools/fmu_check.py $^ --cache $(B)/third_party/vdmcheck \
	    --vdmcheck3 "$(VDMCHECK3)" --fmucheck "$(FMUCHECK)" --fmusim "$(FMUSIM)"
