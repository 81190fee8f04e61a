"""A surface made ready for many evaluations, by the settings of a study."""

from __future__ import annotations

from typing import Any

import numpy as np

from sparsurf.study.prepared_surface import PreparedSurface


def prepare_surface(
    surface: Any,
    patches: dict,
    roughness: np.ndarray | None,
    seed: int,
    name: str,
    threads: int = 1,
    distance_from_moved_centre: bool = True,
    chance_in_every_patch: bool = True,
) -> PreparedSurface:
    """Index a surface and lay the patches of the published sampling over it.

    Parameters
    ----------
    surface : Surface
    patches : dict, the section `patches` of the config
    roughness : (N,) float64, R_i of every dot; None: computed
    seed : int
    name : str, of the conformation; names the random streams
    threads : int
    distance_from_moved_centre, chance_in_every_patch : bool
        Two rules of the published sampling, see `build_cover`.
    """
    return PreparedSurface(
        surface,
        patches["R_patch"],
        patches["R_zernike"],
        patches["D_link"],
        roughness,
        seed,
        name,
        threads,
        distance_from_moved_centre,
        chance_in_every_patch,
        patches["descriptor"],
        patches["roughness"],
    )
