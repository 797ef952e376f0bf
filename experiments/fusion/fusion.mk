# Fusion of rendered and of real sequences (thesis chapter 4). Each target ends in one page, build/experiments/fusion-NAME/index.html,
# beside the thesis' tables and figures, with the same as CSV and JSON, the figures as PDF and PNG, and an artefact a step:
#   make experiments/fusion-objects       rendered objects, Laplace noise of 0.6 (table 4.2, figures 4.1 to 4.4, 4.8, 4.9)
#   make experiments/fusion-urban         rendered city blocks, Laplace noise of 6 (table 4.3, figures 4.5, 4.6, 4.10)
#   make experiments/fusion-kitti         KITTI stereo 2012, disparities of both cameras (tables 4.4, 4.5)
#   make experiments/fusion-livingroom    ICL-NUIM living room, Laplace noise of 30 mm
#   make experiments/fusion-kitchen       7-Scenes Kinect frames, a page to look at
#   make experiments/fusion-defaults      what the defaults of fuse-depth rest on: each setting beside its neighbours, on DEVELOPMENT scenes
#   make experiments/fusion-defaults-kitti   the same of the configuration kitti
# Lambda is tuned for each method on the DEVELOPMENT scenes; the tables show the others.

MESHES := build/meshes
ALGORITHMS := rof-adapt:ama rof-adapt:biconvex l1-adapt:ama l1-adapt:biconvex adapt-hprior:ama adapt-hprior:biconvex \
    adapt-hprior-g:ama adapt-hprior-g:biconvex
ONE_EACH := rof rof-median tv-l1 tgv-l1 tgv-huber l1-heuristic rof-adapt l1-adapt l1-adapt-views \
    adapt-hprior adapt-hprior-g
METHODS ?= all
SWEEP_METHODS ?= median rof-median tgv-l1 l1-heuristic l1-adapt adapt-hprior
LAMBDAS ?= 0.07 0.1 0.14 0.2 0.28 0.4 0.56 0.8 1.6 3.2 6.4
# On the grid every map is solved roughly: that moves the errors by some per cent and takes a fifth of the time.
# SOLVER="$(ROUGHLY)" does the same for the tables; not for KITTI's, where an estimated confidence takes its time to fill wide holes.
SOLVER ?=
ROUGHLY := --set fusion.solver.tolerance=0.01 --set fusion.solver.iterations=100

OBJECTS_DEVELOPMENT := bun_zipper_ascii chicken2
OBJECTS_SCENES ?= dragon_vrip_res2_0 happy_vrip_res3_0 Armadillo_vres2_small_scaled_0 cheff_simple parasaurolophus_low_normals2 trex_small
URBAN_DEVELOPMENT := delft_lod1
URBAN_SCENES ?= 3dfier_innerbuffer_05 3dfier_testarea
KITTI_DEVELOPMENT := 000000 000016 000032 000048 000064
KITTI_PAIRS := 000008 000024 000040 000056 000072
KITTI_BUNDLES := 000027 000074 000138 000151 000174
KITTI_SCENES ?= $(KITTI_PAIRS) $(KITTI_BUNDLES)
LIVINGROOM_DEVELOPMENT := 00075
LIVINGROOM_SCENES ?= 00090 00100 00115 00130
# The thesis' camera is 640 x 480; an object of radius 1 never leaves the middle 416 x 416, and the rest is empty.
RENDER := --width 416 --height 416
FLY := --path strip
OBJECTS_NOISES := 0.1 0.3 0.6 0.8 1.0
OBJECTS_SPACINGS := 0.5 1 2 3 4
URBAN_NOISES := 1 3 6 8 10
URBAN_SPACINGS := 2 4 8 12 16
COUNTS := 3 7 11 15 21
OBJECTS_SWEPT := dragon_vrip_res2_0 Armadillo_vres2_small_scaled_0
URBAN_SWEPT := 3dfier_testarea
KITTI_METHODS ?= $(ONE_EACH)
SOURCE_PAIRS := $(DATA)/fusion/kitti2012_pairs
SOURCE_POSES := $(DATA)/fusion/kitti2012_poses/poses_training_cam2world.npz
SOURCE_ROOM := $(DATA)/fusion/livingroom1_clean_micro
MATCHING :=
CAMERA :=

ifdef QUICK
METHODS := $(ONE_EACH) l1-adapt:ama l1-adapt:biconvex
SOLVER := $(ROUGHLY)
LAMBDAS := 0.1 0.3 1
SWEEP_METHODS := median tgv-l1 l1-adapt
OBJECTS_DEVELOPMENT := torus
OBJECTS_SCENES := knot
URBAN_DEVELOPMENT := village
URBAN_SCENES := town
KITTI_DEVELOPMENT := 000000
KITTI_PAIRS := 000001 000002
KITTI_BUNDLES :=
LIVINGROOM_DEVELOPMENT := 00008
LIVINGROOM_SCENES := 00012
KITTI_SCENES := $(KITTI_PAIRS)
RENDER := --width 104 --height 104 --focal 144
FLY := --path strip --width 160 --height 120 --focal 144
OBJECTS_NOISES := 0.3 0.6
OBJECTS_SPACINGS := 1 3
URBAN_NOISES := 3 6
URBAN_SPACINGS := 4 12
COUNTS := 5 11
OBJECTS_SWEPT := $(OBJECTS_SCENES)
URBAN_SWEPT := $(URBAN_SCENES)
SOURCE_PAIRS := build/recordings/street
SOURCE_POSES := build/recordings/street/poses
SOURCE_ROOM := build/recordings/room
MATCHING := --set sgbm.disparities=64
CAMERA := --intrinsics 131.25,131.25,79.875,59.875
endif

OBJECTS := $(call experiment,fusion,objects)
URBAN := $(call experiment,fusion,urban)
KITTI := $(call experiment,fusion,kitti)
LIVINGROOM := $(call experiment,fusion,livingroom)
DEFAULTS := $(call experiment,fusion,defaults)
DEFAULTS_KITTI := $(call experiment,fusion,defaults-kitti)
KITCHEN := build/experiments/fusion-kitchen

.PHONY: experiments/fusion-kitchen
experiments/fusion-kitchen: $(KITCHEN)/frame-000180.fused.html
	$(open)

# Views: from meshes, from stereo pairs, from a recording. A folder WHAT-VALUE is a setting of a sweep, such as laplace-0.3 or views-7.

mesh = meshes_urban/$(1)$(if $(filter 3dfier%,$(1)),.obj,.ply)
setting = $(subst -, ,$(lastword $(subst /, ,$(@D))))
swept = $(if $(findstring /,$*),$(call varied,$(firstword $(setting)),$(lastword $(setting)),$(1)),--noise laplace:$(1))
varied = $(if $(filter laplace gauss,$(1)),--noise $(1):$(2),--noise laplace:$(3) --$(1) $(2))

$(OBJECTS)/%.views.h5: $(MESHES)/meshes_objects/$$(notdir $$*).ply $(INSTALLED)
	$(BIN)/ipcli render-views $< $(RENDER) $(call swept,0.6) -o $@

$(URBAN)/%.views.h5: $(MESHES)/$$(call mesh,$$(notdir $$*)) $(INSTALLED)
	$(BIN)/ipcli render-views $< $(FLY) $(call swept,6) -o $@

$(KITTI_BUNDLES:%=$(KITTI)/%.views.h5): $(KITTI)/%.views.h5: $(DATA)/fusion/kitti2012_multiview $(INSTALLED)
	$(BIN)/ipcli kitti-views $< --poses $(SOURCE_POSES) --scenes $* -o $(KITTI)

$(KITTI)/%.views.h5: $(SOURCE_PAIRS) $(INSTALLED)
	$(BIN)/ipcli kitti-views $< --poses $(SOURCE_POSES) --scenes $* $(MATCHING) -o $(KITTI)

$(LIVINGROOM)/%.views.h5: $(SOURCE_ROOM) $(INSTALLED)
	$(BIN)/ipcli import-views $< $(CAMERA) --reference $* --window 11 --noise laplace:0.03 -o $@

$(KITCHEN)/%.fused.html: $(INSTALLED)
	$(BIN)/fuse-depth $(DATA)/fusion/sevenscenes_kitchen --reference $* --window 11 -o $(@:.html=.h5)

$(MESHES)/meshes_objects/torus.ply $(MESHES)/meshes_objects/knot.ply $(MESHES)/meshes_urban/town.ply $(MESHES)/meshes_urban/village.ply: \
    $(MESHES)/%.ply: experiments/fusion/solids.py $(INSTALLED)
	$(BIN)/python -m experiments.fusion.solids $@

$(MESHES)/meshes_objects/%: $(DATA)/fusion/meshes_objects/meshes_objects.tar.xz
	mkdir -p $(MESHES) && tar -xJf $< -C $(MESHES) meshes_objects/$* && touch $@

$(MESHES)/meshes_urban/%: $(DATA)/fusion/meshes_urban/meshes_urban.tar.xz
	mkdir -p $(MESHES) && tar -xJf $< -C $(MESHES) meshes_urban/$* && touch $@

build/recordings/%: experiments/fusion/recordings.py experiments/fusion/solids.py $(INSTALLED)
	rm -rf $@ $@.part && $(BIN)/python -m experiments.fusion.recordings $* $@.part && mv $@.part $@

# From views to tables: lambda tuned on the development scenes, every method on the others, their comparison.

$(OBJECTS)/% $(URBAN)/% $(LIVINGROOM)/%: COMPARED = $(METHODS)
$(OBJECTS)/% $(URBAN)/% $(LIVINGROOM)/%: MEASURE := RMSE
$(KITTI)/%: COMPARED = $(KITTI_METHODS)
$(KITTI)/%: MEASURE := D-avg px
$(KITTI)/%: FLAGS := --config fuse-depth/kitti

OBJECTS_TRIALS := $(OBJECTS_SCENES:%=$(OBJECTS)/%.trials.h5)
URBAN_TRIALS := $(URBAN_SCENES:%=$(URBAN)/%.trials.h5)
KITTI_TRIALS := $(KITTI_SCENES:%=$(KITTI)/%.trials.h5)
LIVINGROOM_TRIALS := $(LIVINGROOM_SCENES:%=$(LIVINGROOM)/%.trials.h5)

$(OBJECTS)/tuning.h5: $(OBJECTS_DEVELOPMENT:%=$(OBJECTS)/%.views.h5)
$(URBAN)/tuning.h5: $(URBAN_DEVELOPMENT:%=$(URBAN)/%.views.h5)
$(KITTI)/tuning.h5: $(KITTI_DEVELOPMENT:%=$(KITTI)/%.views.h5)
$(LIVINGROOM)/tuning.h5: $(LIVINGROOM_DEVELOPMENT:%=$(LIVINGROOM)/%.views.h5)
$(OBJECTS)/tuning.h5 $(URBAN)/tuning.h5 $(KITTI)/tuning.h5 $(LIVINGROOM)/tuning.h5:
	$(BIN)/ipcli tune-fusion $^ $(FLAGS) --methods $(call listed,$(COMPARED)) --lambdas $(call listed,$(LAMBDAS)) --measure '$(MEASURE)' $(ROUGHLY) -o $@ --overwrite

$(OBJECTS_TRIALS) $(URBAN_TRIALS) $(KITTI_TRIALS) $(LIVINGROOM_TRIALS): %.trials.h5: %.views.h5 $$(@D)/tuning.h5
	$(BIN)/ipcli evaluate-fusion $< $(FLAGS) $(SOLVER) --methods $(call listed,$(COMPARED)) --tuning $(@D)/tuning.h5 -o $@ --overwrite

$(OBJECTS)/table.h5: $(OBJECTS_TRIALS)
$(URBAN)/table.h5: $(URBAN_TRIALS)
$(KITTI)/table.h5: $(KITTI_TRIALS)
$(LIVINGROOM)/table.h5: $(LIVINGROOM_TRIALS)
$(OBJECTS)/table.h5 $(URBAN)/table.h5 $(KITTI)/table.h5 $(LIVINGROOM)/table.h5:
	$(BIN)/ipcli compare $^ -o $@ --overwrite

# Sweeps over noise, number and spacing of the views, and figures 4.1 and 4.2.

settings = $(1:%=laplace-%) $(1:%=gauss-%) $(COUNTS:%=views-%) $(2:%=spacing-%)
OBJECTS_SWEEPS := $(foreach s,$(call settings,$(OBJECTS_NOISES),$(OBJECTS_SPACINGS)),$(OBJECTS_SWEPT:%=$(OBJECTS)/$(s)/%.trials.h5))
URBAN_SWEEPS := $(foreach s,$(call settings,$(URBAN_NOISES),$(URBAN_SPACINGS)),$(URBAN_SWEPT:%=$(URBAN)/$(s)/%.trials.h5))

$(OBJECTS_SWEEPS) $(URBAN_SWEEPS): %.trials.h5: %.views.h5
	$(BIN)/ipcli evaluate-fusion $< $(SOLVER) --methods $(call listed,$(SWEEP_METHODS)) --keep median -o $@ --overwrite

%/scale-space.npz: experiments/fusion/scale_space.py $(INSTALLED)
	$(BIN)/python -m experiments.fusion.scale_space $@

# Pages.

$(OBJECTS)/index.html: $(addprefix $(OBJECTS)/,table.h5 tuning.h5) $(OBJECTS_TRIALS) $(OBJECTS)/scale-space.npz $(OBJECTS_SWEEPS)
$(URBAN)/index.html: $(addprefix $(URBAN)/,table.h5 tuning.h5) $(URBAN_TRIALS) $(URBAN_SWEEPS)
$(KITTI)/index.html: $(addprefix $(KITTI)/,table.h5 tuning.h5) $(KITTI_TRIALS)
$(LIVINGROOM)/index.html: $(addprefix $(LIVINGROOM)/,table.h5 tuning.h5) $(LIVINGROOM_TRIALS)
$(DEFAULTS)/index.html: $(OBJECTS_DEVELOPMENT:%=$(OBJECTS)/%.views.h5) $(URBAN_DEVELOPMENT:%=$(URBAN)/%.views.h5) $(LIVINGROOM_DEVELOPMENT:%=$(LIVINGROOM)/%.views.h5)
$(DEFAULTS_KITTI)/index.html: $(KITTI_DEVELOPMENT:%=$(KITTI)/%.views.h5)
