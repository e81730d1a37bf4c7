# make demo | test | test-all | check | bench | stk | clean
PYTHON ?= $(shell command -v python3.11 || command -v python3)
PIP_FLAGS ?=
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed
# The demo also renders real game content; STK=0 skips its download of 628 MB.
STK ?= 1

.PHONY: setup gl stk demo test test-all check bench clean

setup: $(INSTALLED) gl

$(INSTALLED): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "Python 3.11 or newer is needed: make PYTHON=/path/to/python3.11"; exit 1; }
	@$(PYTHON) -c 'import ensurepip' 2>/dev/null || { echo "Python's venv module is missing: apt-get install python3-venv"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check $(PIP_FLAGS) -c constraints.txt -e '.[dev]'
	@touch $@

gl:
	@$(PYTHON) scripts/system_packages.py libegl1 libgl1 libgl1-mesa-dri

stk:
	@$(PYTHON) scripts/system_packages.py supertuxkart-data

demo: setup
	@if [ "$(STK)" = 1 ]; then $(MAKE) --no-print-directory stk || echo "Continuing with the built-in scenes only."; fi
	$(BIN)/python train.py -m model=dlctus loss.theta=0.1,0.5
	$(BIN)/python report.py
	@echo
	@echo "Compare the runs:  $(BIN)/mlflow ui --backend-store-uri sqlite:///mlflow.db"
	@echo "Read the report:   reports/out/overview.pdf"

test: setup check
	$(BIN)/python -m pytest -n 2 --dist worksteal

test-all: setup check
	$(BIN)/python -m pytest -m '' -n 2 --dist worksteal

check: $(INSTALLED)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: setup
	$(BIN)/python scripts/timing/loop.py
	$(BIN)/python scripts/timing/step.py
	$(BIN)/python scripts/timing/dlctus.py
	$(BIN)/python scripts/timing/memory.py
	$(BIN)/python scripts/timing/gradient.py
	$(BIN)/python scripts/timing/render.py

clean:
	rm -rf $(VENV) .pytest_cache .ruff_cache .mypy_cache
