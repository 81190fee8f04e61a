"""n_S and d of one combination over all frames of a trajectory."""

from typing import Any

import numpy as np
import pandas as pd

from sparsurf.evaluation.frames import surface_of_frame
from sparsurf.evaluation.prepared_surface import number_of_tests
from sparsurf.molecules.molecule import Molecule
from sparsurf.progress import Report, unreported
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.streams import Streams
from sparsurf.surfaces.molecular_surface import density_for_d_link
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spacing import refuse_sparse
from sparsurf.threads import parallel_map
from sparsurf_study.analysis import grid
from sparsurf_study.analysis.tables import grid_table
from sparsurf_study.settings import StudySettings

RESIDUE_PREFIX = "residue_"  # The columns of residues begin with it.
DRAWS_PER_FRAME = 1  # samplings and random subsets of each frame
FRAMES_PER_REPORT = 20


def evaluate_frames(
    molecule: Molecule,
    settings: StudySettings,
    streams: Streams,
    threads: int,
    progress: Report = unreported,
    part: tuple[int, int] = (1, 1),
) -> pd.DataFrame:
    """Evaluate one combination on every frame of a trajectory, or on the k-th, from 1, of n equal parts of the frames.

    The columns are those of ensemble.csv, then the mean R_i of each residue; the number of threads does not change them.
    """
    surface, d_link = settings.surface, settings.patches.d_link
    atom_radii = radii(molecule, surface.radii)
    # Of the first frame, for all frames: with a density of its own, each frame would have other dots for the link, and n_S
    # and d over time would show the density too
    density = density_for_d_link(molecule.xyz[0], atom_radii, surface, d_link, streams.name)
    settings = settings.model_copy(update={"surface": surface.model_copy(update={"density": density})})
    first, last = (molecule.n_frames * k // part[1] for k in (part[0] - 1, part[0]))
    rows: list[dict[str, Any]] = []
    while first + len(rows) < last:
        # `begin` is bound as a default, since `rows` is longer in the next round
        def row_of(i: int, _: int, begin: int = first + len(rows)) -> dict[str, Any]:
            return frame_row(molecule, begin + i, atom_radii, settings, streams)

        n_frames = min(FRAMES_PER_REPORT, last - first - len(rows))
        rows += parallel_map(row_of, n_frames, threads, 1)
        progress(len(rows), last - first)
    return pd.DataFrame(rows)


def frame_row(
    molecule: Molecule, position: int, atom_radii: np.ndarray, settings: StudySettings, streams: Streams
) -> dict[str, Any]:
    """Evaluate one frame and return its row; an error names the frame."""
    ensemble = settings.ensemble
    assert settings.surface.density != "auto"  # it is one for all frames
    frame = surface_of_frame(molecule, position, atom_radii, settings, streams)
    prepared = frame.prepared
    if position == 0:  # the spacing of the dots follows from the settings and is the same in every frame
        where = f"{streams.name}, frame {molecule.frame_number[position]}"
        refuse_sparse(prepared.points, settings.patches.d_link, where)
    n_tests = number_of_tests(ensemble.test_dots, len(prepared))
    readings = settings.evaluation.grid_readings
    result = grid.evaluate_grid(prepared, [ensemble.combination], n_tests, DRAWS_PER_FRAME, readings)
    row = grid_table(result).drop(columns=PARAMETERS)
    return {
        **frame.columns,
        **{str(column): value for column, value in row.iloc[0].items()},
        **{f"{RESIDUE_PREFIX}{k}": value for k, value in enumerate(frame.roughness_by_residue())},
    }


def split_residue_columns(table: pd.DataFrame, residues: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Split the rows of `evaluate_frames` into a table without residues, and one with frame, time_ps and the residues."""
    columns = [name for name in table.columns if name.startswith(RESIDUE_PREFIX)]
    labels = residues["chain"] + ":" + residues["residue_name"] + residues["residue"]
    over_time = table[["frame", "time_ps", *columns]].set_axis(["frame", "time_ps", *labels], axis=1)
    return table.drop(columns=columns), over_time
