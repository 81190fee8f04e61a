"""What a figure of one conformation may show."""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from sparsurf.surfaces.surface import Surface


@dataclass(frozen=True)
class Results:
    """Everything that `draw(results)` of a figure may use; what a figure does not use may be left out.

    Attributes
    ----------
    name : str, protein/conformation
    surface : Surface
    roughness : (N,) float64, R_i
    grid, curves, floors, enough : pandas.DataFrame, the tables of these names
    best : dict, as in best.json
    floor : str, the noise floor that says how many dots are enough
    subsets : list of (title, Surface, colour), for `subsets`
    recovered : (title, Surface, distance), the last picture of `subsets`
    rough_and_flat : dict, arguments of `rough_and_flat.figure`
    """

    name: str
    surface: Surface
    roughness: np.ndarray = None
    grid: pd.DataFrame = None
    curves: pd.DataFrame = None
    floors: pd.DataFrame = None
    enough: pd.DataFrame = None
    best: dict = field(default_factory=dict)
    floor: str = "fresh dots"
    subsets: list = field(default_factory=list)
    recovered: tuple = ()
    rough_and_flat: dict = field(default_factory=dict)
