# `make help` lists the targets. PYTHON=python3.12 names the interpreter to use, PYTEST_ARGS='tests/cli -x' the tests to run;
# LINT=no leaves out lint, whose results do not depend on the interpreter.
SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DELETE_ON_ERROR:
.NOTPARALLEL:

python := .venv/bin/python
stamp := .venv/.installed
maintenance := build/maintenance
checked := $(wildcard metamodel cli transformations analysis generators runtime sources observation views case_study benchmarks docs examples tests tools) setup.py

first := $(if $(filter no,$(LINT)),browser-packages,lint)

# The stamp names where it was installed: another place or a PYTHON given by hand mean a new installation.
wanted := $(CURDIR)
ifneq ($(shell cat $(stamp) 2>/dev/null),$(wanted))
.PHONY: $(stamp)
endif
ifeq ($(origin PYTHON),command line)
.PHONY: $(stamp)
endif
export PYTHON
# Hundreds of short processes are started here: none of them compiles all modules again.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help
help: ## Show this list
	@sed -n 's/^\([a-z]*\):.*## /\1\t/p' $(firstword $(MAKEFILE_LIST)) | expand -t 12

.PHONY: install
install: $(stamp) ## Make .venv with everything in it, engines compiled, and the case study's workspace (quick when nothing changed)
	@tools/system-packages
	@.venv/bin/dineros warm-up
	@$(python) case_study/generate.py

$(stamp): pyproject.toml setup.py requirements/build.txt requirements/development.txt tools/install
	@tools/install
	@echo '$(wanted)' >$@

.PHONY: demo
demo: install ## Run the case study
	@$(python) case_study/demo.py

.PHONY: lint
lint: install ## Run every check but the tests
	@echo "Lint (ruff check)" && $(python) -m ruff check --quiet $(checked)
	@echo "Format (ruff format --check)" && $(python) -m ruff format --quiet --check $(checked) || { echo "make format fixes this"; exit 1; }
	@echo "Browser code (biome check, tsc --strict)" && tools/check-browser
	@echo "Types (mypy --strict)" && $(python) tools/typecheck.py --no-error-summary
	@echo "Generated code (dineros.metamodel.generate --check)" && $(python) -m dineros.metamodel.generate --check

.PHONY: browser-packages
browser-packages: install
	@tools/browser-packages

.PHONY: test
test: $(first) ## Run lint, then all tests but the long ones
	@echo "Tests that are not long (pytest)" && $(python) -m pytest -n 3 -m 'not long' $(PYTEST_ARGS)

.PHONY: thorough
thorough: $(first) ## Run lint, then all tests
	@echo "Tests (pytest)" && $(python) -m pytest -n 3 $(PYTEST_ARGS)

.PHONY: regenerate
regenerate: $(stamp) ## Generate the typed API from the .ecore files, and the case study's workspace again
	@$(python) -m dineros.metamodel.generate
	@$(python) case_study/generate.py --anew

.PHONY: format
format: install ## Format the code, fix what ruff can
	@$(python) -m ruff check --fix $(checked)
	@$(python) -m ruff format $(checked)
	@tools/check-browser --write

.PHONY: benchmark
benchmark: install ## Run every benchmark
	@for script in benchmarks/{models,analysis,running}/*.py; do \
		name=$${script%.py}; name=$${name////.}; echo "== $$name"; $(python) -m "$$name"; done

.PHONY: contest
contest: install ## Run the nets of the Model Checking Contest in FOLDER; CONTEST_ARGS='--seconds 3'
	@$(python) -m benchmarks.contest.run $(FOLDER) $(CONTEST_ARGS)

.PHONY: endurance
endurance: install ## Stop, kill and flood running applications, for hours
	@for application in sorting fleet mobile_robot; do $(python) -m benchmarks.endurance.stops_and_kills $$application || exit; done
	@$(python) -m benchmarks.endurance.flood -o build/flood
	@for journal in '' --journal; do $(python) -m benchmarks.endurance.periodic $$journal || exit; done

$(maintenance)/.installed: requirements/maintenance.txt
	@$(python) -m venv --clear $(maintenance)
	@$(maintenance)/bin/python -m pip --disable-pip-version-check --quiet install --require-hashes --no-deps -r $<
	@touch $@

.PHONY: lock
lock: install $(maintenance)/.installed ## Write requirements/ again; UPGRADE=yes takes newer versions
	@$(python) tools/lock.py $(maintenance)/bin/uv $(if $(UPGRADE),--upgrade)

.PHONY: audit
audit: install $(maintenance)/.installed ## Ask for known vulnerabilities in what is installed
	@$(python) tools/audit.py $(maintenance)/bin/pip-audit requirements/*.txt

.PHONY: clean
clean: ## Remove .venv and everything built
	@rm -rf .venv node_modules build dist *.egg-info .hypothesis .mypy_cache .pytest_cache .ruff_cache
	@git clean -dfqX case_study/workspace 2>/dev/null || true
	@find . -name __pycache__ -type d -prune -exec rm -rf {} +
