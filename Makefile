# Two commands for a newcomer: `make demo` flies a mission, `make test` proves the installation.
# Only Python 3.11 or newer and make are needed; everything else goes into the folder .venv.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
SOURCES := pyproject.toml README.md $(shell find aerosim aircraft terrain scenarios -type f -not -path '*/__pycache__/*' | sed 's/ /\\ /g')

.PHONY: demo test test-slow lint bench docs clean

demo: $(VENV)/installed
	$(BIN)/aerosim run crosswind --out runs/demo --overwrite
	@echo
	@echo "The run is in runs/demo.  Look at it:"
	@echo "  the report, in any browser    runs/demo/report.html"
	@echo "  the flight in the viewer      $(BIN)/aerosim view runs/demo"
	@echo "  the same in a browser         $(BIN)/aerosim view runs/demo --web"

test: $(VENV)/installed-test
	$(BIN)/pytest -n 2 --dist loadfile

test-slow: $(VENV)/installed-test
	$(BIN)/pytest -n 2 --dist loadfile -m slow

lint: $(VENV)/installed-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: $(VENV)/installed-test
	for file in benchmarks/*.py; do echo "== $$file"; $(BIN)/python "$$file" || exit 1; done

docs: $(VENV)/installed-test
	$(BIN)/python -m aerosim.scenario.reference > docs/scenario.md
	$(BIN)/python docs/make_figures.py
	$(BIN)/python docs/control_figures.py

$(VENV)/made:
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "aerosim needs Python 3.11 or newer")'
	$(PYTHON) -m venv $(VENV)
	touch $(VENV)/made

$(VENV)/installed: $(VENV)/made $(SOURCES)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check .
	touch $(VENV)/installed

$(VENV)/installed-test: $(VENV)/installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check '.[test]'
	touch $(VENV)/installed-test

clean:
	rm -rf $(VENV) runs build dist
