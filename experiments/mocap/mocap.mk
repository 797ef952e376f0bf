# Recognition of actions (thesis chapter 5). Each target ends in one page, build/experiments/mocap-NAME/index.html, beside tables 5.1 and
# 5.2 and figures 5.3 to 5.6 of the thesis and what it is held to, with the same as CSV and JSON, and an artefact and a page a step:
#   make experiments/mocap-hdm05      11 actions of 5 actors, raw ASF/AMC; every way to part them
#   make experiments/mocap-florence   9 actions before a Kinect, the published splits
#   make experiments/mocap-utkinect   10 actions before a Kinect, the published splits
#   make experiments/mocap-takes      long takes of two actors of HDM05, recognised window by window by a model of the other three. They are
#                                     strung from clips: of CMU's labelled takes only channels that are no joint positions are to be had
# QUICK=1 takes the motions of sample_data in place of the data sets and is done in a minute or two, in a folder of its own.
# DATA is the folder of the data sets; EXECUTOR=processes:2 takes two cores. What benchmarks/mocap/peers.py left is shown beside ours.
# A step whose artefact is there is not done again: after a kill, make goes on where it was, and so do the chains of the mixtures.

DATA ?= $(or $(IPCLI_DATA),../shared/data)
EXECUTOR ?= serial
FEW := --unordered 20,5,1
HDM05_SOURCE := $(DATA)/mocap/hdm05_smij11/hdm05_smij11_raw_asf_amc.tar.xz
FLORENCE_SOURCE := $(DATA)/mocap/florence3d
UTKINECT_SOURCE := $(DATA)/mocap/utkinect/utkinect.tar.xz
HDM05_TEST := mm,tr
HDM05_TRAIN := bd,bk,dg
KINECT_SPLITS := published clips frames
MOCAP_SUFFIX :=
MOCAP_EFFORT :=

ifdef QUICK
MOCAP_SUFFIX := -quick
HDM05_SOURCE := sample_data/motions
FLORENCE_SOURCE := sample_data/motions
UTKINECT_SOURCE := sample_data/motions
HDM05_TEST := eve
HDM05_TRAIN := ann,bob
KINECT_SPLITS := clips frames
MOCAP_EFFORT := --frames 60 --set learning.mixture.sweeps=10 --set learning.mixture.burn_in=5
endif

HDM05 := build/experiments/mocap-hdm05$(MOCAP_SUFFIX)
FLORENCE := build/experiments/mocap-florence$(MOCAP_SUFFIX)
UTKINECT := build/experiments/mocap-utkinect$(MOCAP_SUFFIX)
TAKES := build/experiments/mocap-takes$(MOCAP_SUFFIX)
WINDOWS := 0.5 1 2

# How each method learns, and how a split is drawn. Random splits are drawn three times. Before a Kinect people act with either hand and no
# action is named after one; chosen on splits 1 to 3 of Florence.
KINECT := --mirror
METHOD_aligned :=
METHOD_known := --spread 0
METHOD_thesis := --config configs/mocap-train/thesis.toml
SPLIT_subjects := --split subjects --test $(HDM05_TEST)
SPLIT_leave-one-out := --split leave-one-out
SPLIT_one-to-rest := --split one-to-rest
SPLIT_published := --split published
SPLIT_clips := --split clips --repeats 3
SPLIT_frames := --split frames --repeats 3

.PHONY: experiments/mocap-hdm05 experiments/mocap-florence experiments/mocap-utkinect experiments/mocap-takes

experiments/mocap-hdm05: $(HDM05)/index.html
experiments/mocap-florence: $(FLORENCE)/index.html
experiments/mocap-utkinect: $(UTKINECT)/index.html
experiments/mocap-takes: $(TAKES)/index.html
experiments/mocap-hdm05 experiments/mocap-florence experiments/mocap-utkinect experiments/mocap-takes:
	@echo "Open $(CURDIR)/$< in a browser"

# $(call evaluated,folder,method,split,options)
define evaluated
$(1)/$(2)-$(3).evaluation.h5: $(1)/all.clips.h5
	$$(BIN)/ipcli mocap-evaluate $$< $(SPLIT_$(3)) $(METHOD_$(2)) $(4) $(FEW) $(MOCAP_EFFORT) --executor $(EXECUTOR) -o $$@ --overwrite

endef

# $(call recognised,NAME,folder,source,splits,options but for the thesis' method)
define recognised
$(2)/all.clips.h5: $(3) $(INSTALLED)
	$$(BIN)/ipcli import-clips $$< --rate 30 -o $$@ --overwrite

$(2)/all.model.h5: $(2)/all.clips.h5
	$$(BIN)/ipcli mocap-train $$< $(5) $(MOCAP_EFFORT) --executor $(EXECUTOR) -o $$@ --overwrite

$(foreach s,$(4),$(call evaluated,$(2),aligned,$(s),$(5))$(call evaluated,$(2),thesis,$(s)))
$(foreach s,$(filter clips frames,$(4)),$(call evaluated,$(2),known,$(s),$(5)))

$(2)/index.html: experiments/mocap/page.py experiments/mocap/bars.csv $(wildcard experiments/mocap/thesis/*.csv) $(2)/all.model.h5 \
    $(foreach s,$(4),$(2)/aligned-$(s).evaluation.h5) $(foreach s,$(filter clips frames,$(4)),$(2)/known-$(s).evaluation.h5) \
    $(foreach s,$(4),$(2)/thesis-$(s).evaluation.h5) $(if $(QUICK),,$(wildcard build/benchmarks/mocap_peers_$(1).json))
	$$(BIN)/python -m experiments.mocap.page $(if $(QUICK),--quick )$(1) $$@ $$(filter %.h5 %.json,$$^)
endef

$(eval $(call recognised,hdm05,$(HDM05),$(HDM05_SOURCE),subjects leave-one-out one-to-rest clips frames))
$(eval $(call recognised,florence,$(FLORENCE),$(FLORENCE_SOURCE),$(KINECT_SPLITS),$(KINECT)))
$(eval $(call recognised,utkinect,$(UTKINECT),$(UTKINECT_SOURCE),$(KINECT_SPLITS),$(KINECT)))

# Long takes

$(TAKES)/takes.clips.h5: experiments/mocap/takes.py $(HDM05)/all.clips.h5
	mkdir -p $(@D) && $(BIN)/python -m experiments.mocap.takes string $(HDM05)/all.clips.h5 $@ $(subst $(comma), ,$(HDM05_TEST))

$(TAKES)/others.model.h5: $(HDM05)/all.clips.h5
	$(BIN)/ipcli mocap-train $< --actors $(HDM05_TRAIN) $(MOCAP_EFFORT) --executor $(EXECUTOR) -o $@ --overwrite

$(WINDOWS:%=$(TAKES)/window-%.recognition.h5): $(TAKES)/window-%.recognition.h5: $(TAKES)/others.model.h5 $(TAKES)/takes.clips.h5
	$(BIN)/ipcli mocap-classify $^ --window $* -o $@ --overwrite

$(WINDOWS:%=$(TAKES)/named-%.recognition.h5): $(TAKES)/named-%.recognition.h5: $(TAKES)/others.model.h5 $(TAKES)/takes.clips.h5
	$(BIN)/ipcli mocap-classify $^ --window $* --no-none -o $@ --overwrite

$(TAKES)/index.html: experiments/mocap/takes.py $(WINDOWS:%=$(TAKES)/window-%.recognition.h5) $(WINDOWS:%=$(TAKES)/named-%.recognition.h5)
	$(BIN)/python -m experiments.mocap.takes page $@ $(filter %.h5,$^)
