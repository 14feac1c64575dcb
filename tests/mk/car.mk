# make bench-car: what the car's own sensors are worth, issue 15 line by line; CAR_RECORDINGS is a
# folder with practice/, road/ and real/ (absent: said so). CAR="--presence 40 --warnings 0": less.
CAR_RECORDINGS ?= ../shared/recordings
.PHONY: bench-car
bench-car: setup-test $(SWAYWATCHD)
	@OPENBLAS_NUM_THREADS=1 $(PY) tests/bench/car_shown.py --recordings $(CAR_RECORDINGS) \
	    --report $(B)/bench/car.md $(CAR)
