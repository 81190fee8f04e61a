"""Measure propensity and yardsticks over many complexes: `python scripts/study_complexes.py data results/complexes [descriptor]`.

`data` holds the complexes of docking benchmark 5 (haddocking/BM5-clean) as complexes/bound/NAME_r.pdb[.gz] and _l, those
with unbound forms as complexes/NAME/NAME_{r,l}_{b-matched,u}.pdb, and 1a1u/1a1u_{A,C}.pdb. A few minutes on one core.
"""

import sys
import time
from pathlib import Path

import pandas as pd

from sparsurf import InputError
from sparsurf.complementarity.interface import interface
from sparsurf.molecules.reading import read_molecule
from sparsurf.patches.descriptors import PUBLISHED
from sparsurf.study.complex_scores import score_complex
from sparsurf.study.complexes import carried_labels, laid_on
from sparsurf.study.matching import Recipe
from sparsurf.study.partners import partner_of
from sparsurf.surfaces.making import fitting_surface
from sparsurf.surfaces.radii import radii

SETTINGS = {"method": "analytic", "density": "auto", "probe_radius": 1.4, "reentrant": "exact"}
D_LINK = 0.5  # Å
RADII = (6.0, 12.0)  # Å, R_zernike; the first is the published one


def complexes(path_to_data):
    """Name, form and two files of every complex under a folder, 1a1u first."""
    data = Path(path_to_data)
    found = [("1a1u", "bound", [data / "1a1u" / f"1a1u_{chain}.pdb" for chain in "AC"])]
    for first in sorted((data / "complexes" / "bound").glob("*_r.pdb*")):
        second = first.with_name(first.name.replace("_r.pdb", "_l.pdb"))
        found.append((first.name.split("_")[0], "bound", [first, second]))
    for first in sorted((data / "complexes").glob("*/*_r_b-matched.pdb")):
        name = first.name.split("_")[0]
        bound = [first, first.with_name(f"{name}_l_b-matched.pdb")]
        found.append((name, "bound", bound))
        found.append((name, "unbound", [first.with_name(f"{name}_{side}_u.pdb") for side in "rl"]))
    if len(found) == 1:
        raise InputError(
            f"{path_to_data} holds no complexes: see scripts/study_complexes.py for their names."
        )
    return found


def ready(molecule, name):
    """A molecule's surface, ready for its maps."""
    sizes = radii(molecule, "dms")
    surface, _ = fitting_surface(molecule, 0, sizes, SETTINGS, D_LINK, name)
    return partner_of(surface, molecule, name)


def main(path_to_data, path_to_results, descriptor=PUBLISHED):
    """Write <descriptor>/areas.csv, contacts.csv and controls.csv, a complex at a time."""
    out = Path(path_to_results) / descriptor
    radii_tried = RADII if descriptor == PUBLISHED else RADII[:1]
    recipes = [Recipe(descriptor, radius) for radius in radii_tried]
    out.mkdir(parents=True, exist_ok=True)
    tables, touching, controls, others, bound = [], [], [], None, None
    for name, form, paths in complexes(path_to_data):
        begin = time.process_time()
        molecules = [read_molecule(path) for path in paths]
        labels = None
        if form == "unbound":
            molecules = [
                laid_on(molecule, reference) for molecule, reference in zip(molecules, bound[0], strict=True)
            ]
        pair = [ready(molecule, f"{name} {form} {side}") for side, molecule in enumerate(molecules, 1)]
        points = [each.surface.points for each in pair]
        if form == "unbound":
            labels = [carried_labels(mine, *theirs) for mine, theirs in zip(points, bound[1], strict=True)]
        else:
            bound = (molecules, [(a, interface(a, b)) for a, b in (points, points[::-1])])
        table, contact, others, same = score_complex(pair, others, labels, recipes)
        tables.append(table.assign(complex=name, form=form))
        if contact is not None and form == "bound":
            touching.append(contact.assign(complex=name))
        controls.append({"complex": name, "form": form, "correlation_1": same[0], "correlation_2": same[1]})
        pd.concat(tables).to_csv(out / "areas.csv", index=False)
        pd.concat(touching).to_csv(out / "contacts.csv", index=False)
        pd.DataFrame(controls).to_csv(out / "controls.csv", index=False)
        print(f"{name} {form}: {time.process_time() - begin:.1f} s", flush=True)


if __name__ == "__main__":
    try:
        main(*sys.argv[1:4])
    except InputError as error:
        sys.exit(str(error))
