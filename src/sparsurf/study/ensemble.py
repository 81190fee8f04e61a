"""n_S and d of one combination over all frames of a trajectory, in jobs that can be taken up again."""

import hashlib
import io
import json
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.study import grid
from sparsurf.study.prepared_surface import PreparedSurface, number_of_tests
from sparsurf.study.residues import mean_roughness_by_residue
from sparsurf.study.tables import grid_table
from sparsurf.surfaces.molecular_surface import fitting_density, surface_of
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spacing import refuse_sparse
from sparsurf.threads import parallel_map

OF_RESIDUE = "residue_"  # begins the names of the columns of residues
CHUNK = 20  # frames between two writes: what a kill can cost


def evaluate_frames(
    molecule, settings, name, threads, path_to_part, code="", progress=lambda done, of: None, part=(1, 1)
):
    """Evaluate one combination on every frame, or on those of a part.

    Parameters
    ----------
    molecule : molecule.Molecule
    settings : dict
        The config's `as_written`, `patches`, `sampling`, `evaluation`, `ensemble` and `seed`.
    name : str
        Of the protein; names the random streams.
    threads : int
        Frames side by side; the table does not depend on it.
    path_to_part : path
        File of the rows done so far. Rows that a run of the same molecule, settings and `code` left there are
        not computed again.
    code : str
        Digest of the program.
    progress : callable
        Told how many of how many frames are done.
    part : (k, n)
        The k-th, from 1, of n equal parts of the frames; the texts of all parts, one after the other, are that of the
        whole.

    Returns
    -------
    str, CSV with a header before the first frame, one row per frame: frame, time_ps, N, area (Å^2), mean_roughness, then
    the columns of `tables.grid_table` without the parameters, then the mean R_i of each residue (see `apart`).
    """
    mark = f"# {fingerprint(molecule, settings, name, code)} {part[0]} of {part[1]}\n"
    header, rows = read_finished_rows(path_to_part, mark)
    atom_radii = radii(molecule, settings["surface"]["radii"])
    density = fitting_density(
        molecule, 0, atom_radii, settings["surface"], settings["patches"]["D_link"], name
    )
    settings = settings | {"surface": settings["surface"] | {"density": density}}  # the same for all frames
    first, last = (molecule.n_frames * k // part[1] for k in (part[0] - 1, part[0]))
    Path(path_to_part).write_text("".join([mark, header, *rows]), encoding="utf-8")
    for a in range(first + len(rows), last, CHUNK):
        chunk = pd.DataFrame(
            parallel_map(
                lambda i, _, a=a: frame_row(molecule, a + i, atom_radii, settings, name),
                min(CHUNK, last - a),
                threads,
                1,
            )
        )
        with open(path_to_part, "a", encoding="utf-8") as stream:
            stream.write(chunk.to_csv(index=False, header=a == first, lineterminator="\n"))
        progress(a + len(chunk) - first, last - first)
    text = Path(path_to_part).read_text(encoding="utf-8").removeprefix(mark)
    return text if first == 0 else text.partition("\n")[2]


def join_parts(texts):
    """DataFrame of the texts of all parts, in order."""
    return pd.read_csv(io.StringIO("".join(texts)))


def fingerprint(molecule, settings, name, code):
    """Digest of everything that the rows depend on."""
    content = hashlib.sha256(json.dumps([settings, name, code], sort_keys=True).encode())
    for array in (molecule.xyz, molecule.frame_number, molecule.time_ps):
        content.update(np.ascontiguousarray(array).tobytes())
    content.update("\0".join(molecule.element.tolist()).encode())
    return content.hexdigest()[:32]


def read_finished_rows(path, mark):
    """Header and rows, as lines, that an interrupted run with the same first line left; ("", []) without."""
    try:
        lines = Path(path).read_bytes().decode("utf-8", "replace").splitlines(keepends=True)
    except FileNotFoundError:
        return "", []
    if len(lines) < 2 or lines[0] != mark:
        return "", []
    columns = lines[1].count(",")
    torn = [k for k, line in enumerate(lines) if k and (line.count(",") != columns or line[-1] != "\n")]
    sound = lines[1 : torn[0] if torn else None]
    return (sound[0], sound[1:]) if len(sound) > 1 else ("", [])  # a header alone is written again


def frame_row(molecule, position, atom_radii, settings, name):
    """The row of one frame, a dict.

    Raises
    ------
    InputError : with the number of the frame
    """
    number, own = int(molecule.frame_number[position]), settings["ensemble"]
    where = f"{name}, frame {number}"
    try:
        surface = surface_of(molecule, position, atom_radii, settings["surface"])
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    evaluator = PreparedSurface.from_settings(surface, settings, None, f"{name}/f{number}", 1)
    if position == 0:  # the spacing of the dots is that of the settings, the same in every frame
        refuse_sparse(evaluator.points, evaluator.d_link, where)
    result = grid.evaluate_grid(
        evaluator,
        [own["combination"]],
        number_of_tests(own["test_dots"], len(surface)),
        own["draws"],
        tuple(settings["evaluation"]["readings"]),
    )
    row = grid_table(result).drop(columns=PARAMETERS)
    of_residues = mean_roughness_by_residue(
        evaluator.roughness, molecule.residue_index[surface.atom], molecule.n_residues
    )
    return {
        "frame": number,
        "time_ps": float(molecule.time_ps[position]),
        "N": len(surface),
        "area": float(surface.area.sum()),
        "mean_roughness": float(evaluator.roughness.mean()),
        **row.iloc[0].to_dict(),
        **{f"{OF_RESIDUE}{k}": value for k, value in enumerate(of_residues)},
    }


def split_residue_columns(table, residues):
    """The rows of `follow` as two tables: without the residues, and frame and time_ps with a column for each of them.

    Parameters
    ----------
    table : DataFrame
        See `follow`.
    residues : DataFrame with chain, residue, residue_name
        See `Molecule.residues`.
    """
    own = [name for name in table if name.startswith(OF_RESIDUE)]
    labels = residues["chain"] + ":" + residues["residue_name"] + residues["residue"]
    over_time = table[["frame", "time_ps", *own]].set_axis(["frame", "time_ps", *labels], axis=1)
    return table.drop(columns=own), over_time
