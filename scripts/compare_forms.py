"""Two forms of a protein compared residue by residue."""

import numpy as np
from sparsurf.workflow.files_of_sites import refuse_absent

from sparsurf import InputError
from sparsurf.molecules.read_molecule import read_own
from sparsurf.pairs.changes import RARE, Form, changes, laid, numbered_alike
from sparsurf.pairs.matching import on_atoms
from sparsurf.report.page import write
from sparsurf.report.site_page import OF_FORMS, changes_page
from sparsurf.streams import stream
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.molecular_surface import layer
from sparsurf.surfaces.radii import radii
from sparsurf.workflow.jobs import run
from sparsurf.workflow.partner_files import SIDES

BURIED = -1.0  # in the B-factor column, of residues without a change


def main(inputs, outputs, settings, site, name, threads):
    """Write changes.csv, a page, and both structures with the change as B factor, the second laid on the first."""
    refuse_absent(inputs, "structure_1", name)
    if inputs["structure_1"] == inputs["structure_2"]:
        raise InputError(f"sites.{name}: both names mean one conformation; name another.")
    molecules = [read_own(inputs[f"structure_{side}"]) for side in SIDES]
    molecules[1] = numbered_alike(molecules[1], molecules[0])
    rules, forms = settings["surface"], []
    for side, molecule, form in zip(SIDES, molecules, site["changes"], strict=True):
        own = radii(molecule, rules["radii"])
        lay = layer(molecule, 0, own, rules, settings["patches"]["D_link"], form)["lay"]
        forms.append(Form(form, read_npz(inputs[f"surface_{side}"]), molecule, lay))
    table = changes(*forms, stream(settings["seed"], "changes", *site["changes"]), threads)
    table.to_csv(outputs["changes"], index=False, float_format="%.5g")
    for side, molecule in zip(SIDES, (molecules[0], laid(molecules[1], molecules[0])), strict=True):
        shown = on_atoms(molecule, table, "total", BURIED)
        molecule.write_pdb(outputs[f"pdb_{side}"], b_factor=np.nan_to_num(shown, nan=BURIED))
    write(outputs["page"], OF_FORMS, **changes_page(name, site["changes"], table, RARE))


if __name__ == "__main__":
    run(main, snakemake)
