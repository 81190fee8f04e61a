"""n_S and d of one combination over all frames of a trajectory, in jobs that can be resumed."""

import hashlib
import io
import json
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.molecules.molecule import Molecule
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.study import grid
from sparsurf.study.prepared_surface import number_of_tests, prepare_surface
from sparsurf.study.residues import mean_roughness_by_residue
from sparsurf.study.tables import grid_table
from sparsurf.surfaces.components import on_cavities
from sparsurf.surfaces.molecular_surface import components_of_frame, density_for_d_link, surface_of_frame
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spacing import refuse_sparse
from sparsurf.threads import parallel_map

RESIDUE_PREFIX = "residue_"  # of the columns of residues
FRAMES_PER_WRITE = 20  # the most frames that are lost if the job is killed


def evaluate_frames(
    molecule: Molecule,
    settings: Mapping[str, Any],
    name: str,
    threads: int,
    path_to_part: Path | str,
    code: str = "",
    progress: Callable[[int, int], None] = lambda done, of: None,
    part: tuple[int, int] = (1, 1),
) -> str:
    """Evaluate one combination on every frame of a trajectory, or of a part of it.

    Parameters
    ----------
    molecule : Molecule
    settings : dict
        The config's `surface`, `patches`, `sampling`, `evaluation`, `ensemble` and `seed`.
    name : str
        Name of the protein, which names the random streams.
    threads : int
        Number of frames evaluated in parallel; it does not change the table.
    path_to_part : path
        File of the finished rows. Rows that an earlier run wrote there with the same molecule, settings and `code` are
        reused.
    code : str
        Digest of the program.
    progress : callable
        Callback with the numbers of finished and total frames.
    part : (k, n)
        Evaluate the k-th, from 1, of n equal parts of the frames. The texts of all parts joined are the text of the whole.

    Returns
    -------
    str, CSV with a header before the first frame, one row per frame: frame, time_ps, N, area (Å^2), mean_roughness, then the
    columns of `tables.grid_table` without the parameters, then the mean R_i of each residue (see `split_residue_columns`).
    """
    mark = f"# {fingerprint(molecule, settings, name, code)} {part[0]} of {part[1]}\n"
    header, rows = read_finished_rows(path_to_part, mark)
    atom_radii = radii(molecule, settings["surface"]["radii"])
    density = density_for_d_link(
        molecule, 0, atom_radii, settings["surface"], settings["patches"]["D_link"], name
    )
    # one density for all frames
    settings = {**settings, "surface": settings["surface"] | {"density": density}}
    first, last = (molecule.n_frames * k // part[1] for k in (part[0] - 1, part[0]))
    Path(path_to_part).write_text("".join([mark, header, *rows]), encoding="utf-8")
    for a in range(first + len(rows), last, FRAMES_PER_WRITE):

        def row_of(i: int, _: int, begin: int = a) -> dict[str, Any]:
            return frame_row(molecule, begin + i, atom_radii, settings, name)

        chunk = pd.DataFrame(parallel_map(row_of, min(FRAMES_PER_WRITE, last - a), threads, 1))
        with open(path_to_part, "a", encoding="utf-8") as stream:
            stream.write(chunk.to_csv(index=False, header=a == first, lineterminator="\n"))
        progress(a + len(chunk) - first, last - first)
    text = Path(path_to_part).read_text(encoding="utf-8").removeprefix(mark)
    return text if first == 0 else text.partition("\n")[2]


def join_parts(texts: Iterable[str]) -> pd.DataFrame:
    """Read the table from the texts of all parts, in order."""
    return pd.read_csv(io.StringIO("".join(texts)))


def fingerprint(molecule: Molecule, settings: Mapping[str, Any], name: str, code: str) -> str:
    """Return a digest of all inputs of the rows."""
    content = hashlib.sha256(json.dumps([settings, name, code], sort_keys=True).encode())
    for array in (molecule.xyz, molecule.frame_number, molecule.time_ps):
        content.update(np.ascontiguousarray(array).tobytes())
    content.update("\0".join(molecule.element.tolist()).encode())
    return content.hexdigest()[:32]


def read_finished_rows(path: Path | str, mark: str) -> tuple[str, list[str]]:
    """Read the lines that an interrupted run with the same first line wrote.

    Returns
    -------
    header and rows, as lines; ("", []) if there are none
    """
    try:
        lines = Path(path).read_bytes().decode("utf-8", "replace").splitlines(keepends=True)
    except FileNotFoundError:
        return "", []
    if len(lines) < 2 or lines[0] != mark:
        return "", []
    columns = lines[1].count(",")
    damaged = [k for k, line in enumerate(lines) if k and (line.count(",") != columns or line[-1] != "\n")]
    intact = lines[1 : damaged[0] if damaged else None]
    return (intact[0], intact[1:]) if len(intact) > 1 else ("", [])  # a header alone is written again


def frame_row(
    molecule: Molecule, position: int, atom_radii: np.ndarray, settings: Mapping[str, Any], name: str
) -> dict[str, Any]:
    """Evaluate one frame and return its row; an error names the frame."""
    number, ensemble = int(molecule.frame_number[position]), settings["ensemble"]
    where = f"{name}, frame {number}"
    try:
        surface = surface_of_frame(molecule, position, atom_radii, settings["surface"])
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    prepared = prepare_surface(
        surface, settings["patches"], None, settings["seed"], f"{name}/f{number}", **settings["sampling"]
    )
    if position == 0:  # the spacing of the dots follows from the settings and is the same in every frame
        refuse_sparse(prepared.points, prepared.d_link, where)
    result = grid.evaluate_grid(
        prepared,
        [ensemble["combination"]],
        number_of_tests(ensemble["test_dots"], len(surface)),
        ensemble["draws"],
        tuple(settings["evaluation"]["readings"]),
    )
    row = grid_table(result).drop(columns=PARAMETERS)
    probe = settings["surface"]["probe_radius"]
    cavity = on_cavities(surface, components_of_frame(surface, molecule, position, atom_radii, probe))
    by_residue = mean_roughness_by_residue(
        np.where(cavity, np.nan, prepared.roughness),
        molecule.residue_index[surface.atom],
        molecule.n_residues,
    )
    return {
        "frame": number,
        "time_ps": float(molecule.time_ps[position]),
        "N": len(surface),
        "area": float(surface.area.sum()),
        "mean_roughness": float(prepared.roughness.mean()),
        **{str(column): value for column, value in row.iloc[0].items()},
        **{f"{RESIDUE_PREFIX}{k}": value for k, value in enumerate(by_residue)},
    }


def split_residue_columns(table: pd.DataFrame, residues: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Split the rows of `evaluate_frames` into a table without residues, and one with frame, time_ps and the residues."""
    columns = [name for name in table.columns if name.startswith(RESIDUE_PREFIX)]
    labels = residues["chain"] + ":" + residues["residue_name"] + residues["residue"]
    over_time = table[["frame", "time_ps", *columns]].set_axis(["frame", "time_ps", *labels], axis=1)
    return table.drop(columns=columns), over_time
