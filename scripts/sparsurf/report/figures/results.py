"""What a figure of one conformation may show."""

from dataclasses import dataclass

import pandas as pd

from sparsurf.surfaces.surface import Surface


@dataclass(frozen=True)
class Results:
    """Everything that `draw(results)` of a figure may use.

    Attributes
    ----------
    surface : Surface
    roughness : (N,) float64, R_i
    grid : pandas.DataFrame, as in grid.csv
    best : dict, as in best.json
    subsets : list of (title, dots), the pictures of `subsets`
    rough_and_flat : dict, the arguments of `rough_and_flat.figure`
    recovered : sequence of (title, points, normals, distance), the last pictures of `subsets`
    """

    surface: Surface
    roughness: object
    grid: pd.DataFrame
    best: dict
    subsets: list
    rough_and_flat: dict
    recovered: tuple = ()
