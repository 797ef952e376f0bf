# make benchmarks: ratios against peers and laws of growth, into build/benchmarks; needs the extra `bench`.

BENCH := .venv/.bench

.PHONY: benchmarks

benchmarks: $(BENCH)
	$(BIN)/python -m benchmarks.fusion.solver
	$(BIN)/python -m benchmarks.fusion.baselines
	$(BIN)/python -m benchmarks.fusion.scaling

$(BENCH): $(INSTALLED)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev,bench]'
	touch $@
