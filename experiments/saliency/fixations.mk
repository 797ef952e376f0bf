# Fixations that were recorded; each page is build/experiments/saliency-NAME/index.html:
#   make experiments/saliency-osie      60 pictures of OSIE x 15 observers, five folds by picture
#   make experiments/saliency-meshes    ten surfaces looked at in virtual reality, leave one out
# QUICK=1 takes small generated sets. Settings were chosen on the first 30 pictures of OSIE; those of surfaces are the same, and
# which features of surfaces are computed was chosen on all ten, so that there the figure is of leave one out alone.

SALIENCY_OSIE := $(call experiment,saliency,osie)
SALIENCY_MESHES := $(call experiment,saliency,meshes)
SALIENCY_SETS := build/recordings/saliency-sets$(SUFFIX)
SALIENCY_PICTURES := $(DATA)/gaze/osie60
SALIENCY_LEARNING :=
ifdef QUICK
SALIENCY_PICTURES := $(SALIENCY_SETS)/pictures
SALIENCY_LEARNING := --trees 10 --set learning.negatives=100 --shown 2
endif

$(SALIENCY_SETS)/.made: experiments/saliency/small_sets.py $(INSTALLED)
	mkdir -p $(@D)
	$(if $(QUICK),$(BIN)/python -m experiments.saliency.small_sets $(@D),mkdir -p $(@D)/surfaces && tar -xJf $(DATA)/gaze/mesh_fixations_vr/mesh_fixations_vr.tar.xz -C $(@D)/surfaces --strip-components=1)
	touch $@

$(SALIENCY_OSIE)/evaluation.h5: $(SALIENCY_SETS)/.made
	$(BIN)/ipcli saliency-evaluate $(SALIENCY_PICTURES) $(SALIENCY_LEARNING) --executor $(EXECUTOR) -o $@ --overwrite
$(SALIENCY_MESHES)/evaluation.h5: $(SALIENCY_SETS)/.made
	$(BIN)/ipcli saliency-evaluate $(SALIENCY_SETS)/surfaces --folds 10 $(SALIENCY_LEARNING) --executor $(EXECUTOR) -o $@ --overwrite

$(SALIENCY_OSIE)/index.html: $(SALIENCY_OSIE)/evaluation.h5
$(SALIENCY_MESHES)/index.html: $(SALIENCY_MESHES)/evaluation.h5
