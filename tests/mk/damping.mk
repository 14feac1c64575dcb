# make bench-damping: swaywatch damping beside ERA, matrix pencil, log decrement and pyOMA2 on the
# same windows, then every promise of it with today's figure; DAMPING_RECORDINGS is the folder with
# real/, practice/, sealed/ and chrono/ (what is not there is left out, and said).
DAMPING_RECORDINGS ?= ../shared/recordings
PYOMA := $(B)/third_party/pyoma
.PHONY: bench-damping
$(PYOMA)/stamp: tests/bench/pyoma/requirements.txt | $(VENV)/stamp-run
	@echo "fetching pyOMA2"
	@$(PY) -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes --upgrade \
	    --target $(PYOMA) -r $< && touch $@

bench-damping: setup-test $(PYOMA)/stamp
	@OPENBLAS_NUM_THREADS=1 PYTHONPATH=$(PYOMA) $(PY) tests/bench/damping.py \
	    --bicycle $(DAMPING_RECORDINGS)/real/bicycle_weave --report $(B)/bench/damping.md
	@OPENBLAS_NUM_THREADS=1 PYTHONPATH=$(PYOMA) $(PY) tests/bench/damping_shown.py \
	    --recordings $(DAMPING_RECORDINGS) --report $(B)/bench/damping_shown.md
bench:: bench-damping

# make bench-iso9815: 300 simulated tests after ISO 9815 that extrapolate; some minutes of one core.
.PHONY: bench-iso9815
bench-iso9815: setup-test
	@$(PY) tests/bench/iso9815.py --report $(B)/bench/iso9815.md
bench:: bench-iso9815
