"""n_S and d of one combination over all frames of a trajectory, in one job that can be taken up again."""

import hashlib
import io
import json
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from sparsurf import InputError
from sparsurf.dots import fitting_density, molecular_surface, surface_by_dms_program
from sparsurf.evaluation import Evaluator, number_of_tests
from sparsurf.parallel import over_slices
from sparsurf.patches import refuse_sparse
from sparsurf.radii import radii
from sparsurf.tables import PARAMETERS, grid_table

CHUNK = 20  # frames between two writes: what a kill can cost


def follow(molecule, settings, name, threads, path_to_part, code="", progress=lambda done, of: None):
    """Evaluate one combination on every frame.

    Parameters
    ----------
    molecule : structure.Molecule
    settings : dict
        The config's `surface`, `patches`, `sampling`, `evaluation`, `ensemble` and `seed`.
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

    Returns
    -------
    DataFrame, one row per frame: frame, time_ps, N, area (Å^2), mean_roughness, then the columns of
    `tables.grid_table` without the parameters and halves.
    """
    mark = f"# {fingerprint(molecule, settings, name, code)}\n"
    header, rows = rows_done(path_to_part, mark)
    atom_radii = radii(molecule, settings["surface"]["radii"])
    density = fitting_density(
        molecule.xyz[0], atom_radii, settings["surface"], settings["patches"]["D_link"], name
    )
    settings = settings | {"surface": settings["surface"] | {"density": density}}  # the same for all frames
    Path(path_to_part).write_text("".join([mark, header, *rows]), encoding="utf-8")
    with threadpool_limits(1, "blas"):
        for a in range(len(rows), molecule.n_frames, CHUNK):
            chunk = pd.DataFrame(
                over_slices(
                    lambda i, _, a=a: frame_row(molecule, a + i, atom_radii, settings, name),
                    min(CHUNK, molecule.n_frames - a),
                    threads,
                    1,
                )
            )
            with open(path_to_part, "a", encoding="utf-8") as stream:
                stream.write(chunk.to_csv(index=False, header=a == 0, lineterminator="\n"))
            progress(a + len(chunk), molecule.n_frames)
    text = Path(path_to_part).read_text(encoding="utf-8").removeprefix(mark)
    return pd.read_csv(io.StringIO(text))


def fingerprint(molecule, settings, name, code):
    """Digest of everything that the rows depend on."""
    content = hashlib.sha256(json.dumps([settings, name, code], sort_keys=True).encode())
    for array in (molecule.xyz, molecule.frame_number, molecule.time_ps):
        content.update(np.ascontiguousarray(array).tobytes())
    content.update("\0".join(molecule.element.tolist()).encode())
    return content.hexdigest()[:32]


def rows_done(path, mark):
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
    return (sound[0], sound[1:]) if sound else ("", [])


def frame_row(molecule, position, atom_radii, settings, name):
    """The row of one frame, a dict.

    Raises
    ------
    InputError : with the number of the frame
    """
    number, own = int(molecule.frame_number[position]), settings["ensemble"]
    where = f"{name}, frame {number}"
    try:
        surface = frame_surface(molecule, position, atom_radii, settings["surface"])
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    evaluator = Evaluator.from_settings(surface, settings, None, f"{name}/f{number}", 1)
    if position == 0:  # the spacing of the dots is that of the settings, the same in every frame
        refuse_sparse(evaluator.index, evaluator.d_link, where)
    grid = evaluator.grid(
        [own["combination"]],
        number_of_tests(own["test_dots"], len(surface)),
        own["draws"],
        tuple(settings["evaluation"]["islands"]),
    )
    row = grid_table(grid).drop(columns=PARAMETERS).filter(regex="^(?!d_half)")
    return {
        "frame": number,
        "time_ps": float(molecule.time_ps[position]),
        "N": len(surface),
        "area": float(surface.area.sum()),
        "mean_roughness": float(evaluator.roughness.mean()),
        **row.iloc[0].to_dict(),
    }


def frame_surface(molecule, position, atom_radii, settings):
    """Surface of one frame, dot by dot the one of the same frame as a conformation (which a PDB file stores)."""
    probe, density = settings["probe_radius"], settings["density"]
    if settings["method"] == "dms":
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "frame.pdb")
            molecule.write_pdb(path, position)
            return surface_by_dms_program(path, probe, density)
    xyz = molecule.xyz[position].round(3)  # Å, the decimals of a PDB file
    return molecular_surface(xyz, atom_radii, probe, density, settings["reentrant"])
