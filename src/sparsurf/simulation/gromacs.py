"""The program GROMACS: where it is, which version, and its errors as one sentence."""

import os
import re
import shutil
import subprocess
from pathlib import Path

from sparsurf import InputError

PROGRAMS = ("gmx", "gmx_mpi")
OLDEST = 2019  # the paper's version; older ones do not know all parameters
REASON = r"(?:Fatal error|Error in user input|Inconsistency in user input|File input/output error):\s*\n(.*?)\n\s*\n"
MISSING = (
    "simulate needs GROMACS, but there is no program gmx on the PATH: install it (Debian: apt install gromacs; conda: "
    "conda install -c conda-forge gromacs; on a cluster: module load gromacs), or give a trajectory instead."
)


def program():
    """Path of the GROMACS program.

    Raises
    ------
    InputError : there is none
    """
    for name in PROGRAMS:
        path = shutil.which(name)
        if path:
            return path
    raise InputError(MISSING)


def version():
    """Version of GROMACS as it says itself, '2022.5' say.

    Raises
    ------
    InputError : no GROMACS, or one older than OLDEST
    """
    said = _facts().get("GROMACS version", "unknown")
    year = re.match(r"\d+", said)
    if year and int(year.group()) < OLDEST:
        raise InputError(f"simulate needs GROMACS {OLDEST} or later, but {program()} is version {said}.")
    return said


def _facts():
    """What `gmx --version` says, by name."""
    said = subprocess.run([program(), "--version"], capture_output=True, text=True, check=False).stdout
    return {
        key.strip(): value.strip() for key, _, value in (line.partition(":") for line in said.splitlines())
    }


def force_field_folder(name):
    """Folder of a force field.

    Raises
    ------
    InputError : GROMACS does not have it
    """
    tops = [os.environ.get("GMXLIB"), Path(_facts().get("Data prefix", "/usr"), "share", "gromacs", "top")]
    if os.environ.get("GMXDATA"):
        tops.insert(1, Path(os.environ["GMXDATA"], "top"))
    tops = [Path(top) for top in tops if top]
    for top in tops:
        if (top / f"{name}.ff").is_dir():
            return top / f"{name}.ff"
    known = sorted({folder.name[:-3] for top in tops for folder in top.glob("*.ff")})
    raise InputError(f"simulate.force_field: GROMACS has no {name!r}; it has {', '.join(known) or 'none'}.")


def run(*arguments, folder, given="", wait=None):
    """Run `gmx` in a folder; what it says goes to the job's log.

    Parameters
    ----------
    arguments : words of the command line
    folder : where it runs
    given : str, its standard input
    wait : callable, optional, called about once a second while it runs

    Returns
    -------
    str : all that it said

    Raises
    ------
    InputError : it failed; the message holds GROMACS's own reason
    """
    command = [program(), "-quiet", "-nobackup", *map(str, arguments)]
    with subprocess.Popen(
        command,
        cwd=folder,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
    ) as process:
        said, text = "", given
        while True:
            try:
                said, _ = process.communicate(text, timeout=1.0)
                break
            except subprocess.TimeoutExpired:
                text = None
                if wait:
                    wait()
            except BaseException:  # the study is stopped: GROMACS writes a checkpoint on SIGTERM
                process.terminate()
                process.wait()
                raise
    print(said)
    if process.returncode:
        raise InputError(f"GROMACS could not do `gmx {arguments[0]}`: {reason(said)}")
    return said


def reason(said):
    """Why GROMACS failed, in one line, from what it said."""
    found = re.search(REASON, said + "\n\n", re.S)
    text = found.group(1) if found else (said.strip().splitlines() or ["it gave no reason"])[-1]
    return " ".join(text.split()).rstrip(".") + "."
