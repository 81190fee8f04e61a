"""Partners of a pair, read from the files of a study."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sparsurf.molecules.read_molecule import read_study_structure
from sparsurf.pairs.complex_scores import centres_of
from sparsurf.pairs.partners import Partner, partner_of
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.spacing import refuse_sparse


def read_partners(
    surface_1: str | Path,
    surface_2: str | Path,
    structure_1: str | Path | None,
    structure_2: str | Path | None,
    patches: dict,
    name: str,
    threads: int = 1,
) -> tuple[Partner, Partner]:
    """Read both partners of a pair and compute the roughness of their dots.

    Parameters
    ----------
    surface_1, surface_2 : paths of npz files
    structure_1, structure_2 : paths of the structures of the surfaces; None for a surface without atoms
    patches : dict, the section `patches` of the config
    name : str, of the pair; names the random streams
    threads : int

    Raises
    ------
    InputError : the dots of a partner are too sparse for D_link
    """
    partners = []
    for side, surface, structure in ((1, surface_1, structure_1), (2, surface_2, structure_2)):
        dots = read_npz(surface)
        refuse_sparse(dots.points, patches["D_link"], f"{name}, partner {side}")
        molecule = read_study_structure(structure) if structure else None
        partners.append(
            partner_of(
                dots,
                molecule,
                f"{name} {side}",
                patches["R_patch"],
                patches["D_link"],
                threads,
                patches["roughness"],
            )
        )
    return partners[0], partners[1]


def select_centres(partner: Partner, centres: str | dict, seed: int) -> np.ndarray:
    """Select the dots whose patches are compared.

    Parameters
    ----------
    partner : Partner
    centres : 'all', or a dict with `sampler` and either `n_S` or `n_S_percent`, as `complementarity.centres` of the config
    seed : int

    Returns
    -------
    (n,) int, dots
    """
    n_dots = len(partner.surface)
    if isinstance(centres, str):  # all
        return np.arange(n_dots)
    n_centres = centres.get("n_S") or max(1, round(centres["n_S_percent"] / 100 * n_dots))
    return centres_of(partner, min(n_centres, n_dots), centres["sampler"], seed)


def partner_labels(pair: dict) -> tuple[str, ...]:
    """Name both partners of a pair of the config, by protein, file, or chains of a file."""
    if "complex" in pair:
        file = Path(pair["complex"]).name
        return tuple(
            f"chain{'s' if len(chains) > 1 else ''} {' '.join(chains)} of {file}" for chains in pair["chains"]
        )
    return tuple(pair["proteins"] if "proteins" in pair else (Path(file).name for file in pair["files"]))
