PYTHON ?= python3
BIN := .venv/bin

.PHONY: help diagram gallery scenes reference notebooks docs test lowest slow promises mutants fuzz crash cluster many measured bench release clean
help:     ## what there is to make
	@grep -E '^[a-z-]+: ' Makefile | sed -E 's/:[^#]*## /\t/' | expand -t 16

.venv/run: pyproject.toml
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable .
	touch $@

.venv/test: pyproject.toml
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable '.[test]'
	touch $@ .venv/run

diagram: .venv/run    ## compute and draw the transition diagram of the paper's system
	$(BIN)/irg run workflows/irg_transition.toml --set sweep.realizations=1
	$(BIN)/irg run workflows/irg_transition.toml --accuracy 3%
	$(BIN)/irg plot results/irg_transition.zarr --kind diagram -o results/irg_transition.png

gallery: .venv/run    ## recompute every figure and table of the paper, and their page
	$(BIN)/irg paper all -o workflows

SCENES = cam_tappet gear_mesh roller designs own_rig srv ground_ring scan
scenes: .venv/run     ## run the scenes of workflows/SCENES.md and draw their pictures, in some minutes
	for scene in $(SCENES); do \
	    kind=; test $$scene = srv && kind="--kind tests"; \
	    $(BIN)/irg run $$scene && $(BIN)/irg plot $$scene $$kind --width "14 cm" --dpi 100 --plain \
	        -o workflows/$$scene.png || exit 1; done
	$(BIN)/irg trade first_try -j 1 --store results/trade.zarr -o workflows/trade.png

reference: .venv/test ## write the references of scene file, dataset, commands and Python, and all that is kept, again
	$(BIN)/python -m tests.sources.reference
	IRG_WRITE_KEPT=1 OMP_NUM_THREADS=1 $(BIN)/python -m pytest -q tests -k are_kept

notebooks: .venv/test ## run the notebooks, and store what their cells show, in 2 minutes
	OMP_NUM_THREADS=1 $(BIN)/python -m workflows.notebooks

docs: .venv/test      ## build the site of all pages into results/docs
	$(BIN)/sphinx-build -E -a -W --keep-going -q -c workflows workflows results/docs
	@echo "results/docs/index.html"

test: .venv/test      ## style, types, import rules, the test suite; prints the lines of code of each room
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	PYTHONDONTWRITEBYTECODE= OMP_NUM_THREADS=1 \
	    $(BIN)/python -m pytest --numprocesses 3 --dist loadfile --no-loadscope-reorder --durations=25
	$(BIN)/python -m tests.sources

lowest:               ## install the lowest versions that are declared, and run the test suite
	test -x .venv-lowest/bin/python || $(PYTHON) -m venv .venv-lowest
	.venv-lowest/bin/python -m pip install --quiet uv
	.venv-lowest/bin/uv pip install --quiet --python .venv-lowest/bin/python \
	    --resolution lowest-direct --editable '.[test]'
	PYTHONDONTWRITEBYTECODE= OMP_NUM_THREADS=1 \
	    .venv-lowest/bin/python -m pytest -W ignore::DeprecationWarning \
	    --numprocesses 2 --dist loadfile --no-loadscope-reorder --durations=10

slow: .venv/test      ## the long checks: pages as typed, the site, a notebook, campaigns, clusters, kills
	$(BIN)/python -m pytest tests -m slow

promises: .venv/test  ## judge presets, stated errors and accuracies that are asked for on random scenes, in some hours
	OMP_NUM_THREADS=1 $(BIN)/python -m tests.promises.front
	OMP_NUM_THREADS=1 $(BIN)/python -m tests.promises.positions
	OMP_NUM_THREADS=1 $(BIN)/python -m tests.promises.pins
	OMP_NUM_THREADS=1 $(BIN)/python -m tests.promises.moving_disk
	OMP_NUM_THREADS=1 $(BIN)/python -m tests.promises.errors
	OMP_NUM_THREADS=1 $(BIN)/python -m tests.promises.realizations
	OMP_NUM_THREADS=1 $(BIN)/python -m tests.promises.loads
	OMP_NUM_THREADS=1 $(BIN)/python -m tests.promises.goals
	OMP_NUM_THREADS=1 $(BIN)/python -m tests.promises.laboratories
	OMP_NUM_THREADS=1 $(BIN)/python -m tests.promises.inputs

mutants: .venv/test   ## change formulas, bounds, rules and sentences: the tests of each room notice it, in minutes
	$(BIN)/python -m tests.mutants

fuzz: .venv/test      ## mutate scans, tables and scenes: each is read or refused in a line, for 3 minutes
	OMP_NUM_THREADS=1 $(BIN)/python -m tests.fuzz

crash: .venv/test     ## kill sweeps, cut their power, damage their files, alone and in pairs, for 25 minutes
	$(BIN)/python -m tests.crash

cluster: .venv/test   ## a real Slurm, if that of the distribution is installed, in 15 minutes
	$(BIN)/python -m tests.cluster

many: .venv/test      ## 100000 cheap points in one store, and what they cost, in 10 to 20 minutes
	$(BIN)/python -m tests.crash.many

measured: .venv/test ## name the figures of workflows/MEASURED.md that are older than their code, and the constants of campaigns
	$(BIN)/python -m tests.measured --older
	$(BIN)/python -m tests.sources.constants

.venv-peers/ready: pyproject.toml tests/benchmarks/peers.txt
	test -x .venv-peers/bin/python || $(PYTHON) -m venv .venv-peers
	.venv-peers/bin/python -m pip install --quiet --editable .
	grep -v '^#' tests/benchmarks/peers.txt | while read -r peer; do \
	    .venv-peers/bin/python -m pip install --quiet $$peer || echo "not installed: $$peer"; done
	touch $@

bench: .venv-peers/ready  ## measure speed beside other solvers, which it installs, as ratios within one run
	OMP_NUM_THREADS=1 .venv-peers/bin/python -m tests.benchmarks.speed

INDEX = http://127.0.0.1:18795
release:              ## sdist and wheel in results/dist, uploaded to an index here, and tried from there
	rm -rf results/dist .venv-release .venv-tried
	$(PYTHON) -m venv .venv-release
	# twine and pkginfo are those of the publisher that release.yml pins.
	.venv-release/bin/python -m pip install --quiet 'hatchling>=1.27' 'hatch-fancy-pypi-readme>=24.1' \
	    twine==5.0.0 pkginfo==1.10.0 'pypiserver>=2.3'
	.venv-release/bin/hatchling build -d results/dist
	.venv-release/bin/twine check --strict results/dist/*
	$(PYTHON) -m venv .venv-tried
	mkdir .venv-release/index
	.venv-release/bin/pypi-server run -p 18795 -i 127.0.0.1 -P . -a . .venv-release/index & \
	    trap "kill $$!" EXIT; sleep 3; \
	    .venv-release/bin/twine upload --repository-url $(INDEX) -u none -p none \
	        --disable-progress-bar results/dist/* && \
	    .venv-tried/bin/python -m pip install --quiet --extra-index-url $(INDEX)/simple irg-transition
	mkdir .venv-tried/away
	cd .venv-tried/away && ../bin/irg run first_try -o first_try.zarr
	cd .venv-tried/away && ../bin/irg boundary first_try.zarr
	cd .venv-tried/away && ../bin/irg help physics > page.md && ../bin/irg new --list
	rm -rf .venv-release .venv-tried

clean:                ## remove what was made, results included
	rm -rf .venv .venv-lowest .venv-peers .venv-release .venv-tried results
