# Animals from part masks (thesis chapter 6). Each target ends in one page, build/experiments/animal-NAME/index.html, with its
# table as CSV and JSON:
#   make experiments/animal-animals   rendered masks of labelled meshes: table 6.2 against baselines, table 6.1 (time)
#   make experiments/animal-confusion figure 6.6: models against ground truth of all classes
#   make experiments/animal-aspects   figure 6.3: one part under every load, and with contour noise
# QUICK=1 takes a generated animal in place of the data sets. DATA is the folder of the data sets. Methods were developed on
# DEVELOPMENT of meshes.py; tables give the others apart. A trial that is there is not done again.

ANIMALS ?= 381 384 387 388 390 391 392 394 395 396 397 398 399 400 cat0 cat5 dog0 dog5 horse0 horse10 horse15
ANIMAL_CACHE := build/meshes/animal

.PHONY: experiments/animal-animals experiments/animal-confusion experiments/animal-aspects

experiments/animal-animals: $(INSTALLED)
	$(BIN)/python -m experiments.animal.animals build/experiments/animal-animals$(if $(QUICK),-quick)/index.html --data $(or $(DATA),../shared/data) --cache $(ANIMAL_CACHE) $(if $(QUICK),--quick)

experiments/animal-confusion: $(INSTALLED)
	$(BIN)/python -m experiments.animal.confusion build/experiments/animal-confusion$(if $(QUICK),-quick)/index.html --data $(or $(DATA),../shared/data) --cache $(ANIMAL_CACHE) $(if $(QUICK),--quick)

experiments/animal-aspects: $(INSTALLED)
	$(BIN)/python -m experiments.animal.aspects build/experiments/animal-aspects$(if $(QUICK),-quick)/index.html --data $(or $(DATA),../shared/data) --cache $(ANIMAL_CACHE) $(if $(QUICK),--quick)
