"""Put a protein into a box of water: the simulated system."""

import json
from pathlib import Path

from sparsurf_study.workflow.jobs import job
from sparsurf_study.simulation.protocol import with_defaults
from sparsurf_study.simulation.system import prepare_system, select_protein

with job(snakemake) as s:
    folder, structure = Path(s.output.system), s.input.structure
    folder.mkdir()
    protein = select_protein(structure, s.params.structure_options)
    contents = prepare_system(protein, structure, with_defaults(s.params.simulate), s.params.seed, folder)
    Path(s.output.contents).write_text(json.dumps(contents, indent=2) + "\n", encoding="ascii")
