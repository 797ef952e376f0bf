# Surfaces from one picture (thesis chapter 7). Each target ends in one page, build/experiments/brdf-NAME/index.html, beside what it is held
# to, with the same as CSV and JSON:
#   make experiments/brdf-mit         five objects of MIT-Berkeley's intrinsic images (table 7.2)
#   make experiments/brdf-diligent    six objects of DiLiGenT, photographs under five mixes of lights
#   make experiments/brdf-synthetic   five objects of our own making in every material of the library (table 7.1)
#   make experiments/brdf-traced      the same pictures path traced by Mitsuba (extra `mitsuba`): shadows and inter-reflection
#   make experiments/brdf-painted     the same objects under four kinds of paint: what texture does
#   make experiments/brdf-reliefs     bowls and domes, a dish and a spoon under light from above, the side and below: which way it bends
#   make experiments/brdf-development cup1, meshes, sheets and generated solids in measured materials under real probes: what all was chosen on
#   make experiments/brdf-rims        what the judge of rims should learn from, on the same and more of its kind
#   make experiments/brdf-materials   which material, metal or not: held-out surfaces under held-out lights
# QUICK=1 takes generated scenes in place of the data sets, a small library and few cases. Parameters were chosen on MIT's cup1 and on generated scenes.

BRDF_LIST := sample_data/brdf/materials.toml
BRDF_LIBRARY := build/experiments/brdf-library$(SUFFIX).h5
BRDF_EFFORT := $(if $(QUICK),--lights 12 --scenes 120 --pictures 40)
BRDF_STUDIES := mit diligent synthetic traced painted reliefs development rims materials

.PHONY: $(BRDF_STUDIES:%=experiments/brdf-%)
$(BRDF_STUDIES:%=experiments/brdf-%): experiments/brdf-%: build/experiments/brdf-%$(SUFFIX)/index.html
	$(open)

$(BRDF_LIBRARY): $(BRDF_LIST) $(INSTALLED)
	$(BIN)/ipcli brdf-train $< $(BRDF_EFFORT) --executor $(EXECUTOR) -o $@ --overwrite

build/experiments/brdf-%$(SUFFIX)/index.html: $(BRDF_LIBRARY) experiments/brdf/page.py $(wildcard experiments/brdf/*.py)
	$(BIN)/python -m experiments.brdf.page $(QUICKLY) $* --library $< --data $(DATA) -o $(@D)
