"""Gather the rows of all frames of a trajectory in one table, and R_i of the residues over them."""

from pathlib import Path

import pandas as pd

from sparsurf_study.workflow.jobs import job
from sparsurf.evaluation.residues import roughness_over_frames
from sparsurf.messages import no_warnings
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf_study.analysis.ensemble import split_residue_columns
from sparsurf_study.rounding import write_rounded

STRIDE_TO_FIRST_FRAME = 10**9  # leaves one frame: the residues are the same in all

with job(snakemake) as s:
    files, options = (s.input.structure, s.input.get("trajectory")), s.params.molecule_options
    with no_warnings():  # the jobs that measured the frames have given them
        residues = read_molecule(*files, stride=STRIDE_TO_FIRST_FRAME, **options).residues
    # A part without frames is an empty file, which pandas cannot read
    parts = [pd.read_csv(path) for path in s.input.rows if Path(path).stat().st_size > 1]
    frames, over_time = split_residue_columns(pd.concat(parts), residues)
    write_rounded(s.output.table, frames)
    write_rounded(s.output.over_time, over_time)
    write_rounded(s.output.residues, roughness_over_frames(residues, over_time.to_numpy(float)[:, 2:]))
