# make proof-blind: concealed cases on the rigid-body plant, diagnosed, then scored.
# N=60 for fewer cases; JOBS for the number of processes; PROOF_SEED for other cases.
N ?= 200
JOBS ?= 2
PROOF_SEED ?= 20261121
BLIND := tests/proof/blind
BLIND_OUT := $(B)/proof-blind
BLIND_CASES := $(BLIND_OUT)/$(PROOF_SEED)

.PHONY: proof-blind proof-blind-cases
proof-blind-cases: setup
	@$(PY) $(BLIND)/generate.py --seed $(PROOF_SEED) --count $(N) --jobs $(JOBS) \
	    --out $(BLIND_CASES)/cases --answers $(BLIND_CASES)/answers

proof-blind: proof-blind-cases
	@$(PY) $(BLIND)/diagnose_all.py --cases $(BLIND_CASES)/cases --out $(BLIND_CASES)/diagnoses \
	    --count $(N) --jobs $(JOBS)
	@$(PY) $(BLIND)/case_limits.py --seed $(PROOF_SEED) --cases $(BLIND_CASES)/cases \
	    --answers $(BLIND_CASES)/answers --count $(N) --jobs $(JOBS)
	@$(PY) $(BLIND)/score.py --answers $(BLIND_CASES)/answers --diagnoses $(BLIND_CASES)/diagnoses \
	    --out $(BLIND_OUT)/score.json
	@$(PY) $(BLIND)/table.py $(BLIND_OUT)/score.json $(B)/bench/blind.md --seed $(PROOF_SEED)

# Twenty vehicles on springs with nothing concealed, as users know them: what is said of each.
.PHONY: proof-springs
SPRINGS_SEED ?= 2201
SPRINGS_OUT := $(BLIND_OUT)/springs-$(SPRINGS_SEED)
proof-springs: setup
	@$(PY) $(BLIND)/generate.py --seed $(SPRINGS_SEED) --count 20 --clean F --jobs $(JOBS) \
	    --out $(SPRINGS_OUT)/cases --answers $(SPRINGS_OUT)/answers
	@$(PY) $(BLIND)/diagnose_all.py --cases $(SPRINGS_OUT)/cases --out $(SPRINGS_OUT)/diagnoses \
	    --count 20 --jobs $(JOBS)
	@$(PY) $(BLIND)/score.py --answers $(SPRINGS_OUT)/answers --diagnoses $(SPRINGS_OUT)/diagnoses \
	    --out $(SPRINGS_OUT)/score.json

# Physics that no library lists, six kinds to build on (build), four sets of six that were opened
# once (opened-once, opened-second, opened-third, opened-fourth), sixteen (opened-fifth, seed 8209),
# twelve (opened-sixth, seed 9103), ten (opened-seventh, seed 9304, N=10), twelve (opened-eighth,
# seed 9401, N=12), twelve (opened-ninth, seed 9502, N=12), twelve (opened-tenth, seed 9605, N=12),
# twelve (opened-eleventh, seed 9707, N=12), ten (opened-twelfth, seed 20812, N=10) and ten to open
# once (opened-thirteenth, seed 21313, N=10): what law is found, where, of what.
.PHONY: proof-unlisted
UNLISTED ?= build
UNLISTED_SEED ?= 4001
UNLISTED_OUT := $(BLIND_OUT)/unlisted-$(UNLISTED)-$(UNLISTED_SEED)
proof-unlisted: setup
	@$(PY) $(BLIND)/generate.py --seed $(UNLISTED_SEED) --count $(N) --unlisted $(UNLISTED) \
	    --jobs $(JOBS) --out $(UNLISTED_OUT)/cases --answers $(UNLISTED_OUT)/answers
	@$(PY) $(BLIND)/diagnose_all.py --cases $(UNLISTED_OUT)/cases --out $(UNLISTED_OUT)/diagnoses \
	    --count $(N) --jobs $(JOBS)
	@$(PY) $(BLIND)/unlisted_score.py --answers $(UNLISTED_OUT)/answers \
	    --diagnoses $(UNLISTED_OUT)/diagnoses --out $(B)/bench/unlisted-$(UNLISTED).md

# A vehicle.toml that is far off, as the dissertation's was: what is concealed, what is said.
# Beside the user's own simulation: two effects at once (pairs), the dampers of Table 6-1 (dampers).
.PHONY: proof-beside
BESIDE ?= pairs
BESIDE_SEED ?= 7011
BESIDE_OUT := $(BLIND_OUT)/beside-$(BESIDE)-$(BESIDE_SEED)
proof-beside: setup
	@$(PY) $(BLIND)/generate.py --seed $(BESIDE_SEED) --count $(N) --beside $(BESIDE) \
	    --out $(BESIDE_OUT)/cases --answers $(BESIDE_OUT)/answers --jobs $(JOBS)
	@$(PY) $(BLIND)/diagnose_all.py --cases $(BESIDE_OUT)/cases --out $(BESIDE_OUT)/diagnoses \
	    --count $(N) --jobs $(JOBS)
	@$(PY) $(BLIND)/case_limits.py --seed $(BESIDE_SEED) --beside $(BESIDE) \
	    --cases $(BESIDE_OUT)/cases --answers $(BESIDE_OUT)/answers --count $(N) --jobs $(JOBS)
	@$(PY) $(BLIND)/beside_score.py --answers $(BESIDE_OUT)/answers \
	    --diagnoses $(BESIDE_OUT)/diagnoses \
	    --out $(B)/bench/beside-$(BESIDE).md

.PHONY: proof-far-off
proof-far-off: setup
	@$(PY) tests/proof/far_off.py $(BLIND_OUT)/far-off

# Our limits beside those that the road recordings state, a check of the method.
.PHONY: proof-limits
ROAD ?= ../shared/recordings/road
proof-limits: setup
	@$(PY) tests/proof/road_limits.py $(ROAD)

# What the confidence and the intervals are fitted to: never the proof's seed.
DEV_SEED ?= 101
DEV_CASES := $(BLIND_OUT)/$(DEV_SEED)
.PHONY: calibrate
calibrate: setup
	@$(PY) $(BLIND)/generate.py --seed $(DEV_SEED) --count $(N) --jobs $(JOBS) \
	    --out $(DEV_CASES)/cases --answers $(DEV_CASES)/answers
	@$(PY) $(BLIND)/diagnose_all.py --cases $(DEV_CASES)/cases --out $(DEV_CASES)/diagnoses \
	    --count $(N) --jobs $(JOBS)
	@$(PY) $(BLIND)/calibrate.py --set $(DEV_CASES)/answers $(DEV_CASES)/diagnoses \
	    --seeds $(DEV_SEED) --out sim_host/src/swaywatch/diagnose/evidence/calibration.json
	@$(PY) $(BLIND)/score.py --answers $(DEV_CASES)/answers --diagnoses $(DEV_CASES)/diagnoses \
	    --no-predict --out $(DEV_CASES)/score.json
