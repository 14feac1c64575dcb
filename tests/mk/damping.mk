# make bench-damping: swaywatch damping beside ERA, matrix pencil, log decrement and pyOMA2 on the
# same windows; BICYCLE is the folder of the measured pushes (left out where it is not there).
BICYCLE ?= ../shared/recordings/real/bicycle_weave
PYOMA := $(B)/third_party/pyoma
.PHONY: bench-damping
$(PYOMA)/stamp: tests/bench/pyoma/requirements.txt | $(VENV)/stamp-run
	@echo "fetching pyOMA2"
	@$(PY) -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes --upgrade \
	    --target $(PYOMA) -r $< && touch $@

bench-damping: setup-test $(PYOMA)/stamp
	@OPENBLAS_NUM_THREADS=1 PYTHONPATH=$(PYOMA) $(PY) tests/bench/damping.py --bicycle $(BICYCLE) \
	    --report $(B)/bench/damping.md
bench:: bench-damping
