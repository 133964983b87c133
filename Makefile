# SPDX-License-Identifier: GPL-2.0-or-later
# The commands of FloeFlow: `make help` lists them. What they do lies in setup/*.sh.
#   SCENE=config/scenes/x.yaml  the scene to run         RANKS=2  processes of the dynamics
#   PYTHON=, LIGGGHTS_ROOT=, NO_APT=1                    see docs/install.md
SHELL := bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
MAKEFLAGS += --no-print-directory

SCENE ?= config/scenes/arctic_1981.yaml
RANKS ?=
AGAINST ?=
FUZZ_SECONDS ?= 300
# Recipes read them from the environment: no quote in a value can end a command.
export PYTHON LIGGGHTS_ROOT NO_APT SCENE RANKS AGAINST FUZZ_SECONDS

.PHONY: help setup run year test test-slow test-browser setup-cluster test-cluster slurm-demo verification stability fuzz lint gallery bench-dem bench-column bench-remap bench-packing bench-plan bench-scaling bench-year bench studies docs doctor test-fresh lock tag clean

help: ## list these targets
	@sed -n -E 's/^([a-z-]+):.*## (.*)/make \1\t\2/p' Makefile | expand -t 18

setup: ## install what is missing and build the plugin
	@setup/install.sh

run: setup ## set up, then run SCENE= and print where its report lies
	@.venv/bin/snakemake --profile workflows/profiles/local \
	    --config "scene=$$SCENE" $(if $(RANKS),--cores "$$RANKS" --set-threads "windows=$$RANKS")

year: ## run the Arctic for a year with every effect, and print where its report lies
	@$(MAKE) run SCENE=config/scenes/arctic_year.yaml

test: setup lint ## set up, then run lint and every test but the slow ones
	ctest --test-dir build/liggghts_models --output-on-failure --parallel 2 --label-exclude slow
	@setup/test.sh

test-slow: setup ## the tests that take minutes and belong to neither verification nor stability
	ctest --test-dir build/liggghts_models --output-on-failure --label-regex slow
	.venv/bin/python -m pytest -m "slow and not verification and not stability" tests

test-browser: setup ## open a report in Chromium: quiet, offline, moved by keys; screenshots in results/browser
	@setup/browser.sh
	.venv/bin/python -m pytest -m browser tests/browser

setup-cluster: setup ## install Snakemake's plugins for clusters (docs/how-to/cluster.md)
	@setup/cluster.sh

test-cluster: setup ## run the workflow on a private Slurm, which this installs where it may
	@setup/cluster.sh --slurm
	.venv/bin/python -m pytest -rs -m cluster tests/cluster

slurm-demo: setup ## run `smoke` through both cluster profiles on a private Slurm (as root)
	@setup/cluster.sh --slurm
	@setup/slurm_demo.sh

verification: setup ## compare with theory and references at length, draw docs/images/verification
	.venv/bin/python -m pytest -m verification --references --figures tests/verification

stability: setup ## run the hard cases at length: results/stability/stability.html, docs/hard_cases.md
	.venv/bin/python -m pytest -q -m stability --figures \
	    --record results/stability/records.json tests/stability || test -s results/stability/records.json
	.venv/bin/snakemake --profile workflows/profiles/local -- results/stability/stability.html
	.venv/bin/python -m floeflow.analysis.studies.hard_cases

fuzz: setup ## fuzz the reader of states for FUZZ_SECONDS=300, what breaks it lands in results/fuzz
	@for target in bytes fields; do .venv/bin/python tests/stability/fuzz_state.py $$target \
	    results/fuzz -max_total_time="$$(( FUZZ_SECONDS / 2 ))" -timeout=60; done

lint: setup ## check style, types, formats and what is generated
	@setup/lint.sh

gallery: setup ## draw the packings of the example scenes and docs/gallery.md (minutes)
	.venv/bin/python -m floeflow.analysis.gallery

bench-dem: setup ## time the element model beside stock LIGGGHTS and memory; AGAINST= a checkout of another version
	.venv/bin/python benchmarks/dem.py $(if $(AGAINST),--against "$$AGAINST")

bench-column: setup ## time the column's schemes, over threads and columns
	.venv/bin/python benchmarks/column.py

bench-remap: setup ## time the transfers between elements and grids, beside bincount and griddata
	.venv/bin/python benchmarks/remap.py
	.venv/bin/python benchmarks/remap_elements.py

bench-packing: setup ## time packings of up to a million elements beside one Delaunay triangulation
	.venv/bin/python benchmarks/packing.py

bench-plan: setup ## compare plans with held-out scenes
	.venv/bin/python benchmarks/plan.py

bench-scaling: setup ## time the element model over ranks, and draw what many cores would give
	.venv/bin/python benchmarks/scaling.py

bench-year: setup ## run the Arctic year on RANKS= (2) and print it beside published figures
	.venv/bin/python benchmarks/year.py --ranks "$${RANKS:-2}"

bench: bench-dem bench-scaling bench-column bench-remap bench-packing bench-plan ## all benchmarks, and a table of accuracy against cost
	.venv/bin/python benchmarks/collect.py

studies: setup ## ablation and accuracy of the example scenes, ensembles where ice breaks, and docs/studies.md, docs/ensembles.md (two hours)
	@for scene in free_drift_day winter_pack summer_melt_month marginal_ice_zone; do \
	    for study in ablation accuracy; do \
	        .venv/bin/snakemake --profile workflows/profiles/local --keep-going \
	            --config scene=config/scenes/$$scene.yaml -- $$study; \
	    done; done
	@.venv/bin/snakemake --profile workflows/profiles/local --keep-going \
	    --config scene=config/scenes/arctic_week.yaml -- ablation ensemble
	.venv/bin/floeflow plan --refit
	.venv/bin/python -m floeflow.analysis.studies.document

docs: setup ## build the site of the documentation in build/site; any warning fails
	@setup/docs.sh

doctor: ## say what is there and what is missing, and try a probe of the plugin
	@setup/doctor.sh

test-fresh: ## prove `make run` and `make test` in a bare Debian 12 (as root, 3 GB)
	@setup/fresh.sh

lock: ## pin the dependencies anew in setup/requirements.lock
	@setup/lock.sh

tag: ## tag the last commit as the version in floeflow/__init__.py, if CHANGELOG.md has it
	@setup/tag.sh

clean: ## remove what was built (results and .venv stay)
	rm -rf build floeflow.egg-info
