"""All steps of one conformation in one process: its surface, roughness, floors, minimal subset, page and residues."""

import draw_view
import make_surface
import measure_floors
import measure_roughness
import tabulate_residues
import take_minimal
from sparsurf.workflow.jobs import run

STEPS = (make_surface, measure_roughness, measure_floors, take_minimal, draw_view, tabulate_residues)


def main(inputs, outputs, settings, molecule_options, name, threads):
    """Do the work of each step on what those before it have written; `outputs` are theirs, as <step>_<name there>."""
    own = {step: _of(step.__name__, outputs) for step in STEPS}
    made = {key: path for step in STEPS[:3] for key, path in own[step].items()}
    made |= {"minimal": own[take_minimal]["table"]}
    made |= {key: path for key, path in own[take_minimal].items() if key == "fields"}
    make_surface.main(inputs, own[make_surface], settings, name, tell=False)
    measure_roughness.main(made, own[measure_roughness], settings, name, threads)
    atoms = inputs | {key: made[key] for key in ("surface", "roughness")} | {"own": made["structure"]}
    measure_floors.main(atoms, own[measure_floors], settings, molecule_options, name, threads)
    take_minimal.main(
        made | {"table": inputs.get("table")}, own[take_minimal], settings, name, threads, whole=False
    )
    draw_view.main(made, own[draw_view], settings, name, threads)
    tabulate_residues.main(made, own[tabulate_residues], name)


def _of(step, outputs):
    return {key.removeprefix(f"{step}_"): path for key, path in outputs.items() if key.startswith(f"{step}_")}


if __name__ == "__main__":
    run(main, snakemake)
