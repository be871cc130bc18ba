# followspot from a bare checkout: set-up, demonstration, tests. `make` alone lists the targets.

# A Python of 3.11 or newer, if not the first that is found.
PYTHON ?=
export PYTHON

BIN := .venv/bin
OPENARENA := openarena-081-maps openarena-081-textures openarena-085-data openarena-088-data \
    openarena-081-players openarena-081-misc openarena-oacmp1 \
    openarena ioquake3 xvfb xauth xdotool chromium assimp-testmodels

.PHONY: help demo test clean

help:
	@echo 'make demo    set up what is missing and show the built-in scene in out/demo/'
	@echo 'make test    set up what is missing and run all checks and tests'
	@echo 'make clean   remove all that these make, .venv included'

demo: .venv/ready
	$(BIN)/followspot render courtyard --camera title --bake --size 1280x720 -o out/demo/title.png
	$(BIN)/followspot report robots --size 640x480 --max-bytes 2000000 --jobs 2 -o out/demo/report
	@echo 'Look at out/demo/title.png, out/demo/report/film.mp4 and out/demo/report/index.html'

# Cheap checks first. CI leaves nothing out: there the tests on OpenArena's levels fail without it.
test: .venv/ready-dev
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports
	@if scripts/setup debian $(OPENARENA) || [ "$$CI" = true ]; then \
	    $(BIN)/python -m pytest; \
	else \
	    $(BIN)/python -m pytest -m 'not openarena'; result=$$?; \
	    echo "The tests on OpenArena's levels were left out. To run them: sudo apt-get install" \
	        $(OPENARENA); \
	    exit $$result; \
	fi

.venv/ready: pyproject.toml constraints.txt scripts/setup
	scripts/setup package
	touch $@

.venv/ready-dev: pyproject.toml constraints.txt scripts/setup
	scripts/setup package dev
	touch .venv/ready $@

clean:
	rm -rf .venv out build dist src/*.egg-info .mypy_cache .ruff_cache .pytest_cache \
	    .hypothesis .import_linter_cache
	find src tests -name __pycache__ -prune -exec rm -rf {} +
