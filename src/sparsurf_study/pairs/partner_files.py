"""Partners of a pair, read from the files of a study."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.molecules.read_molecule import read_study_structure
from sparsurf.sampling.samplers import get_samplers
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.spacing import refuse_sparse
from sparsurf_study.pairs.partners import Partner, partner_of


def read_partners(
    surface_1: str | Path,
    surface_2: str | Path,
    structure_1: str | Path | None,
    structure_2: str | Path | None,
    d_link: float,
    name: str,
) -> tuple[Partner, Partner]:
    """Read both partners of the pair `name`; a surface without atoms has no structure."""
    partners = []
    for side, surface, structure in ((1, surface_1, structure_1), (2, surface_2, structure_2)):
        dots = read_npz(surface)
        refuse_sparse(dots.points, d_link, f"{name}, partner {side}")
        molecule = read_study_structure(structure) if structure else None
        partners.append(partner_of(dots, molecule, f"{name} {side}", d_link))
    return partners[0], partners[1]


def select_centres(
    partner: Partner, centres: str | dict, settings: Settings, seed: int, threads: int = 1
) -> np.ndarray:
    """Select the dots whose patches are compared, ascending; `centres` is a section of the config."""
    n_dots = len(partner.surface)
    if isinstance(centres, str):  # all
        return np.arange(n_dots)
    n_centres = min(centres.get("n_dots") or max(1, round(centres["percent"] / 100 * n_dots)), n_dots)
    name = centres["sampler"]
    sampler = get_samplers([name], "complementarity.centres.sampler")[name]
    prepared = PreparedSurface(partner.surface, settings, None, Streams(seed, partner.name), threads)
    return np.sort(sampler(prepared, n_centres, prepared.stream("centres", name)))
