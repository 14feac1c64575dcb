# make mutation: wrong tokens in lib/ and port/ must make a unit test fail. A sample of each file,
# always the same; MUTATION_SAMPLE=0 tries all of them. At low priority: it takes a while.
MUTATION_SAMPLE ?= 10
MUTATE_PORT = :$(subst $(eval ) ,$(comma),$(PORT_COMMON))
MUTATE ?= $(addprefix sway_,$(foreach f,alarm core e2e frames grid identify margin node phasor \
    publish residual spectrum stm vehicle,$f:test_$f) \
    evidence:test_margin quantity:test_margin \
    $(patsubst %,%:test_line_bits$(comma)test_line,break fit line line_read search track) \
    real:test_real,test_line_bits int64:test_real ring:test_grid,test_line_bits) \
    $(patsubst %,port/sway_%:test_ecu$(MUTATE_PORT),access block ecu siphash store) \
    $(patsubst %,port/%:test_common$(MUTATE_PORT),can sway_bit_timing) \
    port/sway_checks:test_common$(comma)test_ecu$(MUTATE_PORT)
.PHONY: mutation
mutation: setup-test $(B)/gcc/libsway.a $(UNITY_DIR)/unity.h
	@nice -n 5 $(PY) tests/mutation/mutate.py $(MUTATE) --sample $(MUTATION_SAMPLE) \
	    --report $(B)/bench/mutation.md

# All of port/, not a sample: an hour.
.PHONY: mutation-port
mutation-port: setup-test $(B)/gcc/libsway.a $(UNITY_DIR)/unity.h
	@nice -n 10 $(PY) tests/mutation/mutate.py $(filter port/%,$(MUTATE)) --sample 0 \
	    --report $(B)/bench/mutation-port.md
