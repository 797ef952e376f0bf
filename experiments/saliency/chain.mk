# From a recording to saliency in one go, docs/chain.md says what is where:
#   make chain                      of sample_data/room
#   make chain RECORDING=FOLDER     of any recording with gaze that gaze-sfm takes; GAZE=EXPORT where its gaze lies elsewhere
#   make chain-euroc                of EuRoC V1_01 (100 sparse pairs of pictures), looked at by a generated gaze
# A step whose result is there is not done again; results are in build/chain/NAME/.

CHAIN_RECORDING := $(or $(RECORDING),sample_data/room)
CHAIN_STEP ?= 2
GAZE ?=
# parcels of the sample are 0.4 m wide
CHAIN_SALIENCY ?= --radius 0.35
CHAIN := build/chain/$(notdir $(CHAIN_RECORDING))

CHAIN_EUROC := $(DATA)/gaze/euroc_v101_sub100
CHAIN_GAZE := build/recordings/euroc-gaze/gaze.csv

.PHONY: chain chain-euroc
chain: $(INSTALLED)
	$(BIN)/ipcli gaze-sfm $(CHAIN_RECORDING) $(GAZE:%=--gaze %) -o $(CHAIN)/run.gaze.h5
	$(BIN)/ipcli gaze-views $(CHAIN_RECORDING) $(CHAIN)/run.gaze.h5 -o $(CHAIN)/run.views.h5
	$(BIN)/ipcli fuse-depth $(CHAIN)/run.views.h5 --all --window 7 --step $(CHAIN_STEP) -o $(CHAIN)/fused
	$(BIN)/ipcli merge-depth $(CHAIN)/fused/*.fused.h5 -o $(CHAIN)/cloud.h5
	$(BIN)/ipcli saliency $(CHAIN)/run.gaze.h5 --cloud $(CHAIN)/cloud.h5 $(CHAIN_SALIENCY) -o $(CHAIN)/run.saliency.h5
	@echo "Open in a browser: the head's path, the cloud, and what is likely to be looked at"
	@for page in run.gaze cloud run.saliency; do echo "  $(CURDIR)/$(CHAIN)/$$page.html"; done

$(CHAIN_GAZE): experiments/saliency/generated_gaze.py $(INSTALLED)
	$(BIN)/python -m experiments.saliency.generated_gaze $(CHAIN_EUROC) $@
chain-euroc: $(CHAIN_GAZE)
	$(MAKE) --no-print-directory chain RECORDING=$(CHAIN_EUROC) GAZE=$< CHAIN_STEP=10
