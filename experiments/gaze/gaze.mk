# Gaze localisation (thesis section 3.2). Each target ends in one page, build/experiments/gaze-NAME/index.html, with what it is held to:
#   make experiments/gaze-localisation   head paths against the truth: EuRoC (100 sparse pairs, and standing still), KITTI, 346 pairs
#   make experiments/gaze-por            points of regard on five landmarks of generated rooms, gaze noise of one degree, and their regions
#   make experiments/gaze-keyframes      keyframes of the same rooms against the changes of attention
#   make experiments/gaze-map            a single camera in the map of the other half of EuRoC: of the run, and of its COLMAP model
#   make experiments/gaze-chain          gaze-sfm, then fuse-depth, then merge-depth on EuRoC (chapter 3 feeds chapter 4)
# QUICK=1 takes small generated rooms in place of the data sets. Settings were chosen on the rooms of seeds 100 and 101; those of seeds 1 to 6 are judged.

GAZE_DATA := $(DATA)/gaze
GAZE_ROOMS := 1 2 3 4 5 6
GAZE_COURSE := --frames 180 --width 640 --height 480
GAZE_PATHS := euroc still kitti library
ifdef QUICK
GAZE_ROOMS := 1 2
GAZE_COURSE := --frames 24 --width 320 --height 240
GAZE_PATHS := room1 room2
endif
GAZE_SOURCE_euroc := $(GAZE_DATA)/euroc_v101_sub100
GAZE_SOURCE_still := $(GAZE_DATA)/euroc_v101_static20
GAZE_SOURCE_kitti := $(GAZE_DATA)/kitti_51
GAZE_SOURCE_library := $(GAZE_DATA)/boofcv_library346
GAZE_MADE := build/recordings/gaze$(SUFFIX)
GAZE_SOURCE_room1 := $(GAZE_MADE)/room1
GAZE_SOURCE_room2 := $(GAZE_MADE)/room2

GAZE_LOCALISATION := $(call experiment,gaze,localisation)
GAZE_POR := $(call experiment,gaze,por)
GAZE_KEYFRAMES := $(call experiment,gaze,keyframes)
GAZE_CHAIN := $(call experiment,gaze,chain)

$(GAZE_MADE)/room%/gaze.csv: experiments/gaze/room.py $(INSTALLED)
	$(BIN)/python -m experiments.gaze.room --seed $* $(GAZE_COURSE) $(@D)

# one degree in all, as one to all sides: 1 / sqrt 2 along each axis
GAZE_REGARDS := $(GAZE_ROOMS:%=$(GAZE_POR)/room%.gaze.h5)
$(GAZE_REGARDS): $(GAZE_POR)/%.gaze.h5: $(GAZE_MADE)/%/gaze.csv
	$(BIN)/ipcli gaze-sfm $(<D) --gaze-sigma 0.7071 -o $@ --overwrite

GAZE_FOUND := $(GAZE_PATHS:%=$(GAZE_LOCALISATION)/%.gaze.h5)
$(GAZE_FOUND): $(if $(QUICK),$(GAZE_MADE)/room1/gaze.csv $(GAZE_MADE)/room2/gaze.csv) $(INSTALLED)
	$(BIN)/ipcli gaze-sfm $(GAZE_SOURCE_$(@F:.gaze.h5=)) --poses-only -o $@ --overwrite

GAZE_CHAINED := $(if $(QUICK),room1,euroc)
GAZE_FUSING := $(if $(QUICK),--set fusion.solver.iterations=60) --window 7 --step $(if $(QUICK),2,20)
$(GAZE_CHAIN)/run.views.h5: $(GAZE_LOCALISATION)/$(GAZE_CHAINED).gaze.h5
	$(BIN)/ipcli gaze-views $(GAZE_SOURCE_$(GAZE_CHAINED)) $< -o $@ --overwrite
$(GAZE_CHAIN)/cloud.h5: $(GAZE_CHAIN)/run.views.h5
	$(BIN)/ipcli fuse-depth $< --all $(GAZE_FUSING) -o $(@D)/fused --overwrite
	$(BIN)/ipcli merge-depth $(@D)/fused/*.fused.h5 -o $@ --overwrite

# Every second frame makes the map; the left camera alone is localised at the others.
GAZE_MAP := $(call experiment,gaze,map)
GAZE_LEFT := $(if $(QUICK),$(GAZE_SOURCE_room1)/cam0/*.png,$(GAZE_SOURCE_euroc)/images/*_0.jpg)
$(GAZE_MAP)/first.gaze.h5: $(if $(QUICK),$(GAZE_MADE)/room1/gaze.csv) $(INSTALLED)
	$(BIN)/ipcli gaze-sfm $(GAZE_SOURCE_$(GAZE_CHAINED)) --poses-only --step 2 -o $@ --overwrite
$(GAZE_MAP)/one/cam0_sensor.yaml: $(GAZE_MAP)/first.gaze.h5
	mkdir -p $(@D)/cam0 $(GAZE_MAP)/model
	for file in $(GAZE_LEFT); do ln -sf "$$(realpath $$file)" $(@D)/cam0/$$(basename $$file | sed s/_0//); done
	ln -sfn cam0 $(@D)/left
	for part in cameras images points3D; do cp $(GAZE_MAP)/first.gaze.$$part.bin $(GAZE_MAP)/model/$$part.bin; done
	cp $(GAZE_SOURCE_$(GAZE_CHAINED))/gt_cam0.tum $(@D)
	cp $(GAZE_SOURCE_$(GAZE_CHAINED))/cam0_sensor.yaml $@
GAZE_IN_run = $(GAZE_MAP)/first.gaze.h5
GAZE_IN_model = $(GAZE_MAP)/model --map-images $(GAZE_MAP)/one
GAZE_AGAIN := $(GAZE_MAP)/run.gaze.h5 $(GAZE_MAP)/model.gaze.h5
$(GAZE_AGAIN): $(GAZE_MAP)/one/cam0_sensor.yaml
	$(BIN)/ipcli gaze-sfm $(<D) --poses-only --start 1 --step 2 --map $(GAZE_IN_$(@F:.gaze.h5=)) -o $@ --overwrite

$(GAZE_MAP)/index.html: $(GAZE_MAP)/first.gaze.h5 $(GAZE_AGAIN)
$(GAZE_LOCALISATION)/index.html: $(GAZE_FOUND)
$(GAZE_POR)/index.html: $(GAZE_REGARDS)
$(GAZE_KEYFRAMES)/index.html: $(GAZE_REGARDS)
$(GAZE_CHAIN)/index.html: $(GAZE_CHAIN)/cloud.h5 $(GAZE_LOCALISATION)/$(GAZE_CHAINED).gaze.h5
