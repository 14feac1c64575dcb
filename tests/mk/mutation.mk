# make mutation: wrong tokens in lib/ and port/ must make a unit test fail. A sample of each file,
# always the same; MUTATION_SAMPLE=0 tries all of them. At low priority: it takes a while.
MUTATION_SAMPLE ?= 10
MUTATE_PORT = :$(subst $(eval ) ,$(comma),$(PORT_COMMON))
MUTATE ?= $(addprefix sway_,alarm:test_alarm core:test_core e2e:test_e2e frames:test_frames \
    $(patsubst %,%:test_line_bits$(comma)test_line,break fit line line_read residual seek track) \
    grid:test_grid identify:test_identify margin:test_margin node:test_node \
    phasor:test_identify publish:test_core real:test_real,test_line_bits \
    ring:test_grid,test_line_bits spectrum:test_spectrum stm:test_stm vehicle:test_core) \
    $(patsubst %,port/sway_%:test_ecu$(MUTATE_PORT),block checks ecu store) \
    port/sway_bit_timing:test_stm32g4$(MUTATE_PORT)$(comma)$(subst $(eval ) ,$(comma),$(PORT_SOURCES_stm32g4)) \
    port/can:test_zynqmp_can$(MUTATE_PORT)$(comma)$(PORT_SOURCES_zynqmp_can)
.PHONY: mutation
mutation: setup-test $(B)/gcc/libsway.a $(UNITY_DIR)/unity.h
	@nice -n 5 $(PY) tests/mutation/mutate.py $(MUTATE) --sample $(MUTATION_SAMPLE) \
	    --report $(B)/bench/mutation.md
