"""
The study inside a workflow of yours
====================================

Snakemake imports the study as a module. Your rules can make its inputs and read its outputs.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

checkout = Path("../..").resolve()
folder = Path(tempfile.mkdtemp())
peptide = f"{{structure: {checkout}/data/tdp43/topology.pdb}}"
(folder / "config.yaml").write_text(f"run: mine\nproteins: {{peptide: {peptide}}}\n")
(folder / "Snakefile").write_text(f"""
configfile: "config.yaml"
module sparsurf:
    snakefile: "{checkout}/Snakefile"
    config: config

use rule * from sparsurf as sparsurf_*

rule mine:  # of yours, with an output of the study
    default_target: True
    input: "results/mine/peptide/f0/minimal.csv"
    shell: "wc -l {{input}}"
""")
run = f"{sys.executable} -m snakemake --dry-run --quiet host --cores 1".split()
done = subprocess.run(run, cwd=folder, capture_output=True, text=True, check=True)
jobs = dict(re.findall(r"^(\w+) +(\d+)$", done.stdout + done.stderr, re.M))

fig, ax = plt.subplots(figsize=(6, 3), layout="constrained")
names = [name for name in jobs if name != "total"]
ax.barh(names[::-1], [int(jobs[name]) for name in names[::-1]])
ax.set(xlabel="jobs", title="What your rule needs")
