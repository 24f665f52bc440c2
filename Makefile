# One virtual environment, built from the pins and hashes in requirements/. `make help` lists what there is to do.

PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV   := .venv
BIN    := $(VENV)/bin
PIP    := $(BIN)/python -m pip --disable-pip-version-check install -qq
# What has hashes is everything but the package itself, which pip cannot hash; its build tools are among the pins.
PINNED := $(PIP) --no-deps --require-hashes
SELF   := $(PIP) --no-deps --no-build-isolation --editable .
STEP   := @sh requirements/step.sh
PINS   := pyproject.toml $(wildcard requirements/*.txt)
RESOLUTION := lowest-direct
TESTED := 'pytest>=9.2' 'pytest-timeout>=2.4' 'hypothesis>=6.170'
ZIG    := $(if $(shell command -v cc),,-r requirements/zig.txt)

# Tests are rewritten and compiled in each of their processes unless Python may keep what it compiled.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.NOTPARALLEL:
.DELETE_ON_ERROR:
.PHONY: help reproduce test soak benchmark lint format types imports docs play release-check versions clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  %-13s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

reproduce: $(VENV)/.runtime ## rebuild the paper's figures and claims: report/index.html, report/claims.json
	@$(BIN)/frictionloop reproduce

test: $(VENV)/.dev ## run the tests
	@$(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder

soak: $(VENV)/.dev ## run the long campaigns, stored in tests/soak.json, and the studio for half an hour
	@$(BIN)/python -m pytest -n 2 --dist loadscope -m soak
	@$(BIN)/python -m benchmarks.studio --soak-min 30

benchmark: $(VENV)/.bench ## measure speed beside C, JAX, NumPy and others
	@$(BIN)/python benchmarks/run.py

lint: $(VENV)/.dev ## check style and formatting
	@$(BIN)/ruff check
	@$(BIN)/ruff format --check

format: $(VENV)/.dev ## rewrite files in the project's style
	@$(BIN)/ruff check --fix
	@$(BIN)/ruff format

types: $(VENV)/.dev ## check the types
	@$(BIN)/mypy
	@$(BIN)/mypy --platform win32 src # which names every call that is not there

imports: $(VENV)/.dev ## check that imports between rooms only point down
	@$(BIN)/lint-imports --no-logo

docs: $(VENV)/.dev ## build docs/_build/html, running the examples; warnings are errors
	@$(BIN)/sphinx-build -q -W --keep-going -j 4 -b html docs docs/_build/html
	@$(BIN)/python docs/_tools/heights.py docs/_build/html
	@echo "docs/_build/html/index.html"

play: $(VENV)/.dev ## write the studio as one page, which the next wheel carries: src/frictionloop/studio/play.html
	@$(BIN)/frictionloop studio --export src/frictionloop/studio/play.html

release-check: $(VENV)/.release ## build wheel, sdist and SBOM into dist/, install and verify them, list what is left to a person
	@git diff --quiet HEAD || { echo "what is built is not what is committed: git status" >&2; exit 1; }
	@rm -rf dist && .ci/package dist
	@$(BIN)/twine check --strict dist/*
	@$(BIN)/check-wheel-contents dist/*.whl
	@$(BIN)/cyclonedx-py requirements --pyproject pyproject.toml --output-reproducible -o dist/sbom.json requirements/report.txt
	@cd dist && sha256sum * >SHA256SUMS && cat SHA256SUMS
	@sed -n '/^## Releasing/,/^## /{/^## /!p}' CONTRIBUTING.md

versions: ## with uv: test on PYTHON=... with the oldest libraries that pyproject.toml takes, or RESOLUTION=highest
	@uv venv -q --clear --python "$(PYTHON)" $(VENV)-versions
	@uv pip install -q --python $(VENV)-versions --resolution $(RESOLUTION) -e '.[report,cluster]' $(TESTED)
	@$(VENV)-versions/bin/python -m pytest tests/unit/test_s[iwa]*.py tests/unit/test_toml.py tests/unit/test_record.py

clean: ## remove everything that can be made again
	@rm -rf $(VENV) $(VENV)-versions dist report src/frictionloop/studio/play.html docs/_build docs/gallery docs/sg_execution_times.rst benchmarks/build
	@rm -rf .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	@find src tests benchmarks studies examples docs -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true

# The stamps below are newer than the pins when the environment agrees with them.
$(VENV)/.runtime: $(PINS) | $(BIN)/python
	$(STEP) "Installing the libraries into $(VENV), usually 40 to 100 s" $(PINNED) -r requirements/report.txt
	$(STEP) "Installing frictionloop itself, usually 5 to 20 s" $(SELF)
	@touch $@

$(VENV)/.design: $(PINS) | $(BIN)/python
	$(STEP) "Installing what it draws and designs with into $(VENV), usually 1 to 2 minutes" $(PINNED) -r requirements/design.txt
	$(STEP) "Installing frictionloop itself, usually 5 to 20 s" $(SELF)
	@touch $(VENV)/.runtime $@

$(VENV)/.dev: $(PINS) | $(BIN)/python
	$(STEP) "Installing its test, docs and development tools into $(VENV), usually 2 to 4 minutes" $(PINNED) -r requirements/dev.txt
	$(STEP) "Installing frictionloop itself, usually 5 to 20 s" $(SELF)
	@touch $(VENV)/.runtime $(VENV)/.design $@

$(VENV)/.release: $(VENV)/.dev
	$(STEP) "Installing what verifies a release into $(VENV), usually 10 to 30 s" $(PINNED) -r requirements/release.txt
	@touch $@

$(VENV)/.bench: $(PINS) | $(BIN)/python
	$(STEP) "Installing the libraries it is compared with into $(VENV), usually 2 to 4 minutes" $(PINNED) -r requirements/bench.txt $(ZIG)
	$(STEP) "Installing frictionloop itself, usually 5 to 20 s" $(SELF)
	@touch $(VENV)/.runtime $@

# Some systems ship venv without its copy of pip; then the pip at hand puts one in.
$(BIN)/python:
	@"$(PYTHON)" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null \
	  || { echo "Python 3.11 or newer is needed and '$(PYTHON)' is not it; set PYTHON=/path/to/python" >&2; exit 1; }
	$(STEP) "Creating $(VENV) with $(PYTHON), usually 5 s" sh -c '"$(PYTHON)" -m venv $(VENV) >/dev/null' || { rm -rf $(VENV); \
	  "$(PYTHON)" -m venv --without-pip $(VENV) && "$(PYTHON)" -m pip --python $(VENV) install -qq --no-deps --require-hashes -r requirements/build.txt; }
