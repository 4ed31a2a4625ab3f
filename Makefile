# Everything a newcomer needs: `make demo` runs the main job, `make test` the tests.
# Both make .venv first, from requirements/*.lock (every download is checked against its hash).
SHELL  := /bin/bash
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
DEMO   ?= demo-output
UV     := $(BIN)/uv --no-progress -q
PYTEST := $(BIN)/python -m pytest

# A machine may forbid Python to keep compiled modules: then every process that a test or a diagnosis starts would compile
# NumPy, SciPy and pandas anew (4 s of 7 s here).
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help setup setup-dev demo test test-slow lint docs bench lock clean check-host

help: ## what can be made
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 14

check-host:
	@PYTHON="$(PYTHON)" bash requirements/check_host.sh

$(VENV)/.boot: requirements/bootstrap.lock | check-host
	@echo "setup: making $(VENV)"
	@$(PYTHON) -m venv --clear $(VENV)
	@$(BIN)/python -m pip install -q --disable-pip-version-check --require-hashes -r requirements/bootstrap.lock
	@touch $@

$(VENV)/.run: $(VENV)/.boot requirements/run.lock pyproject.toml
	@echo "setup: installing what knitbench runs on"
	@VIRTUAL_ENV=$(VENV) $(UV) pip install --require-hashes --no-build-isolation-package noise -r requirements/run.lock
	@VIRTUAL_ENV=$(VENV) $(UV) pip install --no-deps --no-build-isolation -e .
	@touch $@

$(VENV)/.dev: $(VENV)/.run requirements/dev.lock
	@echo "setup: installing the tests' tools"
	@VIRTUAL_ENV=$(VENV) $(UV) pip install --require-hashes --no-build-isolation-package noise -r requirements/dev.lock
	@touch $@

$(VENV)/.docs: $(VENV)/.dev requirements/docs.lock
	@echo "setup: installing what the documentation is built with"
	@VIRTUAL_ENV=$(VENV) $(UV) pip install --require-hashes --no-build-isolation-package noise -r requirements/docs.lock
	@touch $@

setup: $(VENV)/.run ## the environment alone (.venv)

setup-dev: $(VENV)/.dev

demo: $(VENV)/.run ## the main job, end to end: plan, run, compensate, diagnose, report
	@$(BIN)/python datasets/demo.py -o $(DEMO)

test: $(VENV)/.dev ## the default tests
	@$(PYTEST) -n 2 --dist loadfile --no-loadscope-reorder $(ARGS)

test-slow: $(VENV)/.dev ## the long tests
	@$(PYTEST) -n 2 --maxschedchunk 1 -m slow $(ARGS)

lint: $(VENV)/.dev ## ruff, mypy, import-linter
	@$(BIN)/ruff check . && $(BIN)/ruff format --check . && $(BIN)/mypy && PYTHONPATH=benchmarks $(BIN)/lint-imports

docs: $(VENV)/.docs ## the documentation as pages, strict; notebooks are executed (docs/_build/html/index.html)
	@OMP_NUM_THREADS=1 $(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html
	@echo "docs: docs/_build/html/index.html"

bench: $(VENV)/.dev ## the benchmarks; each prints its own table
	@for b in benchmarks/bench_*.py; do \
	  case $$b in *bench_twin*) few="--trials 2";; *) few="";; esac; \
	  echo "== $$b $$few"; $(BIN)/python $$b $$few || exit 1; done

lock: $(VENV)/.boot ## pin the dependencies again (hashes, no host names)
	@bash requirements/lock.sh "$(BIN)/uv"

clean: ## remove the environment and the demo's output
	rm -rf $(VENV) $(DEMO) docs/_build
