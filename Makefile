# Every target sets up what it needs in a virtual environment of its own, .venv, and says so.
# Another Python: make test PYTHON=python3.12

PYTHON ?= python3
VENV   ?= .venv
SIZE   ?= full
OUT    ?= out
SET    ?= all
BASE   ?=
FUZZ_MINUTES ?= 60
JOBS   ?= auto
BIN     = $(VENV)/bin
PACKAGE = $(VENV)/.package-ready
READY   = $(VENV)/.ready
DOCS    = $(VENV)/.docs-ready
# Tests of a file mostly stay in one process, which makes what they share once.
PARALLEL = -n $(JOBS) --dist worksteal

.PHONY: help demo test cover fuzz lint types dist versions docs peers bench bars guard check kernels clean

help:
	@echo "make demo    a first shell, then the example of the paper; tables here, pictures and files in $(OUT)/"
	@echo "make test    run the tests, on all cores (JOBS=0: in one process)"
	@echo "make cover   the same, and which lines of the package they ran: table here, pages in $(OUT)/cover"
	@echo "make fuzz    problems made by chance, until FUZZ_MINUTES=60 are over; what fails is kept in $(OUT)/fuzz as Python"
	@echo "make docs    build the documentation into docs/_build/html"
	@echo "make site    look at the built pages in a browser without a window: layout, contrast, links, search (needs chromium)"
	@echo "make peers   install the programs that skancf is compared with, each in an environment of its own below benchmarks/peers"
	@echo "make bench   speed against accuracy, beside those that are installed, and what each part costs (an hour; SET=quick: 5 minutes)"
	@echo "make bars    are error bars right, and not too large? Scenes with known answers (half an hour)"
	@echo "make guard   is anything more than 20 % slower than what benchmarks/results/guard.json says? (under 90 s)"
	@echo "             BASE=COMMIT: more than 5 % slower than that commit? both measured in turns (under 5 minutes)"
	@echo "make check   lint and types, of the package and of the demos"
	@echo "make dist    build sdist and wheel into dist/, look into them, and run the wheel in a clean environment"
	@echo "make versions run chosen tests with the oldest supported versions of all dependencies, and with the newest"
	@echo "make kernels forget the compiled kernels (after an edit of a constant that one uses from a file without kernels)"
	@echo "make clean   remove the virtual environment, caches and $(OUT)/"

$(PACKAGE): pyproject.toml
	@echo "== setting up $(VENV) with $$($(PYTHON) --version): the package and its solver (a minute or two, once)"
	@$(PYTHON) -c 'import sys; v = sys.version_info; sys.exit(v < (3, 10) and "Python >= 3.10 is needed, this is %d.%d: make PYTHON=python3.x" % v[:2])'
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV) || { echo "== no module venv: on Debian, apt-get install python3-venv"; exit 1; }
	@$(BIN)/python -m pip install --disable-pip-version-check --editable '.[fast]'
	@touch $@

$(READY): $(PACKAGE)
	@echo "== adding the test tools to $(VENV)"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[fast,dev]'
	@touch $@

$(DOCS): $(READY)
	@echo "== adding the documentation tools to $(VENV)"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[docs]'
	@touch $@

demo: $(PACKAGE)
	$(BIN)/skancf demo --out $(OUT)
	$(BIN)/python demos/plot_01_paper_example.py --size $(SIZE) --out $(OUT)

test: $(READY)
	$(BIN)/python -m pytest $(PARALLEL)

cover: $(READY)
	$(BIN)/python -m pytest $(PARALLEL) --cov --cov-report=term --cov-report=html:$(OUT)/cover
	@echo "== $(OUT)/cover/index.html"

fuzz: $(READY)
	PYTHONPATH=tests $(BIN)/python -m fuzz --minutes $(FUZZ_MINUTES) --out $(OUT)/fuzz

lint: $(READY)
	$(BIN)/python -m ruff check .
	$(BIN)/python -m ruff format --check .

types: $(READY)
	$(BIN)/python -m mypy
	$(BIN)/python -m mypy --allow-untyped-defs --allow-incomplete-defs demos

check: lint types

docs: $(DOCS)
	SKANCF_DEMO_SIZE=$(SIZE) $(BIN)/python -m sphinx -b html -W --keep-going -q docs docs/_build/html
	@echo "== docs/_build/html/index.html"

site: $(DOCS)
	$(BIN)/python docs/check_site.py

dist: $(READY)
	$(BIN)/python .ci/wheel.py build
	$(BIN)/python .ci/wheel.py try

versions: dist
	$(BIN)/python .ci/wheel.py versions

peers: $(READY)
	$(BIN)/python -m benchmarks.setup_peers

bench: $(READY)
	$(BIN)/python -m benchmarks.bench $(SET)

bars: $(READY)
	$(BIN)/python -m benchmarks.bars.run

guard: $(READY)
	$(BIN)/python benchmarks/$(if $(BASE),guard_commits.py $(BASE),guard.py check)

kernels:
	find skancf -name '*.nb[ic]' -delete

clean:
	rm -rf $(VENV) $(OUT) .pytest_cache .mypy_cache .ruff_cache .coverage dist docs/_build docs/gallery docs/api/generated skancf.egg-info
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
