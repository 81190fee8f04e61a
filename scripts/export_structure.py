"""Write the files of one structure of a study of thousands: `python scripts/export_structure.py results/many NAME [FOLDER]`.

RUN is the folder of the results, NAME one of its structures, and FOLDER, by default NAME, takes the files for PyMOL and others.
"""

import sys

from sparsurf.errors import InputError
from sparsurf.files import open_closed_streams
from sparsurf_study.report.export import export_structure


def main(*arguments: str) -> int:
    """Write the files and say where they are; return the exit code."""
    open_closed_streams()
    if len(arguments) not in (2, 3) or arguments[0] in ("-h", "--help"):
        print((__doc__ or "").strip())
        return 0 if "-h" in arguments or "--help" in arguments else 2
    run, name, folder = [*arguments, arguments[1]][:3]
    try:
        print(f"{folder}/: {export_structure(run, name, folder)}")
    except (InputError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
