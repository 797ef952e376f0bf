# Ratios against peers and laws of growth, into build/benchmarks; needs the extra `bench`. benchmarks/README.md says what the tables mean.
#   make benchmarks                   all of them, one after the other
#   make benchmarks/fusion-solver     one: python -m benchmarks.fusion.solver
# QUICK=1 takes smaller problems: it shows that everything runs. MOTIONS are the clips that those of chapter 5 learn from and name:
# a folder of the layout of sample_data/motions, or a clips artefact, with ACTORS to choose settings on.

BENCH := .venv/.bench
BENCHMARKS := fusion-solver fusion-baselines fusion-scaling fusion-memory fusion-tiles mocap-gibbs mocap-speed mocap-peers gaze-paths \
    saliency-speed brdf-speed brdf-solvers
MOTIONS ?= sample_data/motions
ACTORS ?= ann,bob
# RECORDING, with its truth (and gaze), is what gaze-paths and saliency-speed take; without one they take a generated room.
RECORDING ?=

.PHONY: benchmarks $(BENCHMARKS:%=benchmarks/%)

benchmarks/mocap-speed: GIVEN = --clips $(MOTIONS)
benchmarks/mocap-peers: GIVEN = --clips $(MOTIONS) --development $(ACTORS)

benchmarks/gaze-paths: GIVEN = $(if $(RECORDING),--recording $(RECORDING),$(if $(QUICK),,--quick))
benchmarks/saliency-speed: GIVEN = $(if $(RECORDING),--recording $(RECORDING),$(if $(QUICK),,--quick))

benchmark = $(BIN)/python -m benchmarks.$(subst -,.,$(1)) $(QUICKLY) $(GIVEN)
$(BENCHMARKS:%=benchmarks/%): benchmarks/%: $(BENCH)
	$(call benchmark,$*)

# One make after the other, whatever -j says: what is measured side by side must not share the machine.
benchmarks: $(BENCH)
	set -e; for each in $(BENCHMARKS); do $(MAKE) --no-print-directory -o $(BENCH) benchmarks/$$each; done

$(BENCH): $(INSTALLED)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev,bench]'
	touch $@
