# Everything runs from a virtual environment in .venv, made on first use; nothing else on the machine changes.
#
#   make demo    fly the paper's experiment with its four controllers; leaves out/demo/report.html
#   make test    the tests; make test-slow those that take long, too
#   make bare    fly in two bare environments: what `pip install .` brings, and the core with NumPy and CasADi alone
#   make bench   how fast the closed loop is, and where its time goes, in Python and natively
#   make bench-rivals  the same flights beside what else one could use; installs 2 GB and more below out/rivals
#   make bench-page    all that docs/reports/benchmarks.md says, measured anew (a quarter of an hour, on an idle machine)
#   make web     bundle what reports and the studio run in a browser (needs Node)
#   make picture film the moving picture of the README (needs a Chromium)
#   make docs    the documentation as a site; leaves site/index.html
#   make lint    style, types and the import rules
#   make clean   remove what the tools left behind (.venv and out/ stay)
#
# Another Python (3.11 or newer): make demo PYTHON=/path/to/python

find_python = for p in python3.11 python3.12 python3.13 python3.14 python3 python; do \
	  $$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 && echo $$p && break; done
PYTHON ?= $(shell $(find_python))

VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt
DEMO := out/demo

.DEFAULT_GOAL := help
.PHONY: help demo test test-slow bare bench bench-rivals bench-page web picture docs lint format clean constraints
.DELETE_ON_ERROR:

help:
	@sed -n '2,/^$$/s/^# \{0,1\}//p' Makefile

# The demo replaces what an earlier demo left, and nothing that it didn't make.
demo: $(VENV)/run.stamp
	@if [ -e $(DEMO) ] && [ ! -e $(DEMO)/report.html ]; then \
	  echo "make demo: $(DEMO) holds something else than a demo; move it away first" >&2; exit 2; fi
	@rm -rf $(DEMO)
	$(BIN)/skylimb compare paper --out $(DEMO)
	@echo "open $(DEMO)/report.html in a browser"

# A file goes to one worker, so that what its tests share is made once, and the longest files begin first.
test: $(VENV)/dev.stamp
	$(BIN)/pytest -n 2 --dist loadfile --no-loadscope-reorder -m "not slow"

# Statistics and long searches; CI runs them as well.
test-slow: $(VENV)/dev.stamp
	$(BIN)/pytest -n 2 -m slow

# What flies must not need what only an extra brings. Both environments are made anew.
bare: | $(BIN)/python
	rm -rf out/bare out/core
	$(BIN)/python -m venv out/bare
	out/bare/bin/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt .
	out/bare/bin/skylimb run --controller following --out out/bare/flight
	test -s out/bare/flight/log.nc && test ! -e out/bare/flight/report.html
	$(BIN)/python -m venv out/core
	out/core/bin/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt \
	  numpy casadi msgspec lazy-loader
	out/core/bin/python -m pip install --quiet --disable-pip-version-check --no-deps .
	out/core/bin/python tests/helpers/core_alone.py

bench: $(VENV)/run.stamp
	$(BIN)/python benchmarks/loop.py
	$(BIN)/python benchmarks/native.py

bench-rivals: $(VENV)/run.stamp
	$(BIN)/python benchmarks/compare.py

# It exits with 1 when a figure falls short of what is wanted; the page says which.
bench-page: $(VENV)/run.stamp
	$(BIN)/python benchmarks/speed.py

# Needs Node; what it makes is committed, so that nobody else does.
web:
	cd web && npm install --no-package-lock --no-audit --no-fund && npm run build
	python3 web/stamp.py
	{ echo "vendor.js contains three.js and uPlot."; echo; cat web/node_modules/three/LICENSE; echo; \
	  cat web/node_modules/uplot/LICENSE; } > src/skylimb/analysis/viewer/licences.txt

picture: $(VENV)/dev.stamp
	$(BIN)/python docs/picture.py

docs: $(VENV)/docs.stamp
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo "open site/index.html"

lint: $(VENV)/dev.stamp
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/pyright --pythonpath $(BIN)/python
	$(BIN)/lint-imports

format: $(VENV)/dev.stamp
	$(BIN)/ruff check --fix
	$(BIN)/ruff format

clean:
	rm -rf build dist site .pytest_cache .ruff_cache .import_linter_cache .hypothesis src/*.egg-info MUJOCO_LOG.TXT
	find src tests examples benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +

# Pin what a fresh environment holds now. Run it after a change of the dependencies, with the tests.
# The extra `train` brings torch, of gigabytes: what it would install is asked for instead. What is for NVIDIA's
# cards alone is left out.
constraints: $(VENV)/dev.stamp $(VENV)/docs.stamp
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --dry-run --report $(VENV)/train.json '.[train]'
	@$(BIN)/python -c 'import json, sys; \
	  print(*("{name}=={version}".format(**one["metadata"]) for one in json.load(sys.stdin)["install"]), sep="\n")' \
	  < $(VENV)/train.json > $(VENV)/train.txt
	@{ sed -n '/^#/p' constraints.txt; { $(BIN)/python -m pip freeze --all --exclude skylimb --exclude pip --exclude wheel; \
	  grep -Ev '^(skylimb|nvidia-|cuda-|triton)' $(VENV)/train.txt; } | LC_ALL=C sort -f -u; } > constraints.new
	@mv constraints.new constraints.txt

$(BIN)/python:
	@test -n "$(PYTHON)" || { echo "skylimb needs Python 3.11 or newer: make demo PYTHON=/path/to/python" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)

# The stamps say which part of pyproject.toml is installed; they are renewed when the file changes. The first has what
# the commands of README and docs/gallery.md need.
$(VENV)/run.stamp: pyproject.toml constraints.txt | $(BIN)/python
	@echo "Installing skylimb into $(VENV) (once; about a minute)"
	@$(PIP) --editable '.[report,video,draw,studio,campaign,import,logs]'
	@touch $@

$(VENV)/dev.stamp: $(VENV)/run.stamp
	@echo "Installing the test tools into $(VENV) (once)"
	@$(PIP) --editable '.[dev]'
	@touch $@

$(VENV)/docs.stamp: $(VENV)/run.stamp
	@echo "Installing the documentation tools into $(VENV) (once)"
	@$(PIP) --editable '.[docs]'
	@touch $@
