# Everything runs in .venv, which is made on first use and after a change of the dependencies.
# Another interpreter: make PYTHON=/path/to/python3.12 ...   (then `make clean` first)

VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
PYTHON ?=
DEMO_DIR ?= mobius-demo

IN_RANGE := import sys, venv, ensurepip; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))

.PHONY: help demo test lint docs links viewer clean

help: ## show this list
	@sed -n 's/^\([a-z]*\):.*## /  make \1\t/p' $(MAKEFILE_LIST)

demo: $(READY) ## match the shipped pairs of meshes, write results, pictures and pages to mobius-demo/
	@$(BIN)/mobius demo -o $(DEMO_DIR)

test: $(READY) ## run the tests in two processes, and print how much of the code they run
	@$(BIN)/python -m pytest --numprocesses 2 --dist loadfile --no-loadscope-reorder --cov --cov-report term

lint: $(READY) ## check style, types, and that imports point down the floors
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/lint-imports --no-logo

docs: $(READY) ## make the documentation site in build/docs; warnings and broken links are errors
	@$(BIN)/sphinx-build --nitpicky --fail-on-warning --keep-going --write-all --quiet -d build/doctrees docs build/docs

links: $(READY) ## check the documentation's links to other sites (needs the network)
	@$(BIN)/sphinx-build --quiet -d build/doctrees -b linkcheck -D plot_gallery=0 docs build/links

viewer: ## build the script of the viewer's page again after a change in viewer/ (needs Node)
	@cd viewer && npm ci --no-audit --no-fund --ignore-scripts && npm run --silent build

clean: ## remove what was built
	rm -rf $(VENV) $(DEMO_DIR) viewer/node_modules build docs/examples dist .pytest_cache .mypy_cache .ruff_cache .hypothesis src/*.egg-info
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

$(READY): pyproject.toml constraints/lock.txt
	@set -e; \
	if [ ! -x $(BIN)/python ]; then \
	  found=; \
	  for python in $(if $(PYTHON),"$(PYTHON)",python3.13 python3.12 python3.11 python3); do \
	    if "$$python" -c '$(IN_RANGE)' >/dev/null 2>&1; then found="$$python"; break; fi; \
	  done; \
	  if [ -z "$$found" ]; then \
	    echo "Python 3.11, 3.12 or 3.13 with venv and pip is needed$(if $(PYTHON), (PYTHON=$(PYTHON) is not), and was not found)." >&2; \
	    echo "Install one (on Debian with its python3-venv package) or name it: make PYTHON=/path/to/python3.12" >&2; \
	    exit 1; \
	  fi; \
	  echo "Making $(VENV) with $$found ..." >&2; \
	  "$$found" -m venv --clear $(VENV); \
	fi
	@echo "Installing into $(VENV) (a minute or two the first time) ..." >&2
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints/lock.txt setuptools
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints/lock.txt \
	  --no-build-isolation --editable '.[dev,docs]'
	@touch $(READY)
