# The A2L file of a program with sway_xcp: make build/swaywatchd.a2l (or another .elf of build/).
$(B)/parameters.txt: $(B)/firmware/make_block
	@$< --list >$@
$(B)/swaywatchd.a2l: $(B)/swaywatchd $(B)/parameters.txt port/xcp/make_a2l.py | $(VENV)/stamp-test
	@$(PY) port/xcp/make_a2l.py $< $(B)/parameters.txt $@
$(B)/%.a2l: $(B)/%.elf $(B)/parameters.txt port/xcp/make_a2l.py | $(VENV)/stamp-test
	@$(PY) port/xcp/make_a2l.py $< $(B)/parameters.txt $@
