# make demo      set up, then the reference study: impact on the 72 x 72 x 30 FCC packing, analysis and figures
# make test      set up, then the tests (minutes)
# make validate  the long validations
# Everything is installed into .venv; PYTHON chooses the interpreter that makes it.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
RANKS := $(shell n=$$(nproc 2>/dev/null || echo 1); [ $$n -gt 2 ] && n=2; echo $$n)
SOURCES := pyproject.toml $(shell find plugins lammps_inputs workflows analysis -type f -not -name '*.pyc' 2>/dev/null)
DEMO := runs/fcc-impact

.PHONY: setup demo test validate lint bench clean

setup: $(VENV)/installed

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip

$(VENV)/installed: $(VENV)/bin/python $(SOURCES)
	$(BIN)/python -m pip install --quiet '.[test]'
	@touch $@

demo: setup
	$(BIN)/granwave run fcc-impact -o $(DEMO) --np $(RANKS) --force
	@echo "Figures: $(DEMO)/figures   summary: $(DEMO)/summary.json   fields: $(DEMO)/result.h5"

test: setup
	$(BIN)/python -m pytest

validate: setup
	$(BIN)/python -m pytest -m validation

lint: setup
	$(BIN)/python -m pip install --quiet '.[lint]'
	$(BIN)/ruff check . && $(BIN)/ruff format --check .
	cd / && $(abspath $(BIN))/mypy --config-file $(abspath pyproject.toml)

clean:
	rm -rf $(VENV) build dist runs .pytest_cache .ruff_cache .mypy_cache
