# Animals from part masks (thesis chapter 6), into one page, build/experiments/animal-animals/index.html, with its table as CSV
# and JSON:
#   make experiments/animal-animals   rendered masks of labelled meshes: table 6.2 against baselines, table 6.1 (time)
#   make experiments/animal-poses     parts whose shape comes from another pose
# QUICK=1 takes a generated animal in place of the data sets. DATA is the folder of the data sets. Methods were developed on
# DEVELOPMENT of meshes.py; the tables show the others apart. A trial that is there is not done again.

.PHONY: experiments/animal-animals experiments/animal-poses

experiments/animal-animals: $(INSTALLED)
	$(BIN)/python -m experiments.animal.page $(QUICKLY) build/experiments/animal-animals$(SUFFIX)/index.html \
	    --data $(DATA) --cache build/meshes/animal

experiments/animal-poses: $(INSTALLED)
	$(BIN)/python -m experiments.animal.poses.page $(QUICKLY) build/experiments/animal-poses$(SUFFIX)/index.html \
	    --data $(DATA) --cache build/meshes/animal
