# Needs Python 3.11, git and make; everything else is set up here, once.
PYTHON ?= python3.11
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.DEFAULT_GOAL := help
.PHONY: help check check-all test test-slow lint format bench bench-stack bench-motion bench-statics bench-compas figures changelog lock clean

help:           ## list the targets
	@grep -hE '^[a-z-]+: .*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 16

$(READY): pyproject.toml requirements.lock
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --requirement requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	touch $@

check: $(READY) ## set up, then play and judge the scenarios (without the long runs of the bare engine)
	$(BIN)/stackdsl check scenarios --tag '!long'

check-all: $(READY) ## the same with every scenario, long runs included
	$(BIN)/stackdsl check scenarios

test: $(READY)  ## set up, then run the tests
	$(BIN)/python -m pytest

test-slow: $(READY) ## the tests that take minutes
	$(BIN)/python -m pytest -m slow

# Scenarios with a known answer that every system can play within the 20 minutes that a bench may take.
BENCHED := $(addprefix scenarios/,four-stack.yaml slant-tower.yaml columns.yaml harmonic.yaml incline.yaml leaning.yaml \
  drop.yaml) $(wildcard scenarios/hard)
BENCHED_ON := $(addprefix --system ,exact thesis tuned stock mujoco sapien cra rbe)
BENCH_OPTIONS ?= --resolutions 1,1/2

bench: $(READY) ## speed against error: every system at several time steps; table and plot in bench/, figures in docs
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-build-isolation --editable '.[bench,mujoco,sapien,cra]'
	$(BIN)/stackdsl bench $(BENCHED) --tag '!long' $(BENCHED_ON) --time-limit 240 --output bench $(BENCH_OPTIONS)
	$(BIN)/python -m benchmarks.speed_against_error bench

bench-stack: $(READY) ## the four-stack alone, every system in one run
	$(BIN)/python -m benchmarks.four_stack

bench-motion: $(READY) ## hits, collapses and slips of exact against converged runs and equations of motion
	$(BIN)/python -m benchmarks.hits
	$(BIN)/python -m benchmarks.collapse
	$(BIN)/python -m benchmarks.slips

bench-statics: $(READY) ## what exact statics cost, and how far each answer is off
	$(BIN)/python -m benchmarks.statics

bench-compas: $(READY) ## the same towers and walls with compas_cra, side by side; installs it first
	$(BIN)/python -m pip install --quiet --disable-pip-version-check '.[cra]'
	$(BIN)/python -m benchmarks.against_compas

# Benchmarks of minutes, whose figures README and docs show beside those of make bench.
MEASURED := four_stack statics hits collapse slips limits thesis_against_exact slant_towers capabilities

figures: $(READY) ## measure what takes minutes, and write the figures of README and docs anew (half an hour)
	for name in $(MEASURED); do $(BIN)/python -m benchmarks.$$name --write || exit; done
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-build-isolation --editable '.[cra]'
	$(BIN)/python -m benchmarks.against_compas --write
	$(BIN)/python -m benchmarks.figures.picture

changelog: $(READY) ## show what is not released yet; with VERSION=1.2.3, move it to CHANGELOG.md
	$(BIN)/towncrier build $(if $(VERSION),--yes --version $(VERSION),--draft --version unreleased)

lint: $(READY)  ## format check, lint and types
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

format: $(READY) ## rewrite to the house format
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

lock:           ## resolve the newest allowed versions and write requirements.lock
	tools/lock.sh $(PYTHON)

clean:          ## forget the environment and all caches
	rm -rf $(VENV) .mypy_cache .ruff_cache .pytest_cache .hypothesis *.egg-info
