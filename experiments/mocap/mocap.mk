# Recognition of actions (thesis chapter 5). Each target ends in one page, build/experiments/mocap-NAME/index.html, beside tables 5.1 and
# 5.2 and figures 5.3 to 5.6 of the thesis and what it is held to, with the same as CSV and JSON, and an artefact and a page a step:
#   make experiments/mocap-hdm05      11 actions of 5 actors, raw ASF/AMC; every way to part them
#   make experiments/mocap-florence   9 actions before a Kinect, the published splits
#   make experiments/mocap-utkinect   10 actions before a Kinect, the published splits
#   make experiments/mocap-takes      long takes of two actors of HDM05, recognised window by window by a model of the other three. They are
#                                     strung from clips: of CMU's labelled takes only channels that are no joint positions are to be had
# QUICK=1 takes the motions of sample_data. What benchmarks/mocap/peers.py left is shown beside ours. The chains of the mixtures, too, go
# on where they were after a kill.

FEW := --unordered 20,5,1
HDM05_SOURCE := $(DATA)/mocap/hdm05_smij11/hdm05_smij11_raw_asf_amc.tar.xz
FLORENCE_SOURCE := $(DATA)/mocap/florence3d
UTKINECT_SOURCE := $(DATA)/mocap/utkinect/utkinect.tar.xz
HDM05_TEST := mm,tr
HDM05_TRAIN := bd,bk,dg
KINECT_SPLITS := published clips frames
MOCAP_EFFORT :=

ifdef QUICK
HDM05_SOURCE := sample_data/motions
FLORENCE_SOURCE := sample_data/motions
UTKINECT_SOURCE := sample_data/motions
HDM05_TEST := eve
HDM05_TRAIN := ann,bob
KINECT_SPLITS := clips frames
MOCAP_EFFORT := --frames 60 --set learning.mixture.sweeps=10 --set learning.mixture.burn_in=5
endif

HDM05 := $(call experiment,mocap,hdm05)
FLORENCE := $(call experiment,mocap,florence)
UTKINECT := $(call experiment,mocap,utkinect)
TAKES := $(call experiment,mocap,takes)
WINDOWS := 0.5 1 2

# How each method learns, and how a split is drawn. Random splits are drawn three times. Before a Kinect people act with either hand and no
# action is named after one; chosen on splits 1 to 3 of Florence.
$(FLORENCE)/% $(UTKINECT)/%: MIRROR := --mirror
METHOD_aligned :=
METHOD_known := --spread 0
METHOD_thesis := --config mocap-train/thesis
SPLIT_subjects := --split subjects --test $(HDM05_TEST)
SPLIT_leave-one-out := --split leave-one-out
SPLIT_one-to-rest := --split one-to-rest
SPLIT_published := --split published
SPLIT_clips := --split clips --repeats 3
SPLIT_frames := --split frames --repeats 3

HDM05_SPLITS := subjects leave-one-out one-to-rest clips frames
random = $(filter clips frames,$(1))
evaluations = $(patsubst %,$(1)/%.evaluation.h5,$(2:%=aligned-%) $(patsubst %,known-%,$(call random,$(2))) $(2:%=thesis-%))
HDM05_EVALUATIONS := $(call evaluations,$(HDM05),$(HDM05_SPLITS))
FLORENCE_EVALUATIONS := $(call evaluations,$(FLORENCE),$(KINECT_SPLITS))
UTKINECT_EVALUATIONS := $(call evaluations,$(UTKINECT),$(KINECT_SPLITS))

$(HDM05)/all.clips.h5: $(HDM05_SOURCE)
$(FLORENCE)/all.clips.h5: $(FLORENCE_SOURCE)
$(UTKINECT)/all.clips.h5: $(UTKINECT_SOURCE)
$(HDM05)/all.clips.h5 $(FLORENCE)/all.clips.h5 $(UTKINECT)/all.clips.h5: $(INSTALLED)
	$(BIN)/ipcli import-clips $(filter-out $(INSTALLED),$^) --rate 30 -o $@ --overwrite

$(HDM05)/all.model.h5 $(FLORENCE)/all.model.h5 $(UTKINECT)/all.model.h5: %.model.h5: %.clips.h5
	$(BIN)/ipcli mocap-train $< $(MIRROR) $(MOCAP_EFFORT) --executor $(EXECUTOR) -o $@ --overwrite

# An evaluation is named METHOD-SPLIT; the thesis' method knows of no mirror images.
method = $(firstword $(subst -, ,$(@F)))
split = $(patsubst $(method)-%.evaluation.h5,%,$(@F))
mirror = $(if $(filter thesis,$(method)),,$(MIRROR))
$(HDM05_EVALUATIONS) $(FLORENCE_EVALUATIONS) $(UTKINECT_EVALUATIONS): $$(@D)/all.clips.h5
	$(BIN)/ipcli mocap-evaluate $< $(SPLIT_$(split)) $(METHOD_$(method)) $(mirror) $(FEW) $(MOCAP_EFFORT) --executor $(EXECUTOR) -o $@ --overwrite

peers = $(if $(QUICK),,$(wildcard build/benchmarks/mocap_peers_$(1).json))
$(HDM05)/index.html: $(HDM05)/all.model.h5 $(HDM05_EVALUATIONS) $(call peers,hdm05)
$(FLORENCE)/index.html: $(FLORENCE)/all.model.h5 $(FLORENCE_EVALUATIONS) $(call peers,florence)
$(UTKINECT)/index.html: $(UTKINECT)/all.model.h5 $(UTKINECT_EVALUATIONS) $(call peers,utkinect)

# Long takes

$(TAKES)/takes.clips.h5: experiments/mocap/takes.py $(HDM05)/all.clips.h5
	mkdir -p $(@D) && $(BIN)/python -m experiments.mocap.takes $(HDM05)/all.clips.h5 $@ $(subst $(comma), ,$(HDM05_TEST))

$(TAKES)/others.model.h5: $(HDM05)/all.clips.h5
	$(BIN)/ipcli mocap-train $< --actors $(HDM05_TRAIN) $(MOCAP_EFFORT) --executor $(EXECUTOR) -o $@ --overwrite

$(WINDOWS:%=$(TAKES)/window-%.recognition.h5): $(TAKES)/window-%.recognition.h5: $(TAKES)/others.model.h5 $(TAKES)/takes.clips.h5
	$(BIN)/ipcli mocap-classify $^ --window $* -o $@ --overwrite

$(WINDOWS:%=$(TAKES)/named-%.recognition.h5): $(TAKES)/named-%.recognition.h5: $(TAKES)/others.model.h5 $(TAKES)/takes.clips.h5
	$(BIN)/ipcli mocap-classify $^ --window $* --no-none -o $@ --overwrite

$(TAKES)/index.html: $(WINDOWS:%=$(TAKES)/window-%.recognition.h5) $(WINDOWS:%=$(TAKES)/named-%.recognition.h5)
