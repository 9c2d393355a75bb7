# Every target builds .venv when it is needed; python3 >= 3.11 with venv is all that must be there.
# Another interpreter: `make test PYTHON=python3.12`.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
# Not everything that is installed is imported: what is, is compiled to bytecode then.
PIP    := $(BIN)/python -m pip --disable-pip-version-check install -qq --progress-bar off --no-compile --constraint constraints.txt

# One thread each: the kernels are single-threaded, and small machines stay usable.
export NUMBA_NUM_THREADS    ?= 1
export OMP_NUM_THREADS      ?= 1
export OPENBLAS_NUM_THREADS ?= 1
export MPLBACKEND           ?= Agg
# Without bytecode each start compiles numba, numpy and scipy anew: 3 s in place of 1.4 s.
unexport PYTHONDONTWRITEBYTECODE

SMALL := tests/test_compiled.py tests/test_boxing.py tests/test_plain.py tests/planners/test_answers.py

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help demo test tested slow bench lint format docs numba-test wheel wheel-test clean distclean

help:  ## show this list
	@grep -hE '^[a-z-]+:.*##' $(firstword $(MAKEFILE_LIST)) | awk -F ':.*## ' '{printf "  make %-10s %s\n", $$1, $$2}'

demo: $(VENV)/.core  ## solve the paper's scenes and 200 random ones, with figures, into demo/
	$(BIN)/gcm-learn demo --out demo

# Two at once, most of whose time is compiling on a new machine; who is done helps the other.
test: $(VENV)/.dev  ## everything that must pass: style, types, import direction, tests
	@$(MAKE) --no-print-directory --jobs 2 lint tested

tested: $(VENV)/.dev
	$(BIN)/python -m pytest -n 2 --dist worksteal

slow: $(VENV)/.dev  ## the tests that take minutes
	$(BIN)/python -m pytest -m slow

lint: $(VENV)/.dev  ## style, types and import direction only
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo

format: $(VENV)/.dev  ## rewrite the sources in the house style
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: $(VENV)/.dev peers  ## measure the kernels on one core, next to their peers; then datasets, the arena and the arm with mass
	$(BIN)/python -m experiments benchmarks
	$(BIN)/python -m experiments benchmarks/space
	$(BIN)/python -m experiments benchmarks/dataset
	$(BIN)/python -m experiments benchmarks/arena
	$(BIN)/python -m experiments benchmarks/first_catch
	$(BIN)/python -m experiments benchmarks/body

docs: $(VENV)/.dev  ## build the documentation site in build/site; notebooks are executed
	$(BIN)/python -m sphinx -b html -W --keep-going docs build/site

# With the oldest and the newest numba, and with the newest as it is by itself.
numba-test:  ## a small part of the tests with other versions of numba
	for numba in "numba==0.61.*" "numba"; do \
	  rm -rf build/numba && $(PYTHON) -m venv build/numba && \
	  build/numba/bin/pip install -q "$$numba" --editable . pytest hypothesis && \
	  build/numba/bin/python -m pytest -q $(SMALL) || exit 1; \
	done
	GCM_LEARN_PLAIN=1 build/numba/bin/python -m pytest -q tests/test_plain.py tests/planners/test_answers.py

wheel:  ## build the wheel, and one with compiled kernels for it, into dist/
	rm -rf build/wheel dist && $(PYTHON) -m venv build/wheel && build/wheel/bin/pip install -q build
	build/wheel/bin/python -m build --outdir dist .
	build/wheel/bin/pip install -q -c constraints.txt dist/gcm_learn-*.whl gymnasium
	build/wheel/bin/gcm-learn warm-up --wheel dist

wheel-test: wheel  ## install both wheels into an empty environment, and time first answers there
	rm -rf build/wheel-test && mkdir -p build/wheel-test && $(PYTHON) -m venv build/wheel-test/venv
	build/wheel-test/venv/bin/pip install -q -c constraints.txt dist/*.whl gymnasium
	cd build/wheel-test && venv/bin/gcm-learn draw gate --count 3 --out gates.jsonl && venv/bin/gcm-learn solve gates.jsonl --planner hybrid > answers.jsonl
	cd build/wheel-test && venv/bin/python ../../tests/installed.py

clean:  ## remove what was built, except .venv
	rm -rf demo build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find . -path ./$(VENV) -prune -o -name __pycache__ -type d -prune -exec rm -rf {} +

distclean: clean  ## remove .venv as well
	rm -rf $(VENV)

# --- the environment: each stamp says that what it is named after is installed ---------------

$(VENV)/.created:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "gcm_learn needs Python 3.11 or later, and '$(PYTHON)' is: $$($(PYTHON) --version 2>&1)." >&2; \
	  echo "Name another one: make $(or $(MAKECMDGOALS),test) PYTHON=python3.12" >&2; exit 1; }
	@echo "Building $(VENV) with $$($(PYTHON) --version) ..."
	@$(PYTHON) -m venv $(VENV) || { \
	  echo "'$(PYTHON) -m venv' failed; on Debian and Ubuntu: apt install python3-venv." >&2; exit 1; }
	@touch $@

$(VENV)/.core: $(VENV)/.created pyproject.toml constraints.txt
	@echo "Installing gcm_learn (a minute or two the first time) ..."
	@$(PIP) --editable .
	@touch $@

$(VENV)/.dev: $(VENV)/.created pyproject.toml constraints.txt
	@echo "Installing gcm_learn and all that its tests need (a few minutes the first time) ..."
	@$(PIP) "$$(grep '^torch==' constraints.txt)"  # as a range it would bring CUDA along
	@$(PIP) --editable ".[dev]"
	@touch $@ $(VENV)/.core

# scikit-fmm is built from source. Without a compiler the benchmark still runs and leaves it out.
.PHONY: peers
peers: $(VENV)/.dev
	@$(BIN)/python -c 'import skfmm' 2>/dev/null || { \
	  echo "Building scikit-fmm for the comparison ..."; \
	  $(PIP) scikit-fmm || \
	  echo "scikit-fmm could not be built: its comparison is left out." >&2; }
