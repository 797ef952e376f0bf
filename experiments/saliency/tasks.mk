# Search tasks (thesis 3.5), generated with their searcher; the page is build/experiments/saliency-tasks/index.html:
#   make experiments/saliency-tasks     table 3.1 by subsequence and at random, figures 3.14 to 3.16, what membranes add
# QUICK=1 takes two short tasks. Settings were chosen on the tasks red and blue of seeds 100 and 101; those of seeds 1 to 4 are judged.

SALIENCY_TASKS := red-1 yellow-2 blue-3 pink-4
SALIENCY_FRAMES := 300
ifdef QUICK
SALIENCY_TASKS := red-100 blue-101
SALIENCY_FRAMES := 75
endif
SALIENCY_SEARCH := $(call experiment,saliency,tasks)
SALIENCY_MADE := build/recordings/saliency$(SUFFIX)
SALIENCY_RADIUS := --radius 0.35
SALIENCY_QUICKLY := --set scene.group_size=0

# by subsequence | free: proto-objects anywhere | random: table 3.1 as printed | printed: membranes excited by curvature | others: (3.20), what was learnt for the other tasks
SALIENCY_WAY_sequence :=
SALIENCY_WAY_free := --domain free $(SALIENCY_QUICKLY)
SALIENCY_FITTING := classifying.penalty=30 classifying.width=0.7 classifying.landmarks=600 classifying.most=40000
SALIENCY_WAY_random := --split random --leave-out none $(SALIENCY_FITTING:%=--set scene.%) $(SALIENCY_QUICKLY)
SALIENCY_WAY_printed := --excitation printed $(SALIENCY_QUICKLY)
SALIENCY_WAYS := sequence free random printed others

$(SALIENCY_TASKS:%=$(SALIENCY_MADE)/%.gaze.h5): experiments/saliency/search_tasks.py $(INSTALLED)
	$(BIN)/python -m experiments.saliency.search_tasks $(firstword $(subst -, ,$(basename $(basename $(@F))))) \
	    --seed $(lastword $(subst -, ,$(basename $(basename $(@F))))) --frames $(SALIENCY_FRAMES) $@

saliency_task = $(word 2,$(subst ., ,$(1)))
saliency_way = $(word 1,$(subst ., ,$(1)))
SALIENCY_FOUND := $(foreach way,$(SALIENCY_WAYS),$(SALIENCY_TASKS:%=$(SALIENCY_SEARCH)/$(way).%.h5))
saliency_others = $(foreach task,$(filter-out $(1),$(SALIENCY_TASKS)),$(SALIENCY_SEARCH)/sequence.$(task).h5)

$(filter-out $(SALIENCY_SEARCH)/others.%,$(SALIENCY_FOUND)): $$(SALIENCY_MADE)/$$(call saliency_task,$$(@F)).gaze.h5
	$(BIN)/ipcli saliency $< $(SALIENCY_RADIUS) $(SALIENCY_WAY_$(call saliency_way,$(@F))) -o $@ --overwrite
$(filter $(SALIENCY_SEARCH)/others.%,$(SALIENCY_FOUND)): $$(SALIENCY_MADE)/$$(call saliency_task,$$(@F)).gaze.h5 $$(call saliency_others,$$(call saliency_task,$$(@F)))
	$(BIN)/ipcli saliency $< $(SALIENCY_RADIUS) --model $(call listed,$(wordlist 2,99,$^)) -o $@ --overwrite

$(SALIENCY_SEARCH)/index.html: $(SALIENCY_FOUND)
