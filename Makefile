# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
# One command each; every one makes the environment that it needs.

# Python 3.11 (Blender 4.5) or 3.13 (Blender 5.2); the first of them on the PATH if not chosen.
CHECK := import sys; sys.version_info[:2] in ((3, 11), (3, 13)) or sys.exit("whittle: Python 3.11 \
(for Blender 4.5 LTS) or Python 3.13 (for Blender 5.2 LTS) is needed, and " + sys.executable + " is \
Python %d.%d: choose one, as in make test PYTHON=python3.11" % sys.version_info[:2])
PYTHON ?= $(or $(shell for python in python3 python3.13 python3.11; do \
	"$$python" -c '$(CHECK)' 2>/dev/null && echo "$$python" && break; done),python3)
OUT ?= out
SCENE ?=
SCENES ?=
JSON ?=
ARGS ?=
BLENDER ?=

# Runs what follows with the environment's Python, whose folder stands in $$venv.
in_venv = @"$(PYTHON)" -c '$(CHECK)' && venv=$$("$(PYTHON)" .ci/environment.py) && \
	PATH="$$venv/bin:$$PATH" && "$$venv/bin/python"

C_FILES = $(shell find native -name '*.[ch]' -o -name '*.inl')

.PHONY: help render test gui-test bench report stability lint format package

help:
	@echo 'make render     [SCENE=file.blend] [OUT=out]   render a scene, or the demo, with its heatmaps'
	@echo 'make test       [ARGS=...]                     all tests; ARGS goes to pytest'
	@echo 'make gui-test   BLENDER=path [ARGS=...]        the tests in Blender'"'"'s real window'
	@echo 'make bench      [SCENES="a.obj b.blend"] [JSON=out.json] speed, beside Embree and Cycles'
	@echo 'make report     [SCENE=file.blend]             error against run time, and what is left out'
	@echo 'make stability                                 extreme cases against the oracle'
	@echo 'make lint, make format                         check or apply the style'
	@echo 'make package                                   dist/whittle-VERSION.zip for Blender'
	@echo
	@echo 'PYTHON= chooses Python 3.11 (Blender 4.5 LTS) or 3.13 (Blender 5.2 LTS); now: $(PYTHON)'

render:
	$(in_venv) docs/make/render.py --out "$(OUT)" $(if $(SCENE),--scene "$(SCENE)") $(ARGS)

test:
	$(in_venv) -m pytest $(ARGS)

gui-test: package
	$(if $(BLENDER),,$(error gui-test needs a Blender that opens a window: make gui-test BLENDER=path))
	@venv=$$("$(PYTHON)" .ci/environment.py) && \
	BLENDER_WINDOW="$(BLENDER)" "$$venv/bin/python" -m pytest tests/gui -rA --show-capture=stdout $(ARGS)

bench:
	$(in_venv) native/bench/bench.py $(if $(SCENES),--scenes $(SCENES)) $(if $(JSON),--json "$(JSON)") $(ARGS)

report:
	$(in_venv) docs/make/report.py $(if $(SCENE),--scene "$(SCENE)") $(ARGS)

stability:
	$(in_venv) docs/make/stability.py $(ARGS)

lint:
	$(in_venv) -m ruff check . && python -m ruff format --check . && \
	clang-format --dry-run -Werror $(C_FILES)

format:
	$(in_venv) -m ruff check --fix . && python -m ruff format . && clang-format -i $(C_FILES)

package:
	$(in_venv) .ci/package.py
