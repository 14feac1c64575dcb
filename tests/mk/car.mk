# make bench-car: what the car's own sensors are worth; CAR_RECORDINGS is a folder with practice/ and
# road/ (absent: that part is left out).
CAR_RECORDINGS ?= ../shared/recordings
.PHONY: bench-car
bench-car: setup-test
	@mkdir -p $(B)/bench
	@$(PY) tests/bench/car_sensors.py --recordings $(CAR_RECORDINGS) --drives 60 --presence 200 \
	    --warnings 40 --hours 2 >$(B)/bench/car_sensors.json
	@cat $(B)/bench/car_sensors.json
