# `make help` lists the targets. All of them work from a clean checkout and may be run again at any time.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
WORKERS ?= auto
ENVIRONMENT := PYTHONUNBUFFERED=1 $(if $(filter Linux,$(shell uname)),PORELANG_TEST_GL=required PORELANG_TEST_BROWSER=required)

.DEFAULT_GOAL := help
.PHONY: help demo figures comparison test test-fast fuzz check gl browser bench bench-peers lint golden docs grammar editors page clean

help:  ## list the targets
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-12s %s\n", $$1, $$2}'

$(READY): pyproject.toml
	@echo "== making $(VENV) and installing porelang with what its tests need"
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	  || { echo "Python 3.11 or newer is needed: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	@$(PYTHON) -m venv $(VENV) || { echo "the venv module is missing: apt-get install python3-venv"; exit 1; }
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --upgrade pip
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@$(BIN)/python -m compileall -q porelang  # so that `pore` starts without compiling itself
	@$(BIN)/python examples/warm.py  # nor its first mesh, nor its first look at data
	@touch $@

demo: $(READY)  ## compile examples/specimen.pore to out/specimen.stl and out/specimen.png, close the loop from stress to walls, print reports
	@mkdir -p out
	@$(BIN)/pore mesh examples/specimen.pore --voxel 1.2mm -o out/specimen.stl
	@$(BIN)/pore render examples/specimen.pore -o out/specimen.png --size 900x1100 \
	  || { echo "== no picture through OpenGL: drawing the mesh with NumPy"; \
	       $(BIN)/python examples/picture.py out/specimen.stl out/specimen.png; }
	@$(BIN)/pore fea examples/closed_loop.pore -o out/closed_loop.vtu
	@$(BIN)/pore mesh examples/closed_loop.pore --voxel 2mm -o out/closed_loop.stl

figures: gl  ## draw every figure of the paper, examples/figures/*.pore, into docs/figures
	@$(BIN)/python examples/figures/draw.py docs/figures

comparison: $(READY)  ## write docs/comparison.md, the specimens of Figures 8 to 10 under load; solves what examples/figures/comparison.jsonl lacks
	@$(BIN)/python examples/figures/compare.py docs/comparison.md

gl: $(READY)
	@PATH="$(CURDIR)/$(BIN):$$PATH" sh .ci/gl

browser:
	@sh .ci/browser

test: gl browser lint  ## run the linters and the whole suite (installs Mesa's software OpenGL and Chromium where there is none)
	@echo "== pytest"
	@$(ENVIRONMENT) $(BIN)/python -m pytest -n $(WORKERS)

test-fast: $(READY)  ## the tests that take no second each, in less than a minute: not a substitute for `make test`
	@$(BIN)/python -m pytest -n $(WORKERS) -m "not slow"

fuzz: gl  ## COUNT=10000 random programs on every backend, from SEED (default: the date); failures go to tests/regressions
	@$(BIN)/python tests/fuzz.py $(if $(SEED),--seed $(SEED)) $(if $(COUNT),--count $(COUNT))

lint: $(READY)  ## ruff and mypy --strict
	@echo "== ruff, mypy"
	@$(BIN)/ruff check .
	@$(BIN)/mypy porelang

bench: $(READY)  ## time the compiler, the evaluation and the meshing of the examples
	@$(BIN)/python benchmarks

bench-peers: $(READY)  ## install what the benchmark compares with (VTK, scikit-image, PoreSpy, microgen, tpmslab) into .peers, and run it
	@$(BIN)/python benchmarks --peers

golden: $(READY)  ## rewrite the texts that tests compare with; look at the diff before you keep it
	@PORELANG_GOLDEN=1 $(BIN)/python -m pytest tests/test_errors.py
	@git --no-pager diff --stat -- tests/errors

docs: $(READY)  ## write the generated parts of docs/language.md anew
	@$(BIN)/python docs/generate.py

grammar: $(READY)  ## write grammar/pore.lalr.json, the tables of grammar/pore.lark, anew
	@PYTHONHASHSEED=0 $(BIN)/python -c 'from porelang.syntax.parse import tables; print(tables(), end="")' > grammar/made
	@mv grammar/made grammar/pore.lalr.json

editors: $(READY)  ## write what editors colour by, editors/vscode/pore.tmLanguage.json and editors/page/src/patterns.js, anew
	@$(BIN)/python editors/generate.py

page: editors  ## bundle the editor of pore view and the widget of notebooks; needs node 20 and npm
	@cd editors/page && npm ci --ignore-scripts --no-audit --no-fund && node build.js

clean:  ## remove the environment, caches and out/
	rm -rf $(VENV) .peers editors/page/node_modules out build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find porelang tests docs examples benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +
