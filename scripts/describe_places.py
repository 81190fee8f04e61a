"""The places of one conformation in numbers, by which the same site is found on another."""

from sparsurf.molecules.read_molecule import read_own
from sparsurf.sites.describing import describe_surface
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import run


def main(inputs, outputs, name, threads):
    """Write the places of a surface, with their residues where there is a structure."""
    molecule = read_own(inputs["structure"]) if inputs.get("structure") else None
    describe_surface(read_npz(inputs["surface"]), molecule, name, threads=threads).save(outputs["sites"])


if __name__ == "__main__":
    run(main, snakemake)
