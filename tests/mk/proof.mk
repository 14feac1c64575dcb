# The proof on concealed data: every practice, sealed and chrono case, one setting for all.
PROOF_RECORDINGS ?= $(or $(SWAYWATCH_RECORDINGS),$(wildcard ../shared/recordings),$(wildcard ../../shared/recordings))

.PHONY: proof
proof: setup
	@test -n "$(PROOF_RECORDINGS)" || { echo "proof: no recordings; set SWAYWATCH_RECORDINGS"; exit 1; }
	@$(PY) tests/proof/prove.py $(PROOF_RECORDINGS) tests/proof/verdicts
	@$(PY) tests/proof/table.py $(PROOF_RECORDINGS) tests/proof/verdicts $(B)/bench/diagnosis.md
