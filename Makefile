# Needs Python 3.11 or later, git and make; everything else is set up here, once. Of PYTHON=python3.12 and later, where
# PyBullet has no wheels, what needs it is skipped by name.
PYTHON ?= python3.11
VENV ?= .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
READY_DEV := $(VENV)/.ready-dev
READY_DOCS := $(VENV)/.ready-docs
# Where this is set, every process that a check or a test starts would compile the whole program anew, half a second each.
export PYTHONDONTWRITEBYTECODE :=

.DEFAULT_GOAL := help
.PHONY: help docs setup check check-all test test-slow without-pybullet test-without-pybullet wheel lint format bench bench-stack bench-start bench-motion bench-energy bench-statics bench-compas figures replay pictures editor changelog lock clean

help:           ## list the targets
	@grep -hE '^[a-z-]+: .*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 16

# What a set-up installs are files that a lock has the digests of, and what of it is built, is so with what is in it:
# setuptools comes first, and nothing is fetched for a build. Python compiles the few modules that are imported.
PIP_INSTALL := $(BIN)/python -m pip install --disable-pip-version-check --no-deps --no-compile
QUIET := $$(test -t 1 || echo --quiet) # pip shows its progress at a terminal
LOCKED = $(PIP_INSTALL) $(QUIET) --require-hashes --no-build-isolation --requirement

# An environment outside of this tree belongs to another checkout, which its editable package points to. It is used as it
# is: a new set-up from here would replace that package.
ifneq ($(filter $(CURDIR)/%,$(abspath $(VENV))),)
$(READY): pyproject.toml requirements.lock setup.py
$(READY_DEV): requirements-dev.lock
$(READY_DOCS): requirements-docs.lock
else
export PYTHONPATH := $(CURDIR)
endif
$(READY):
	@echo 'Setting up $(VENV): this downloads 210 MB, once; PyBullet is 103 MB of it.'
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	sed -n '/^setuptools==/,/[^\\]$$/p' requirements.lock > $(VENV)/build.lock
	$(PIP_INSTALL) --quiet --require-hashes --requirement $(VENV)/build.lock
	$(LOCKED) requirements.lock
	$(PIP_INSTALL) --quiet --no-build-isolation --editable .
	$(BIN)/python -m stability.engines.rigid
	touch $@

$(READY_DEV): $(READY)
	@echo 'Setting up the tests in $(VENV): this downloads another 120 MB, once.'
	$(LOCKED) requirements-dev.lock
	touch $@

$(READY_DOCS): $(READY_DEV)
	@echo 'Setting up the documentation in $(VENV): this downloads another 20 MB, once.'
	$(LOCKED) requirements-docs.lock
	touch $@

setup: $(READY_DEV) ## set up for development, and do nothing else

check: $(READY) ## set up, then play and judge the scenarios (without the long runs of the bare engine)
	$(BIN)/stackdsl check scenarios --tag '!long'

check-all: $(READY) ## the same with every scenario, long runs included
	$(BIN)/stackdsl check scenarios

# One process a core; tests that share what takes long stay together.
PYTEST := $(BIN)/python -m pytest -n auto --dist loadgroup --maxschedchunk 1

test: $(READY_DEV)  ## set up, then run the tests
	$(PYTEST)

test-slow: $(READY_DEV) ## the tests that take minutes
	$(PYTEST) -m slow

# The peers, and what the picture is drawn with.
INSTALL_PEERS := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-build-isolation --editable '.[benchmarks]' --editable plugins/stackdsl-sapien && $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps compas_lmgc90==0.1.11

bench: $(READY_DEV) ## speed against error: every system at several time steps, 20 minutes; figures and picture in docs
	$(INSTALL_PEERS)
	$(BIN)/python -m benchmarks.systems --write

bench-stack: $(READY_DEV) ## the four-stack alone, every system in one run
	$(BIN)/python -m benchmarks.four_stack

bench-start: $(READY_DEV) ## what it costs to start, in units of importing click
	$(BIN)/python -m benchmarks.start

bench-motion: $(READY_DEV) ## hits, collapses and slips of exact against converged runs and equations of motion
	$(BIN)/python -m benchmarks.hits
	$(BIN)/python -m benchmarks.wall_hits
	$(BIN)/python -m benchmarks.collapse
	$(BIN)/python -m benchmarks.slips

bench-leaning: $(READY_DEV) ## 200 random leaning structures against rigid boxes stepped apart (some minutes); goes on where it stopped
	$(BIN)/python -m benchmarks.leaning_slips --keep leaning-slips.jsonl

bench-energy: $(READY_DEV) ## how much energy the engines of exact and tuned add to 1,000 random heaps (an hour and a half of one core)
	$(BIN)/python -m benchmarks.energy

bench-statics: $(READY_DEV) ## what exact statics cost, and how far each answer is off
	$(BIN)/python -m benchmarks.statics

bench-compas: $(READY_DEV) ## the same towers and walls with compas_cra, side by side; installs it first
	$(INSTALL_PEERS)
	$(BIN)/python -m benchmarks.against_compas

without-pybullet: $(READY) test-without-pybullet ## statics, and all that exact plays, for Pythons that have no PyBullet
	$(BIN)/stackdsl check scenarios --system exact --tag '!long' --tag '!large'

test-without-pybullet: $(READY_DEV) ## of these, the tests alone
	$(PYTEST) tests/test_imports.py tests/stability/geometry tests/stability/contacts tests/stability/statics tests/stability/analysis $(addprefix tests/stackdsl/simulation/,test_foreign.py test_modification.py test_peers.py test_published_on_peers.py test_readings_of_systems.py)

docs: $(READY_DOCS) ## build the site of the documentation in build/site, with the replays of the gallery
	$(BIN)/python -m sphinx --quiet --fail-on-warning --keep-going -c docs/site -b html . build/site
	@echo 'Open build/site/index.html in a browser.'

wheel: $(READY) ## build the wheel, and try it in an empty environment, outside of this directory
	tools/try_wheel.sh $(BIN)/python

# Benchmarks of minutes, whose figures README and docs show beside those of make bench.
MEASURED := four_stack statics find slopes fragility human_error card_houses_apart hits collapse slips limits thesis_against_exact slow_studies slant_towers capabilities modified readings outcomes survived joined tied studded mutated_files

figures: $(READY_DEV) ## measure what takes minutes, and write the figures of README and docs anew (half an hour)
	for name in $(MEASURED); do $(BIN)/python -m benchmarks.$$name --write || exit; done
	$(INSTALL_PEERS)
	$(BIN)/python -m benchmarks.end_hits --write
	$(BIN)/python -m benchmarks.published_falls --write
	$(BIN)/python -m benchmarks.sway --write
	$(BIN)/python -m benchmarks.against_compas --write
	$(BIN)/python -m benchmarks.compas_samples --write
	$(BIN)/python -m benchmarks.against_lmgc90 --write
	$(BIN)/python -m benchmarks.solids_in_engines --write
	$(BIN)/python -m benchmarks.round_bodies --write

editor: $(READY_DEV) ## what an editor shows, tried with the language server itself, which needs npm
	npm install --silent --no-audit --no-fund --prefix .node yaml-language-server@2.0.0
	$(BIN)/python -m pytest -q tests/stackdsl/language/test_editor_completion.py

replay:         ## bundle the program of replay pages anew, from the versions in replay/package-lock.json; needs Node.js
	cd replay && npm ci --ignore-scripts && npm run check && npm run build

pictures: $(READY_DEV) ## draw the pictures of README and docs anew, and replay pages, in Debian's Chromium
	$(BIN)/python -m benchmarks.figures.picture
	$(BIN)/python -m benchmarks.figures.strips
	$(BIN)/python -m benchmarks.figures.gallery
	$(BIN)/python -m benchmarks.figures.replays

changelog: $(READY_DEV) ## show what is not released yet; with VERSION=1.2.3, move it to CHANGELOG.md
	$(BIN)/towncrier build $(if $(VERSION),--yes --version $(VERSION),--draft --version unreleased)

lint: $(READY_DEV)  ## format check, lint and types
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/python -m stackdsl.built_files  # mypy reads stubs
	$(BIN)/mypy

format: $(READY_DEV) ## rewrite to the house format
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

lock:           ## resolve the newest allowed versions and write the locks
	tools/lock.sh

clean:          ## forget the environment and all caches
	rm -rf $(VENV) .mypy_cache .ruff_cache .pytest_cache .hypothesis *.egg-info
