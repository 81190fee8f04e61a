"""Choose the conformations of a study from a trajectory, the models of a file, or a single structure."""

from pathlib import Path

from sparsurf_study.workflow.jobs import job
from sparsurf.streams import stream
from sparsurf_study.rounding import write_rounded
from sparsurf_study.structures import choose_conformations

with job(snakemake) as s:
    molecule, choice = choose_conformations(
        s.input.structure,
        s.input.get("trajectory"),
        s.params.molecule_options,
        stream(s.params.seed, s.wildcards.protein, "clusters"),
        **s.params.frames,
    )
    for name, table in choice.tables(molecule.frame_number).items():
        write_rounded(s.output[name], table)
    Path(s.output.structures).mkdir()
    for conformation, position in zip(choice.table["conformation"], choice.index, strict=True):
        molecule.write_pdb(Path(s.output.structures, f"{conformation}.pdb"), position)
