#!/bin/sh
# Tests the library, or what is named, with the lowest versions that pyproject.toml allows, as uv resolves them, in .cache/lowest.
# The study runs with the locked versions of envs/requirements.txt alone.
cd "$(dirname "$0")/.." || exit 1
place=.cache/lowest
rm -rf "$place"
python3 -m venv "$place" || exit 1
timeout 60 "$place/bin/pip" install -q --retries 0 --timeout 5 uv > /dev/null 2>&1 \
  || { echo "uv could not be fetched: the lowest versions are not tested."; exit 0; }
set -e
export VIRTUAL_ENV="$PWD/$place"
export NUMBA_CACHE_DIR="$PWD/$place/kernels" # those beside the sources are of the locked numba
"$place/bin/uv" pip compile --quiet --resolution lowest-direct --extra plot --extra hdf5 --extra many \
  pyproject.toml envs/requirements.in --output-file "$place/lowest.txt" > /dev/null
"$place/bin/uv" pip install --quiet --requirements "$place/lowest.txt" hypothesis pytest pytest-xdist
"$place/bin/uv" pip install --quiet --no-deps --editable .
"$place/bin/python" -m pytest -q -n 3 --dist worksteal "${@:-tests/library}"
