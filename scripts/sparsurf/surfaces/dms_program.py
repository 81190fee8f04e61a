"""The surface by UCSF's program DMS, where it is installed."""

import shutil
import subprocess
import tempfile
from pathlib import Path

from sparsurf import InputError
from sparsurf.surfaces.formats.dms import read_dms
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.texts import read_bytes


def surface_by_dms_program(path_to_pdb, probe=1.4, density=DENSITY, program="dms"):
    """Surface by UCSF's program DMS, if there is one.

    Parameters
    ----------
    path_to_pdb : PDB file of one model, all of whose atoms are used
    probe : Å
    density : dots per Å^2, as for `molecular_surface`
    program : name looked up on the PATH

    Returns
    -------
    Surface; `atom` counts the atoms of the PDB file

    Raises
    ------
    InputError : no such program, or it fails
    """
    executable = shutil.which(program)
    if executable is None:
        raise InputError(f"surface.method dms needs the program {program} on the PATH; else use analytic.")
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(path_to_pdb, Path(folder, "in.pdb"))
        command = [executable, "in.pdb", "-a", "-n", "-d", f"{density / DENSITY:.6g}"]
        command += ["-w", f"{probe:.6g}", "-o", "out.dms"]
        run = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace")
        output = Path(folder, "out.dms")
        if run.returncode != 0 or not output.is_file():
            reason = (run.stderr.strip().splitlines() or [f"exit status {run.returncode}"])[-1]
            raise InputError(f"{program} made no surface of {path_to_pdb}: {reason}")
        return read_dms(read_bytes(output), path_to_pdb)
