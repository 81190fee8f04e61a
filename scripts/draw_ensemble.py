"""Draw n_S, roughness and d of one combination over time, and the roughness of the residues."""

import pandas as pd

from sparsurf_study.workflow.jobs import job
from sparsurf.views import layout
from sparsurf_study.analysis.tables import read_residues
from sparsurf_study.report.figures.over_time import ensemble_figure, residues_figure

with job(snakemake) as s:
    frames, combination, name = pd.read_csv(s.input.table), s.params.combination, s.wildcards.protein
    layout.save(ensemble_figure(frames, combination, name), s.output.png)
    residues = read_residues(s.input.over_time), read_residues(s.input.residues)
    layout.save(residues_figure(*residues, name), s.output.residues_png)
