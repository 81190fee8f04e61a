"""Compute the surfaces of both partners of a pair that is given by structures."""

from sparsurf_study.workflow.jobs import job
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.molecular_surface import surface_of_molecule

with job(snakemake) as s:
    chains = s.params.pair.get("chains")  # of both partners of a complex
    if chains:
        molecules = [read_molecule(s.input[0], chains=of_partner) for of_partner in chains]
    else:
        molecules = [read_molecule(file) for file in s.input]
    for side, molecule in enumerate(molecules, 1):
        partner = f"{s.wildcards.pair}, partner {side}"
        if molecule.n_frames > 1:
            n = molecule.n_frames
            raise InputError(f"{s.wildcards.pair}: partner {side} has {n} models; give a file with one.")
        dots = surface_of_molecule(molecule, s.settings.surface, s.params.d_link, partner)
        write_npz(s.output[f"surface_{side}"], dots)
        molecule.write_pdb(s.output[f"structure_{side}"])
