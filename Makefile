# make run     set up, run the default study on the embedded example, and write results/default/index.html
# make paper   the same for conformation A1 of the paper, with the paper's tables beside ours (see studies/paper.yaml);
#              5 minutes of CPU time
# make compare  a study, and its samplers compared at equal n_S; a later make run keeps that up to date
# make check   compare the files of a run with its SHA256SUMS
# make test    set up, run every check, and every test but those of a release, which RELEASE=1 adds as in .ci/run
# make test-fast  the tests without those that run whole studies, Slurm, a browser, a package or a recipe: after each edit
# make bench   measure speed and memory, each as a ratio to the commit BASE (none with BASE=) and to other programs, and how they grow
# make evidence  compute the tables and figures of docs/ that are missing or older than their inputs (evidence/README.md). QUICK=1 runs
#              all rules on small pieces, -n only lists the jobs, EVIDENCE_DATA=folder reads structures from a folder, and RULES=name
#              runs one rule and those that it depends on
# make docs    renew the numbers of the pages, build the book in docs/_build/html and check its links (needs a network the
#              first time)
# make package  build wheel and source archive in dist/ and check them
# make setup   set up only; CLUSTER=slurm also installs the packages for Slurm, and make setup-test those for tests
# make schema  renew config/schema.json and docs/reference/config.md from the models of the config, and the numbers and lists of the other pages
# make lock    renew envs/requirements*.txt from envs/requirements*.in (needs a network)
# Another study: make run CONFIG=my_config.yaml CORES=4
# On a cluster:  make run CONFIG=my_config.yaml CLUSTER=slurm, or PROFILE=folder with your own Snakemake profile (docs/cluster.md)

PYTHON ?= python3
CORES  ?= all
CLUSTER ?=
PROFILE ?=
QUICK  ?=
CONFIG ?= config.yaml
BASE   ?= 0cad9af8
RELEASE ?=
VENV   := .venv
BIN    := $(VENV)/bin
# uv, where it is installed, unpacks a warm cache in seconds; pip does the same where uv is missing or reaches no registry
# A module is compiled when it is first imported, as with uv: compiling all of them takes half of the set-up
PIP    := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile
UV     := $(shell command -v uv)
PACKAGES := XDG_CACHE_HOME="$(XDG_CACHE_HOME)" # the user's cache, not that of this checkout
install = $(if $(UV),$(PACKAGES) $(UV) pip install --quiet --python $(BIN)/python $1 || )$(PACKAGES) $(PIP) $1
# What is installed knows where it lies: a checkout that was moved is set up anew
READY  := $(VENV)/.ready-$(shell { pwd; cat envs/requirements.txt; } | cksum | cut -d' ' -f1)
# Its commands are those of pyproject.toml: installed again, in seconds, where that has changed
INSTALLED := $(VENV)/.ready-package-$(shell cksum < pyproject.toml | cut -d' ' -f1)
override QUICK := $(filter-out 0 no false,$(QUICK))
ifneq ($(filter-out slurm,$(CLUSTER)),)
$(error CLUSTER is $(CLUSTER), but only CLUSTER=slurm is known (docs/cluster.md))
endif
# Snakemake takes braces for wildcards and ends the path of its Python at a space; Python ends a search path at a colon
SPACE  := $(VENV) $(VENV)
SPACE  := $(subst $(VENV),,$(SPACE))
WRONG  := $(or $(findstring {,$(CURDIR)),$(findstring },$(CURDIR)),$(findstring :,$(CURDIR)),$(if $(findstring $(SPACE),$(CURDIR)),space))
ifneq ($(WRONG),)
$(error $(CURDIR) has a $(WRONG) in its name, which Snakemake cannot handle: move this checkout to another folder)
endif
# `make run my.yaml` would run the default study, and then find that there is nothing to do for my.yaml
GIVEN  := $(filter %.yaml %.yml %.json,$(MAKECMDGOALS)) $(if $(filter command line,$(origin config)),$(config))
ifneq ($(strip $(GIVEN)),)
$(error a config is given as CONFIG: write make run CONFIG=$(firstword $(GIVEN)))
endif
# The set-up clears the environment first, through a link that of another checkout
ifneq ($(shell test -L $(VENV) && echo link),)
$(error $(VENV) is a link: remove it, since each checkout has its own environment, which make creates)
endif
# Where the jobs run: on the cores here, on Slurm, whose extra packages are installed then, or where a profile sends them
ifneq ($(and $(CLUSTER),$(PROFILE)),)
$(error CLUSTER is $(CLUSTER) and PROFILE is $(PROFILE): give only one of the two)
endif
WHERE  := $(if $(CLUSTER),--workflow-profile profiles/$(CLUSTER),$(if $(PROFILE),--workflow-profile "$(PROFILE)",--cores $(CORES)))
LOCKED := $(shell cat envs/requirements*.txt | cksum | cut -d' ' -f1)
FOR_TEST := $(VENV)/.ready-test-$(LOCKED)
FOR_DOCS := $(VENV)/.ready-docs-$(LOCKED)
EXTRA  := $(if $(CLUSTER),$(VENV)/.ready-$(CLUSTER)-$(LOCKED))

export MPLCONFIGDIR    ?= $(CURDIR)/.cache/matplotlib
export XDG_CACHE_HOME  ?= $(CURDIR)/.cache
export PYTHONDONTWRITEBYTECODE =  # bytecode is kept: a study starts dozens of processes

# No kernel uses numba's own threads, and numba does not load where their number is 0
unexport NUMBA_NUM_THREADS SNAKEMAKE_PROFILE

# Where Slurm is installed and does not answer, each start of Snakemake would wait 10 s for it
ifeq ($(CLUSTER)$(SLURM_JOB_ID),)
export SLURM_CONF ?= /dev/null
endif

# The numba kernels, compiled once, and again after the edit of a source with kernels: others are only loaded
KERNELS := .cache/kernels-compiled

.PHONY: evidence setup setup-test setup-docs run paper compare check test test-fast bench docs package lock schema

setup: $(INSTALLED) $(KERNELS) $(EXTRA)

# exec: a signal to what make has started reaches the study, as no shell stands between
run: setup
	@exec $(BIN)/python -m sparsurf_study run "$(CONFIG)" $(WHERE)

paper: setup
	@echo "From nothing, make paper takes 5 minutes of CPU time, about 3 minutes on two idle cores."
	@exec $(BIN)/python -m sparsurf_study run studies/paper.yaml $(WHERE)

compare: setup
	@exec $(BIN)/python -m sparsurf_study run "$(CONFIG)" $(WHERE) compare

check: setup
	@$(BIN)/python -m sparsurf_study check "$(CONFIG)"

setup-test: setup $(FOR_TEST)

test: setup-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/snakefmt --check Snakefile workflow/Snakefile rules/*.smk evidence/Snakefile evidence/rules/*.smk
	for file in Snakefile workflow/Snakefile evidence/Snakefile; do $(BIN)/snakemake --lint --snakefile $$file || exit 1; done
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache --no-logo
	$(BIN)/python docs/language.py
	@$(if $(RELEASE),,echo "Only .ci/run also checks the package, the recipes of CONTRIBUTING.md, an older processor, which bytes each \
	key changes, the lowest versions, the book, the short study and the evidence.")
	OPENBLAS_NUM_THREADS=1 $(BIN)/pytest $(if $(RELEASE),,-m "not release") -n 3 --dist worksteal # on two cores: some tests wait

test-fast: setup-test
	$(BIN)/ruff check .
	OPENBLAS_NUM_THREADS=1 $(BIN)/pytest -m "not slow and not release" -n 2 --dist worksteal

setup-docs: $(INSTALLED) $(FOR_TEST) $(FOR_DOCS)

docs: setup-docs
	$(BIN)/python docs/renew.py
	$(BIN)/python docs/example.py
	$(BIN)/sphinx-build --quiet --fail-on-warning --keep-going docs docs/_build/html
	$(BIN)/pytest tests/docs/test_book.py

package: setup-docs
	rm -rf dist
	HATCH_BUILD_NO_HOOKS=1 $(BIN)/python -m build --no-isolation # without kernels: an index serves every processor
	$(BIN)/twine check --strict dist/*

bench: setup
	$(BIN)/python evidence/bench.py $(if $(BASE),--base $(BASE))

# Without results/evidence nothing was measured here: tables and figures are as released, and Git gave them times at random.
# make passes -n on to Snakemake: the plus runs these lines then, too
evidence: setup
	+@test -d results/evidence || { mkdir -p results/evidence && touch -r results/evidence evidence/tables/*.csv docs/*.png \
	  evidence/tables/*.csv.gz; }
	+@$(BIN)/snakemake --snakefile evidence/Snakefile --rerun-triggers mtime $(if $(QUICK),--configfile evidence/quick.yaml) \
	  $(if $(CLUSTER),--workflow-profile profiles/$(CLUSTER),$(if $(PROFILE),--workflow-profile "$(PROFILE)",--cores $(CORES))) $(RULES) \
	  $(if $(findstring =,$(firstword -$(MAKEFLAGS))),,$(if $(findstring n,$(firstword -$(MAKEFLAGS))),--dry-run --quiet rules host))

$(KERNELS): $(READY) $(shell find src -name '*.py') | $(INSTALLED)
	@echo "Compiling kernels (once, about half a minute)"
	@mkdir -p .cache
	@$(BIN)/python -m sparsurf.compile_kernels surfaces & job=$$!; \
	  $(BIN)/python -m sparsurf.compile_kernels patches && $(BIN)/python -m sparsurf_study.compile_kernels && wait $$job
	@touch $@

# JSON Schema and reference page of the config, from its models; what other pages take from tables and code
schema: $(INSTALLED)
	$(BIN)/python docs/config_reference.py
	$(BIN)/python docs/renew.py

$(READY): envs/requirements.txt
	$(PYTHON) -m venv --clear $(VENV)
	$(call install,--require-hashes -r envs/requirements.txt)
	touch $@

$(INSTALLED): $(READY)
	$(call install,--no-deps --no-build-isolation --editable .)
	@for link in $(VENV)/lib/python3*/site-packages/_sparsurf.pth; do echo ../../../../src > $$link; done # read where LC_ALL is C
	touch $@

# What a study does not need: .ready-test-..., .ready-docs-..., .ready-slurm-...
$(VENV)/.ready-%: $(READY)
	$(call install,--no-deps --require-hashes -r envs/requirements-$(firstword $(subst -, ,$*)).txt)
	touch $@

lock:
	$(PYTHON) -m venv --clear .cache/lock
	.cache/lock/bin/python -m pip install --quiet uv
	.cache/lock/bin/uv pip compile --universal --generate-hashes --python-version 3.11 \
	  --custom-compile-command "make lock" --upgrade --quiet --output-file envs/requirements.txt envs/requirements.in
	.cache/lock/bin/uv pip compile --universal --no-deps --generate-hashes --python-version 3.11 \
	  --custom-compile-command "make lock" --upgrade --quiet --output-file envs/requirements-slurm.txt envs/requirements-slurm.in
	for extra in test docs; do .cache/lock/bin/uv pip compile --universal --generate-hashes --python-version 3.11 \
	  --constraints envs/requirements.txt --custom-compile-command "make lock" --upgrade --quiet \
	  --output-file envs/requirements-$$extra.txt envs/requirements-$$extra.in; done
