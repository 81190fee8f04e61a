"""Find and run GROMACS, and report its errors in one sentence."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

from sparsurf.errors import InputError

PROGRAMS = ("gmx", "gmx_mpi")
MIN_VERSION = 2019  # the paper's version; older ones lack some parameters
ERROR_PATTERN = r"(?:Fatal error|Error in user input|Inconsistency in user input|File input/output error):\s*\n(.*?)\n\s*\n"
NOT_FOUND = (
    "simulate needs GROMACS, but there is no program gmx on the PATH: install it (Debian: apt install gromacs; conda: "
    "conda install -c conda-forge gromacs; on a cluster: module load gromacs), or give a trajectory instead."
)


def program() -> str:
    """Return the path of the GROMACS program, or say that it is not on the PATH."""
    for name in PROGRAMS:
        path = shutil.which(name)
        if path:
            return path
    raise InputError(NOT_FOUND)


def version() -> str:
    """Return the version of GROMACS, such as '2022.5', or say that it is missing or older than `MIN_VERSION`."""
    name = _build_information().get("GROMACS version", "unknown")
    year = re.match(r"\d+", name)
    if year and int(year.group()) < MIN_VERSION:
        raise InputError(f"simulate needs GROMACS {MIN_VERSION} or later, but {program()} is version {name}.")
    return name


def _build_information() -> dict[str, str]:
    """Return the entries of `gmx --version` by name."""
    output = subprocess.run([program(), "--version"], capture_output=True, text=True, check=False).stdout
    entries = {}
    for line in output.splitlines():
        key, _, value = line.partition(":")
        entries[key.strip()] = value.strip()
    return entries


def force_field_folder(name: str) -> Path:
    """Return the folder of a force field, or say that GROMACS does not have it."""
    candidates: list[str | Path | None] = [os.environ.get("GMXLIB")]
    candidates += [os.environ["GMXDATA"] + "/top"] if os.environ.get("GMXDATA") else []
    candidates += [Path(_build_information().get("Data prefix", "/usr"), "share", "gromacs", "top")]
    folders = [Path(folder) for folder in candidates if folder]
    for top in folders:
        if (top / f"{name}.ff").is_dir():
            return top / f"{name}.ff"
    installed = sorted({folder.name[:-3] for top in folders for folder in top.glob("*.ff")})
    raise InputError(
        f"simulate.force_field: GROMACS has no {name!r}; it has {', '.join(installed) or 'none'}."
    )


def run_gromacs(
    *arguments: object,
    folder: str | os.PathLike[str],
    stdin: str = "",
    wait: Callable[[], None] | None = None,
) -> str:
    """Run `gmx` in a folder, print its output to the job's log and return it; an error repeats its reason."""
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
        output = ""
        text: str | None = stdin
        while True:
            try:
                output, _ = process.communicate(text, timeout=1.0)
                break
            except subprocess.TimeoutExpired:
                text = None  # `communicate` accepts the input only once
                if wait:
                    wait()
            except BaseException:  # the study was stopped; GROMACS writes a checkpoint on SIGTERM
                process.terminate()
                process.wait()
                raise
    print(output)
    if process.returncode:
        raise InputError(f"`gmx {arguments[0]}` failed: {reason(output)}")
    return output


def reason(output: str) -> str:
    """Extract the reason of a failure from the output of GROMACS, as one line."""
    error = re.search(ERROR_PATTERN, output + "\n\n", re.S)
    text = error.group(1) if error else (output.strip().splitlines() or ["it gave no reason"])[-1]
    return " ".join(text.split()).rstrip(".") + "."
