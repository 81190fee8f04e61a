# The study in a container with fixed versions of all packages. The folder .snakemake records which inputs the results were computed from:
#   docker build -t sparsurf .
#   docker run -v "$PWD/results:/sparsurf/results" -v "$PWD/.snakemake:/sparsurf/.snakemake" sparsurf
# The command sparsurf alone: docker run -v "$PWD:/data" -w /data sparsurf sparsurf surface protein.pdb -o dots.ply
FROM python:3.11-slim-bookworm
RUN apt-get update && apt-get install -y --no-install-recommends make && rm -rf /var/lib/apt/lists/*
WORKDIR /sparsurf
COPY envs envs
RUN python3 -m venv .venv && .venv/bin/python -m pip install --no-cache-dir --require-hashes -r envs/requirements.txt
COPY . .
RUN .venv/bin/python -m pip install --no-deps --no-build-isolation --editable .
ENV PATH=/sparsurf/.venv/bin:$PATH XDG_CACHE_HOME=/tmp/sparsurf MPLCONFIGDIR=/tmp/sparsurf/matplotlib
CMD ["python", "scripts/study.py", "config.yaml", "--cores", "all"]
