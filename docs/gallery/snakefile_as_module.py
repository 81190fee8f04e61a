"""
The study inside a workflow of yours
====================================

Snakemake imports the study as a module. Your rules can make its inputs and read its outputs.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import sparsurf

checkout = Path("../..").resolve()
folder = Path(tempfile.mkdtemp())
peptide = f"{{structure: {checkout}/data/tdp43/topology.pdb, residues: 209-222}}"
config = f"run: mine\nsampling: false\nproteins: {{peptide: {peptide}}}\n"
(folder / "config.yaml").write_text(config)
(folder / "Snakefile").write_text(f"""
configfile: "config.yaml"
module sparsurf:
    snakefile: "{checkout}/Snakefile"
    config: config

use rule * from sparsurf as sparsurf_*

rule mine:  # of yours; c1 is the conformation of a single structure
    default_target: True
    input: "results/mine/peptide/c1/minimal.csv"
    output: "length.txt"
    shell: "wc -l < {{input}} > {{output}}"
""")
run = f"{sys.executable} -m snakemake --quiet all --cores 1".split()
subprocess.run(run, cwd=folder, check=True)
print((folder / "length.txt").read_text().strip(), "lines in minimal.csv")

dots = sparsurf.read_surface(folder / "results/mine/peptide/c1/surface.npz")
dots.plot(sparsurf.roughness(dots)).set_title("roughness R of each dot")
