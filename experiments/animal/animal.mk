# Animals from part masks (thesis chapter 6), into one page, build/experiments/animal-animals/index.html, with its table as CSV
# and JSON:
#   make experiments/animal-animals   rendered masks of labelled meshes: table 6.2 against baselines, table 6.1 (time)
#   make experiments/animal-poses     parts whose shape comes from another pose
#   make experiments/animal-confusion whether each model is nearest to its own kind of animal (figure 6.6)
#   make experiments/animal-photos    a dog, a cat and flamingos of PASCAL-Part, each from one photograph
#   make experiments/animal-aspects   figure 6.3: one mask lifted with the load, without, and with contour noise
# QUICK=1 takes a generated animal in place of the data sets. DATA is the folder of the data sets. Methods were developed on
# DEVELOPMENT of meshes.py; the tables show the others apart. A trial that is there is not done again.

.PHONY: experiments/animal-aspects experiments/animal-animals experiments/animal-poses experiments/animal-confusion experiments/animal-photos

experiments/animal-animals: $(INSTALLED)
	$(BIN)/python -m experiments.animal.page $(QUICKLY) build/experiments/animal-animals$(SUFFIX)/index.html \
	    --data $(DATA) --cache build/meshes/animal

experiments/animal-poses: $(INSTALLED)
	$(BIN)/python -m experiments.animal.poses.page $(QUICKLY) build/experiments/animal-poses$(SUFFIX)/index.html \
	    --data $(DATA) --cache build/meshes/animal

experiments/animal-confusion: $(INSTALLED)
	$(BIN)/python -m experiments.animal.confusion.page $(QUICKLY) build/experiments/animal-confusion$(SUFFIX)/index.html \
	    --data $(DATA) --cache build/meshes/animal

experiments/animal-photos: $(INSTALLED)
	$(BIN)/python -m experiments.animal.photos.page $(QUICKLY) build/experiments/animal-photos$(SUFFIX)/index.html --data $(DATA)

experiments/animal-aspects: $(INSTALLED)
	$(BIN)/python -m experiments.animal.aspects.page $(QUICKLY) build/experiments/animal-aspects$(SUFFIX)/index.html \
	    --data $(DATA) --cache build/meshes/animal
