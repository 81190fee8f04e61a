"""A protein enters a box of water: the simulated system."""

import json
from pathlib import Path

from sparsurf.simulation.protocol import completed
from sparsurf.simulation.system import chosen_protein, prepare
from sparsurf.workflow.jobs import run


def main(inputs, outputs, chosen, simulate, settings):
    """Write the system's topology and coordinates, and what it is made of."""
    folder, path = Path(outputs["system"]), inputs["structure"]
    folder.mkdir()
    built = prepare(chosen_protein(path, chosen), path, completed(simulate), settings["seed"], folder)
    Path(outputs["contents"]).write_text(json.dumps(built, indent=2) + "\n", encoding="ascii")


if __name__ == "__main__":
    run(main, snakemake)
