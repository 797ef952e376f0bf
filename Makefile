# make demo | test | verify | attack | lint | clean; PYTHON=python3.12 chooses the interpreter that .venv is made from,
# WORKERS=1 how many processes share the tests.

PYTHON ?= python3
BIN := .venv/bin
INSTALLED := .venv/.installed
DEMO := build/demo
FEW_SWEEPS := --set learning.mixture.sweeps=30 --set learning.mixture.burn_in=15

WORKERS ?= logical
PYTEST := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses $(WORKERS) --dist loadscope

.PHONY: demo test verify attack lint clean
.DELETE_ON_ERROR:

demo: $(INSTALLED)
	$(BIN)/gaze-sfm sample_data/room --gaze-sigma 0.71 -o $(DEMO)/room.gaze.h5
	$(BIN)/saliency $(DEMO)/room.gaze.h5 --radius 0.35 -o $(DEMO)/room.saliency.h5
	$(BIN)/fuse-depth sample_data/shapes --reference 005 -o $(DEMO)/shapes.fused.h5
	$(BIN)/mocap-train sample_data/motions --actors ann,bob $(FEW_SWEEPS) -o $(DEMO)/motions.model.h5
	$(BIN)/mocap-classify $(DEMO)/motions.model.h5 sample_data/motions --actors eve -o $(DEMO)/motions.recognition.h5
	$(BIN)/model-animal sample_data/animal/standing.toml -o $(DEMO)/animal.glb
	$(BIN)/brdf-train sample_data/brdf/materials.toml --scenes 120 --pictures 40 -o $(DEMO)/materials.h5
	$(BIN)/brdf-model $(DEMO)/materials.h5 sample_data/brdf/vase.png --mask sample_data/brdf/vase.mask.png \
	    --true-height sample_data/brdf/vase.height.npz -o $(DEMO)/vase.h5
	$(BIN)/ipcli saliency-predict sample_data/brdf/vase.png -o $(DEMO)/vase.looks.h5
	$(BIN)/python -m tools.make_index $(DEMO)
	@echo "Open in a browser: $(CURDIR)/$(DEMO)/index.html"

test: $(INSTALLED)
	$(PYTEST)

verify: $(INSTALLED)
	$(PYTEST) -m ""

attack: $(INSTALLED)
	$(BIN)/python -m tools.attack

lint: $(INSTALLED)
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy

clean:
	rm -rf .venv build ipcli.egg-info .pytest_cache .hypothesis .ruff_cache .mypy_cache
	find ipcli tests tools -name __pycache__ -type d -prune -exec rm -rf {} +

$(INSTALLED): pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	touch $@

-include experiments/kit/kit.mk $(filter-out experiments/kit/kit.mk,$(wildcard experiments/*/*.mk)) benchmarks/benchmarks.mk
