# make demo | test | verify | clean; PYTHON=python3.12 chooses the interpreter that .venv is made from.

PYTHON ?= python3
BIN := .venv/bin
INSTALLED := .venv/.installed
DEMO := build/demo/shapes.fused

.PHONY: demo test verify clean
.DELETE_ON_ERROR:

demo: $(INSTALLED)
	$(BIN)/fuse-depth sample_data/shapes --reference 005 -o $(DEMO).h5
	@echo "Open $(CURDIR)/$(DEMO).html in a browser"

test: $(INSTALLED)
	$(BIN)/python -m pytest

verify: $(INSTALLED)
	$(BIN)/python -m pytest -m ""

clean:
	rm -rf .venv build ipcli.egg-info .pytest_cache .hypothesis
	find ipcli tests tools -name __pycache__ -type d -prune -exec rm -rf {} +

$(INSTALLED): pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	touch $@

-include experiments/*.mk
