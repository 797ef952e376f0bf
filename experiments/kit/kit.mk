# What the experiments of all chapters share. The Makefile includes this first and then every experiments/CHAPTER/CHAPTER.mk.
#   OFFICE := $(call experiment,gaze,office)    declares the target experiments/gaze-office and gives the folder of what it makes
#   $(OFFICE)/index.html: $(OFFICE)/x.h5        says what its page is made from, by experiments/gaze/page.py
# DATA is the folder of the data sets. QUICK=1 takes small generated data in place of them and is done in a minute or two, in folders
# of their own. EXECUTOR=processes:2 takes two cores where a command has many items.
# A step whose artefact is there is not done again: after a kill, make goes on where it was.

DATA ?= $(or $(IPCLI_DATA),../shared/data)
EXECUTOR ?= serial
QUICKLY := $(if $(QUICK),--quick)
SUFFIX := $(if $(QUICK),-quick)

comma := ,
listed = $(subst $() $(),$(comma),$(strip $(1)))
open = @echo "Open $(CURDIR)/$< in a browser"

# A page is made anew when its code, its tables or its artefacts are; only what is below build/ is given to it.
experiment = $(eval $(call declared,$(1),$(2),build/experiments/$(1)-$(2)$(SUFFIX)))build/experiments/$(1)-$(2)$(SUFFIX)
define declared
.PHONY: experiments/$(1)-$(2)
experiments/$(1)-$(2): $(3)/index.html
	$$(open)
$(3)/index.html: $(wildcard experiments/kit/*.py experiments/$(1)/*.py experiments/$(1)/*.csv experiments/$(1)/thesis/*.csv) $(INSTALLED)
	$$(BIN)/python -m experiments.$(1).page $$(QUICKLY) $(2) $$@ $$(filter build/%,$$^)
endef

.SECONDARY:
.SECONDEXPANSION:
