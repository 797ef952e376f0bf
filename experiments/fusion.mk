# Fusion of real sequences (thesis chapter 4): each target ends in a table and a page under build/experiments/.
#   make experiments/fusion-kitti         KITTI stereo 2012, disparities of both cameras
#   make experiments/fusion-livingroom    ICL-NUIM living room, Laplace noise of 30 mm
#   make experiments/fusion-kitchen       7-Scenes Kinect frames, a page to look at
# DATA is the folder of the data sets. Parameters were chosen on the scenes called DEVELOPMENT; the tables show the others.

DATA ?= $(or $(IPCLI_DATA),../shared/data)
METHODS ?= l1-adapt tgv-l1 tgv-huber tv-l1 rof-median

KITTI := build/experiments/fusion-kitti
KITTI_DEVELOPMENT := 000000 000016 000032 000048 000064
KITTI_PAIRS := 000008 000024 000040 000056 000072
KITTI_BUNDLES := 000027 000074 000138 000151 000174
KITTI_SCENES ?= $(KITTI_PAIRS) $(KITTI_BUNDLES)
KITTI_POSES := $(DATA)/fusion/kitti2012_poses/poses_training_cam2world.npz

ROOM := build/experiments/fusion-livingroom
ROOM_DEVELOPMENT := 00075
ROOM_FRAMES ?= 00090 00100 00115 00130

KITCHEN := build/experiments/fusion-kitchen

.PHONY: experiments/fusion-kitti experiments/fusion-livingroom experiments/fusion-kitchen
.SECONDARY:

experiments/fusion-kitti: $(KITTI)/table.h5
	@echo "Open $(CURDIR)/$(KITTI)/table.html in a browser"

experiments/fusion-livingroom: $(ROOM)/table.h5
	@echo "Open $(CURDIR)/$(ROOM)/table.html in a browser"

experiments/fusion-kitchen: $(KITCHEN)/frame-000180.fused.h5
	@echo "Open $(CURDIR)/$(KITCHEN)/frame-000180.fused.html in a browser"

$(KITTI)/table.h5: $(foreach m,$(METHODS),$(KITTI_SCENES:%=$(KITTI)/%.$(m).h5))
	$(BIN)/ipcli compare $^ -o $@ --overwrite

$(ROOM)/table.h5: $(foreach m,$(METHODS),$(ROOM_FRAMES:%=$(ROOM)/%.$(m).h5))
	$(BIN)/ipcli compare $^ -o $@ --overwrite

$(KITTI_PAIRS:%=$(KITTI)/%.views.h5) $(KITTI_DEVELOPMENT:%=$(KITTI)/%.views.h5): $(KITTI)/%.views.h5: $(INSTALLED)
	$(BIN)/ipcli kitti-views $(DATA)/fusion/kitti2012_pairs --poses $(KITTI_POSES) --scenes $* -o $(KITTI)

$(KITTI_BUNDLES:%=$(KITTI)/%.views.h5): $(KITTI)/%.views.h5: $(INSTALLED)
	$(BIN)/ipcli kitti-views $(DATA)/fusion/kitti2012_multiview --poses $(KITTI_POSES) --scenes $* -o $(KITTI)

$(ROOM)/%.views.h5: $(INSTALLED)
	$(BIN)/ipcli import-views $(DATA)/fusion/livingroom1_clean_micro --reference $* --window 11 --noise laplace:0.03 -o $@

$(KITCHEN)/%.fused.h5: $(INSTALLED)
	$(BIN)/fuse-depth $(DATA)/fusion/sevenscenes_kitchen --reference $* --window 11 -o $@

define fuse_by
$(KITTI)/%.$(1).h5: $(KITTI)/%.views.h5
	$(BIN)/fuse-depth $$< --config configs/fuse-depth/kitti.toml --method $(1) -o $$@ --overwrite

$(ROOM)/%.$(1).h5: $(ROOM)/%.views.h5
	$(BIN)/fuse-depth $$< --reference $$* --method $(1) -o $$@ --overwrite
endef
$(foreach m,$(METHODS),$(eval $(call fuse_by,$(m))))
