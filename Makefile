# Only Python 3.11 or later and make are needed; everything else comes from requirements.lock.
PYTHON ?= python3
BIN := .venv/bin
JOBS ?= $(shell $(PYTHON) -c "import os; print(os.cpu_count() or 1)")

.PHONY: report quick test thorough cross-check lint docs summary manual sweep frames benchmarks lock clean

report: .venv/ready
	$(BIN)/workbench run thesis_column --jobs $(JOBS)
	$(BIN)/workbench report thesis_column

quick: .venv/ready
	$(BIN)/workbench run thesis_column --quick --jobs $(JOBS)
	$(BIN)/workbench report thesis_column --quick

# What takes seconds is marked `thorough` and has a target of its own; CI runs both.
test: .venv/ready
	$(BIN)/python -m pytest -q -n $(JOBS) -m "not thorough"

thorough: .venv/ready
	$(BIN)/python -m pytest -q -n $(JOBS) -m thorough

# Other programs beside ours: OpenSees under its own licence, and CalculiX where ccx is installed.
cross-check: .venv/ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check openseespy
	$(BIN)/python -m pytest -q -n $(JOBS) tests/cross_check tests/extras/exchange

lint: .venv/ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

# The documentation as a site, in build/docs; its tools have a lock of their own.
docs: .venv/docs
	$(BIN)/sphinx-build -q -W --keep-going -b html docs build/docs
	@echo "build/docs/index.html"

.venv/docs: .venv/ready docs/requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r docs/requirements.lock
	touch $@

# The flagship's verdicts and pictures that are kept in git.
summary: report
	$(BIN)/workbench report thesis_column --summary reports

# The table of what tests claim, and the page of the manual made from it.
manual: .venv/ready
	$(BIN)/python -m pytest -q -n $(JOBS) -m claim --manual
	$(BIN)/python docs/reference/generate.py

sweep: .venv/ready
	$(BIN)/workbench run column_sweep --jobs $(JOBS)
	$(BIN)/workbench report column_sweep

frames: .venv/ready
	$(BIN)/workbench run thesis_frame_impact --jobs $(JOBS)
	$(BIN)/workbench report thesis_frame_impact

benchmarks: .venv/ready
	$(BIN)/python benchmarks/column_models.py
	$(BIN)/python benchmarks/batches.py
	$(BIN)/python benchmarks/growth.py
	$(BIN)/python benchmarks/frames.py
	$(BIN)/python benchmarks/page.py

# Python compiles of the libraries what it imports; kernels are compiled here, on all cores.
.venv/ready: requirements.lock pyproject.toml
	@$(PYTHON) -c "import sys; sys.exit(sys.version_info < (3, 11))" \
	  || { echo "Python 3.11 or later is needed: make PYTHON=python3.12"; exit 1; }
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile --no-deps --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	$(BIN)/workbench warm --jobs $(JOBS)
	touch $@

# Renew the pins: needs pip-tools.
lock:
	pip-compile --quiet --strip-extras --generate-hashes --allow-unsafe --no-header --no-annotate \
	  --no-emit-index-url --no-emit-find-links --extra app --extra test --extra lint --extra build \
	  --output-file requirements.lock pyproject.toml

	pip-compile --quiet --strip-extras --generate-hashes --allow-unsafe --no-header --no-annotate \
	  --no-emit-index-url --no-emit-find-links --no-emit-trusted-host --constraint requirements.lock \
	  --output-file docs/requirements.lock docs/requirements.in

clean:
	rm -rf .venv build dist
