# Fusion of real and of rendered sequences (thesis chapter 4): each target ends in a table and a page under build/experiments/.
#   make experiments/fusion-kitti         KITTI stereo 2012, disparities of both cameras
#   make experiments/fusion-livingroom    ICL-NUIM living room, Laplace noise of 30 mm
#   make experiments/fusion-kitchen       7-Scenes Kinect frames, a page to look at
#   make experiments/fusion-objects       rendered objects, Laplace noise of 0.6 (thesis table 4.2)
#   make experiments/fusion-urban         rendered city blocks, Laplace noise of 6 (thesis table 4.3)
#   make experiments/fusion-objects-sweeps, experiments/fusion-urban-sweeps
#                                         noise, number of views and spacing (figures 4.3, 4.5): a table a setting, a page of curves
# The rendered ones take QUICK=1: small pictures of generated solids, which need no data.
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

MESHES := build/meshes
ifdef QUICK
OBJECTS := build/experiments/fusion-objects-quick
URBAN := build/experiments/fusion-urban-quick
OBJECT_SCENES := torus
URBAN_PLY := town
URBAN_OBJ :=
RENDERED_METHODS ?= l1-adapt tgv-l1
RENDER := --width 160 --height 120 --focal 144
else
OBJECTS := build/experiments/fusion-objects
URBAN := build/experiments/fusion-urban
OBJECT_SCENES ?= bun_zipper_ascii dragon_vrip_res2_0 happy_vrip_res3_0 Armadillo_vres2_small_scaled_0 cheff_simple chicken2 \
    parasaurolophus_low_normals2 trex_small
URBAN_PLY ?= delft_lod1
URBAN_OBJ ?= 3dfier_innerbuffer_05 3dfier_testarea
RENDERED_METHODS ?= $(METHODS) l1-heuristic adapt-hprior
RENDER :=
endif
OBJECT_NOISE ?= laplace:0.6
URBAN_NOISE ?= laplace:6

.PHONY: experiments/fusion-kitti experiments/fusion-livingroom experiments/fusion-kitchen
.PHONY: experiments/fusion-objects experiments/fusion-urban
.SECONDARY:

experiments/fusion-kitti: $(KITTI)/table.h5
	@echo "Open $(CURDIR)/$(KITTI)/table.html in a browser"

experiments/fusion-livingroom: $(ROOM)/table.h5
	@echo "Open $(CURDIR)/$(ROOM)/table.html in a browser"

experiments/fusion-kitchen: $(KITCHEN)/frame-000180.fused.h5
	@echo "Open $(CURDIR)/$(KITCHEN)/frame-000180.fused.html in a browser"

experiments/fusion-objects: $(OBJECTS)/table.h5
	@echo "Open $(CURDIR)/$(OBJECTS)/table.html in a browser"

experiments/fusion-urban: $(URBAN)/table.h5
	@echo "Open $(CURDIR)/$(URBAN)/table.html in a browser"

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

$(OBJECTS)/table.h5: $(foreach m,$(RENDERED_METHODS),$(OBJECT_SCENES:%=$(OBJECTS)/%.$(m).h5))
	$(BIN)/ipcli compare $^ -o $@ --overwrite

$(URBAN)/table.h5: $(foreach m,$(RENDERED_METHODS),$(addprefix $(URBAN)/,$(addsuffix .$(m).h5,$(URBAN_PLY) $(URBAN_OBJ))))
	$(BIN)/ipcli compare $^ -o $@ --overwrite

$(OBJECTS)/%.views.h5: $(MESHES)/meshes_objects/%.ply $(INSTALLED)
	$(BIN)/ipcli render-views $< --noise $(OBJECT_NOISE) $(RENDER) -o $@

$(URBAN_PLY:%=$(URBAN)/%.views.h5): $(URBAN)/%.views.h5: $(MESHES)/meshes_urban/%.ply $(INSTALLED)
	$(BIN)/ipcli render-views $< --path strip --noise $(URBAN_NOISE) $(RENDER) -o $@

$(URBAN_OBJ:%=$(URBAN)/%.views.h5): $(URBAN)/%.views.h5: $(MESHES)/meshes_urban/%.obj $(INSTALLED)
	$(BIN)/ipcli render-views $< --path strip --noise $(URBAN_NOISE) $(RENDER) -o $@

$(MESHES)/meshes_objects/torus.ply $(MESHES)/meshes_urban/town.ply: $(MESHES)/%.ply: experiments/solids.py $(INSTALLED)
	$(BIN)/python $< $@

$(MESHES)/meshes_objects/%: $(DATA)/fusion/meshes_objects/meshes_objects.tar.xz
	mkdir -p $(MESHES) && tar -xJf $< -C $(MESHES) meshes_objects/$* && touch $@

$(MESHES)/meshes_urban/%: $(DATA)/fusion/meshes_urban/meshes_urban.tar.xz
	mkdir -p $(MESHES) && tar -xJf $< -C $(MESHES) meshes_urban/$* && touch $@

define fuse_by
$(KITTI)/%.$(1).h5: $(KITTI)/%.views.h5
	$(BIN)/fuse-depth $$< --config configs/fuse-depth/kitti.toml --method $(1) -o $$@ --overwrite

$(ROOM)/%.$(1).h5: $(ROOM)/%.views.h5
	$(BIN)/fuse-depth $$< --reference $$* --method $(1) -o $$@ --overwrite
endef
$(foreach m,$(METHODS),$(eval $(call fuse_by,$(m))))

define fuse_rendered_by
$(OBJECTS)/%.$(1).h5: $(OBJECTS)/%.views.h5
	$(BIN)/fuse-depth $$< --method $(1) -o $$@ --overwrite

$(URBAN)/%.$(1).h5: $(URBAN)/%.views.h5
	$(BIN)/fuse-depth $$< --method $(1) -o $$@ --overwrite
endef
$(foreach m,$(RENDERED_METHODS),$(eval $(call fuse_rendered_by,$(m))))

# One setting of a sweep: folder, scenes, mesh folder with %, how to render.
SWEEP_METHODS ?= l1-adapt tgv-l1
SWEPT_OBJECTS ?= $(firstword $(OBJECT_SCENES)) $(word 2,$(OBJECT_SCENES))
SWEPT_URBAN ?= $(URBAN_PLY)

define sweep_setting
$(1)/table.h5: $(foreach m,$(SWEEP_METHODS),$(2:%=$(1)/%.$(m).h5))
	$(BIN)/ipcli compare $$^ -o $$@ --overwrite

$(1)/%.views.h5: $(3) $(INSTALLED)
	$(BIN)/ipcli render-views $$< $(4) $(RENDER) -o $$@

$(foreach m,$(SWEEP_METHODS),$(call sweep_method,$(1),$(m)))
endef

define sweep_method
$(1)/%.$(2).h5: $(1)/%.views.h5
	$(BIN)/fuse-depth $$< --method $(2) -o $$@ --overwrite


endef

define sweep
.PHONY: experiments/fusion-$(1)-sweeps
experiments/fusion-$(1)-sweeps: $(2)/sweeps.html
	@echo "Open $(CURDIR)/$(2)/sweeps.html in a browser"

$(2)/sweeps.html: experiments/curves.py $(6:%=$(2)/noise-%/table.h5) $(7:%=$(2)/views-%/table.h5) $(8:%=$(2)/spacing-%/table.h5)
	$(BIN)/python experiments/curves.py $$@ $$(filter %.h5,$$^)

$(foreach n,$(6),$(eval $(call sweep_setting,$(2)/noise-$(n),$(3),$(4),$(5) --noise laplace:$(n))))
$(foreach n,$(7),$(eval $(call sweep_setting,$(2)/views-$(n),$(3),$(4),$(5) --noise $(9) --views $(n))))
$(foreach n,$(8),$(eval $(call sweep_setting,$(2)/spacing-$(n),$(3),$(4),$(5) --noise $(9) --spacing $(n))))
endef

ifdef QUICK
LEVELS := 1 3
else
LEVELS := 1 2 3 4 5
endif
pick = $(foreach i,$(LEVELS),$(word $(i),$(1)))
$(eval $(call sweep,objects,$(OBJECTS),$(SWEPT_OBJECTS),$(MESHES)/meshes_objects/%.ply,--path orbit,$\
    $(call pick,0.1 0.3 0.6 0.8 1.0),$(call pick,3 7 11 15 21),$(call pick,0.5 1 2 3 4),$(OBJECT_NOISE)))
$(eval $(call sweep,urban,$(URBAN),$(SWEPT_URBAN),$(MESHES)/meshes_urban/%.ply,--path strip,$\
    $(call pick,1 3 6 8 10),$(call pick,3 7 11 15 21),$(call pick,1 2 4 6 8),$(URBAN_NOISE)))
