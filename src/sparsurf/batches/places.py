"""Places of sites of a structure, as a run in batches stores them: a byte for each component of the metric space."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from sparsurf.batches.tables import import_pyarrow, pack_dots
from sparsurf.molecules.molecule import Molecule
from sparsurf.sites.describing import Sites, default_settings, numbered_residues
from sparsurf.sites.metric import N_COMPONENTS, fingerprint, quantise, to_metric_space


def pack_places(sites: Sites, molecule: Molecule) -> pd.DataFrame:
    """Round the places of a structure to a few bytes each.

    Parameters
    ----------
    sites : Sites
    molecule : Molecule that they lie on

    Returns
    -------
    DataFrame by residue: its labels, the columns of `pack_dots`, and `numbers`, the quantised components as bytes
    """
    pyarrow = import_pyarrow()
    components = quantise(to_metric_space(sites.numbers, sites.fields))
    values = pyarrow.FixedSizeBinaryArray.from_buffers(
        pyarrow.binary(N_COMPONENTS), len(sites), [None, pyarrow.py_buffer(components.tobytes())]
    )
    table = sites.labels.join(pack_dots(sites.points, sites.normals))
    table["numbers"] = pd.Series(pd.arrays.ArrowExtensionArray(values))
    order = np.argsort(numbered_residues(sites.labels, molecule.residues), kind="stable")
    return table.take(order).reset_index(drop=True)


def settings_of_places(config: Mapping[str, Any]) -> dict[str, Any]:
    """Return how the places of a run are described: the settings of Sites, the metric, and those of the surface."""
    return {
        **default_settings(),
        "metric": fingerprint(),
        "surface": dict(config["surface"]),
        "D_link": config["patches"]["D_link"],
    }
