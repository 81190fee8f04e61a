"""Put a protein into a box of water: the simulated system."""

import json
from pathlib import Path

from sparsurf.simulation.protocol import with_defaults
from sparsurf.simulation.system import prepare_system, select_protein
from sparsurf.workflow.jobs import job


def main(
    structure: str, system: str, contents: str, simulate: dict, structure_options: dict, seed: int
) -> None:
    """Write the topology and coordinates of the system, and what it consists of.

    Parameters
    ----------
    system : folder to be made
    contents : JSON file to be written
    simulate : dict, the key `simulate` of the protein in the config
    structure_options : dict, the keys of the protein that choose its atoms
    """
    folder = Path(system)
    folder.mkdir()
    protein = select_protein(structure, structure_options)
    facts = prepare_system(protein, structure, with_defaults(simulate), seed, folder)
    Path(contents).write_text(json.dumps(facts, indent=2) + "\n", encoding="ascii")


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            system=snakemake.output.system,
            contents=snakemake.output.contents,
            simulate=snakemake.params.simulate,
            structure_options=snakemake.params.structure_options,
            seed=snakemake.params.seed,
        )
