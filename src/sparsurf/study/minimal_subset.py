"""The subset that is handed out: chosen as a config, a command or a call asks, the same for all three."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pandas as pd

from sparsurf.recovery.recovering import REACH, dot_spacing
from sparsurf.recovery.relaxation import relax
from sparsurf.sampling.samplers import subset_weights
from sparsurf.study.subset_search import find_subset, smallest_recovered_subset
from sparsurf.surfaces.surface import Surface


class Subset(NamedTuple):
    """Dots that stand for a surface.

    Attributes
    ----------
    dots : (n,) int64, their numbers, in the order of choice
    weight : (n,) int64, the dots of the surface that each stands for
    surface : Surface of the kept dots alone, at better places where settled
    table : DataFrame, the rows of minimal.csv: dot, x, y, z (Å), nx, ny, nz, weight, spacing (Å), reach; with atoms their labels
    """

    dots: np.ndarray
    weight: np.ndarray
    surface: Surface
    table: pd.DataFrame

    def __repr__(self):
        return f"Subset of {len(self.dots):,} dots of {self.weight.sum():,}"

    def to_frame(self):
        """`table`, as `to_frame` of a Surface."""
        return self.table


def select_minimal_subset(trials, asked, floors=None, molecule=None):
    """The subset that is asked for.

    Parameters
    ----------
    trials : enough.Trials
        Of a `nameless` Evaluator: the subset of a surface depends on the seed, not on what the surface is called.
    asked : dict
        The config's `minimal`: one of floor, n_S, n_S_percent, Z and combination. Sampler and `settle` are those of `trials`.
    floors : DataFrame
        Of `floors.floors`, where a floor is asked for.
    molecule : Molecule, optional
        Whose atoms the dots belong to.

    Returns
    -------
    Subset

    Raises
    ------
    InputError : what `minimal_subset` and `smallest_recovered` refuse
    """
    own = trials.evaluator
    if "floor" in asked:
        dots = smallest_recovered_subset(trials, floors, asked["floor"])
        weight = subset_weights(own.points, dots)
    else:
        how = _size(asked, len(own.points)), asked.get("Z"), asked.get("combination")
        dots, weight = find_subset(own, trials.sampler, *how, len(trials.tests), trials.choices)
    whole = own.surface
    kept = whole.take(dots)
    if trials.relaxed:
        places = relax(kept.points, kept.normals, whole.points, whole.normals, threads=own.threads)
        kept = replace(kept, points=places[0], normals=places[1])
    return Subset(dots, weight, kept, subset_table(dots, weight, kept, molecule))


def _size(asked, n_dots):
    """n_S from the config's n_S or n_S_percent; None where neither is given."""
    if "n_S_percent" in asked:
        return max(1, round(asked["n_S_percent"] / 100 * n_dots))
    return asked.get("n_S")


def subset_table(dots, weight, kept, molecule=None):
    """The rows of minimal.csv.

    Parameters
    ----------
    dots, weight, kept : as `Subset` has them, with its `surface`
    molecule : Molecule, optional
        Whose atoms the dots belong to.

    Returns
    -------
    DataFrame: dot, x, y, z (Å), nx, ny, nz, weight, spacing (Å) of the kept dots around, reach (in spacings); with a molecule
    chain, residue, residue_name, atom_name and atom, its index from 0.
    """
    table = pd.DataFrame({"dot": dots})
    table[["x", "y", "z"]], table[["nx", "ny", "nz"]] = kept.points, kept.normals
    table["weight"], table["spacing"] = weight, dot_spacing(kept.points, kept.normals)
    table["reach"] = REACH
    return table if molecule is None else table.join(molecule.labels(kept.atom))
