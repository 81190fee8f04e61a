"""Compare two forms of a protein residue by residue."""

import logging

import numpy as np

from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_study_structure
from sparsurf.pairs.changes import (
    Form,
    numbered_alike,
    over_floor,
    superpose_forms,
    unmatched_residues,
)
from sparsurf.pairs.changes import changes as changes_between
from sparsurf.pairs.matching import on_atoms
from sparsurf.settings import Surface as SurfaceSettings
from sparsurf.streams import stream
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.molecular_surface import surface_generator
from sparsurf.surfaces.radii import radii
from sparsurf.workflow.conformations import require_conformation
from sparsurf.workflow.jobs import job

log = logging.getLogger("sparsurf")

B_FACTOR_OF_BURIED = -1.0  # of residues without a change


def main(
    surface_1: str | None,
    surface_2: str | None,
    structure_1: str | None,
    structure_2: str | None,
    changes: str,
    pdb_1: str,
    pdb_2: str,
    forms: list[str],
    settings: SurfaceSettings,
    d_link: float,
    seed: int,
    name: str,
    threads: int = 1,
) -> None:
    """Write changes.csv and both structures, the second superposed onto the first.

    The B factor is the change over its larger floor.

    Parameters
    ----------
    surface_1, surface_2, structure_1, structure_2 : None where the study does not have one of the conformations
    forms : both conformations as the config names them
    d_link : float, Å
    name : of the comparison
    """
    paths = [require_conformation(structure, name) for structure in (structure_1, structure_2)]
    surfaces = [require_conformation(surface, name) for surface in (surface_1, surface_2)]
    if paths[0] == paths[1]:
        raise InputError(f"changes.{name}: both names mean one conformation; name another.")
    reference = read_study_structure(paths[0])
    molecules = reference, numbered_alike(read_study_structure(paths[1]), reference)
    compared = []
    for form, surface, molecule in zip(forms, surfaces, molecules, strict=True):
        atom_radii = radii(molecule, settings.radii)
        generate, _ = surface_generator(molecule, 0, atom_radii, settings, d_link, form)
        compared.append(Form(form, read_npz(surface), molecule, generate))
    unmatched = unmatched_residues(compared[0], compared[1])
    for form, other, residues in zip(forms, reversed(forms), unmatched, strict=True):
        if residues:
            message = (
                "%s lacks residues %s of %s, so changes next to them may come from that: "
                "restrict both forms to the same residues by `residues`"
            )
            log.warning(message, other, residues, form)
    table = changes_between(compared[0], compared[1], stream(seed, "changes", *forms), threads)
    table.to_csv(changes, index=False, float_format="%.5g")
    relative = table.assign(over_floor=over_floor(table))
    superposed = reference, superpose_forms(molecules[1], reference)
    for pdb, molecule in zip((pdb_1, pdb_2), superposed, strict=True):
        change = on_atoms(molecule, relative, "over_floor", B_FACTOR_OF_BURIED)
        molecule.write_pdb(pdb, b_factor=np.nan_to_num(change, nan=B_FACTOR_OF_BURIED))


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface_1=snakemake.input.get("surface_1"),
            surface_2=snakemake.input.get("surface_2"),
            structure_1=snakemake.input.get("structure_1"),
            structure_2=snakemake.input.get("structure_2"),
            changes=snakemake.output.changes,
            pdb_1=snakemake.output.pdb_1,
            pdb_2=snakemake.output.pdb_2,
            forms=snakemake.params.forms,
            settings=SurfaceSettings(**snakemake.params.surface),
            d_link=snakemake.params.d_link,
            seed=snakemake.params.seed,
            name=snakemake.wildcards.comparison,
            threads=snakemake.threads,
        )
