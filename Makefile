# make run     set up, run the default study on the embedded example, write the report
# make test    set up, run every check
# Further studies: make run CONFIG=my_config.yaml CORES=4

PYTHON ?= python3
CORES  ?= all
CONFIG ?= config.yaml
VENV   := .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/.ready-$(shell cksum < envs/requirements.txt | cut -d' ' -f1)

export NUMBA_CACHE_DIR ?= $(CURDIR)/.cache/numba
export MPLCONFIGDIR    ?= $(CURDIR)/.cache/matplotlib
export XDG_CACHE_HOME  ?= $(CURDIR)/.cache

.PHONY: run test lock clean

run: $(READY)
	$(BIN)/snakemake --cores $(CORES) --configfile $(CONFIG)

test: $(READY)
	$(BIN)/pytest

$(READY): envs/requirements.txt
	$(PYTHON) -m venv --clear $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r envs/requirements.txt
	touch $@

lock:
	$(PYTHON) -m venv --clear .cache/lock
	.cache/lock/bin/python -m pip install --quiet uv
	.cache/lock/bin/uv pip compile --universal --generate-hashes --python-version 3.11 \
	  --custom-compile-command "make lock" --upgrade --quiet --output-file envs/requirements.txt envs/requirements.in
