"""The partners of a pair, from the files of a run."""

from pathlib import Path

import numpy as np

from sparsurf.molecules.read_molecule import read_own
from sparsurf.pairs.complex_scores import centres_of
from sparsurf.pairs.matching import Recipe
from sparsurf.pairs.partners import partner_of
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.spacing import refuse_sparse

SIDES = ("1", "2")


def structure_of(inputs, side):
    """The atoms of one side, '1' or '2'; None for a surface that came without."""
    path = inputs.get(f"structure_{side}")
    return read_own(path) if path else None


def partners(inputs, settings, name, threads=1):
    """Both partners from surface_1, surface_2 and, where there are atoms, structure_1, structure_2."""
    patches, out = settings["patches"], []
    for side in SIDES:
        surface = read_npz(inputs[f"surface_{side}"])
        refuse_sparse(surface.points, patches["D_link"], f"{name}, partner {side}")
        molecule = structure_of(inputs, side)
        out.append(
            partner_of(
                surface,
                molecule,
                f"{name} {side}",
                patches["R_patch"],
                patches["D_link"],
                threads,
                patches["roughness"],
            )
        )
    return tuple(out)


def names_of(pair):
    """What the two partners of a pair of the config are: proteins, files, or chains of a file."""
    if "complex" in pair:
        file = Path(pair["complex"]).name
        return tuple(f"chain{'s' * (len(each) > 1)} {' '.join(each)} of {file}" for each in pair["chains"])
    return tuple(pair["proteins"] if "proteins" in pair else (Path(file).name for file in pair["files"]))


def recipe_of(settings):
    """How patches become numbers, by the config."""
    return Recipe(settings["patches"]["descriptor"], settings["patches"]["R_zernike"])


def requested_centres(partner, settings):
    """Dots whose patches are compared, by the config's `complementarity.centres`, (n,) int."""
    asked = settings["complementarity"]["centres"]
    n = len(partner.surface)
    if asked == "all":
        return np.arange(n)
    most = asked.get("n_S") or max(1, round(asked["n_S_percent"] / 100 * n))
    return centres_of(partner, min(most, n), asked["sampler"], settings["seed"])
