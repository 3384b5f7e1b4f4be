# make run    set up what is missing, then run the main example into out/yard
# make test   set up what is missing, then run every test, on all cores
# make fast   the tests of the engine alone;  make test-of FILE=graph/plan/types.py   the tests of one file
# make lint   ruff and mypy;  make bench   the measurements;  make clean   forget .venv and out
# make pictures  play the graphs whose pictures README shows, and draw them (some minutes)
# make peers  install what the measurements compare with;  make wheel  build it, with the compiled loops

VENV := .venv
BIN := $(VENV)/bin
PIP := @$(BIN)/python .ci/pip
PINS := .ci/constraints.txt
# Where PYTHONDONTWRITEBYTECODE is set, every start would compile what it imports.
COMPILE := @echo "compiling its Python files" && $(BIN)/python -m compileall -q graph nodes sensors wings
# More options for pytest: make test PYTEST="-k lidar --cov"
PYTEST :=
FAST := $(addprefix tests/graph/,base values node spec plan evaluate) tests/nodes/action
FILE :=
SOURCES := graph nodes sensors wings tests graphs .github/pictures

.PHONY: run test fast test-of lint bench pictures peers wheel clean system-libraries
.DELETE_ON_ERROR:

run: system-libraries $(VENV)/run.stamp
	$(BIN)/graph run graphs/yard.yaml --out out/yard --preview

test: system-libraries $(VENV)/dev.stamp
	$(BIN)/python -m pytest --numprocesses auto $(PYTEST)

fast: $(VENV)/dev.stamp
	$(BIN)/python -m pytest --numprocesses auto $(FAST) $(PYTEST)

test-of: $(VENV)/dev.stamp
	$(BIN)/python -m tests.support.covering $(FILE) -- $(PYTEST)

lint: $(VENV)/dev.stamp
	$(BIN)/ruff check $(SOURCES)
	$(BIN)/ruff format --check $(SOURCES)
	$(BIN)/mypy

bench: system-libraries $(VENV)/dev.stamp
	$(BIN)/python tests/benchmarks/run.py

pictures: system-libraries $(VENV)/dev.stamp
	$(BIN)/python .github/pictures

# mujoco-lidar is satisfied with mujoco-core; the package mujoco that it names would replace it with an older engine.
peers: $(VENV)/dev.stamp
	$(PIP) install -c $(PINS) --no-build-isolation --editable '.[bench]'
	$(PIP) install -c $(PINS) --no-deps mujoco-lidar

wheel: system-libraries $(VENV)/dev.stamp
	$(BIN)/python -m sensors.compiled
	$(PIP) wheel --no-build-isolation --no-deps --wheel-dir dist .
	@ls dist/*.whl

clean:
	rm -rf $(VENV) out build dist sensors/compiled/shipped

system-libraries: $(VENV)/python.stamp
	@.ci/system-libraries $(BIN)/python

# The build backend is pinned and installed like any other package, so that no step resolves versions on its own.
$(VENV)/python.stamp: $(PINS)
	@python=$$(.ci/find-python) && echo "$$python -m venv $(VENV)" && "$$python" -m venv $(VENV)
	$(PIP) install -c $(PINS) hatchling editables
	@touch $@

$(VENV)/run.stamp: $(VENV)/python.stamp pyproject.toml $(PINS)
	@echo "installing the libraries into $(VENV): about 1.2 GB on disk"
	$(PIP) install -c $(PINS) --no-build-isolation --editable .
	$(COMPILE)
	$(BIN)/graph doctor --warm
	@touch $@

$(VENV)/dev.stamp: $(VENV)/python.stamp pyproject.toml $(PINS)
	@echo "installing the libraries, and what tests need, into $(VENV): about 2.0 GB on disk"
	$(PIP) install -c $(PINS) --no-build-isolation --editable '.[dev,gl,foxglove,dds,zenoh,gpu]'
	$(PIP) install -c $(PINS) --no-deps mujoco-warp
	$(COMPILE)
	$(BIN)/graph doctor --warm
	@touch $@ $(VENV)/run.stamp
