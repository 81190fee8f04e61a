"""Follow n_S and d of one combination over some of the frames of a trajectory."""

from sparsurf_study.workflow.jobs import job, reporter
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf_study.analysis.ensemble import evaluate_frames

with job(snakemake) as s:
    files, name = (s.input.structure, s.input.get("trajectory")), s.wildcards.protein
    molecule = read_molecule(*files, stride=s.settings.ensemble.stride, **s.params.molecule_options)
    k, n_parts = map(int, s.wildcards.scatteritem.split("-of-"))
    progress = reporter(f"{name}, part {k} of {n_parts}", "frames")
    rows = evaluate_frames(molecule, s.settings, s.streams(name), s.threads, progress, (k, n_parts))
    rows.to_csv(s.output.rows, index=False, lineterminator="\n")
