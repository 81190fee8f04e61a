"""Reading of a surface from a file of any format."""

from sparsurf import InputError
from sparsurf.files import read_bytes
from sparsurf.surfaces.formats import compact, csv, dms, npz, ply, vtp

# Every surface format, one line each; the first that knows a file by its beginning reads it.
FORMATS = (
    compact.FORMAT,
    npz.FORMAT,
    csv.FORMAT,
    dms.FORMAT,
    ply.FORMAT,
    vtp.FORMAT,
)
HEAD = 100_000  # bytes that tell the format


def read_surface(path):
    """Read dots from a DMS file (with normals), the authors' CSV, the vertices of a PLY mesh or our npz, each also as .gz.

    Parameters
    ----------
    path : told apart by content

    Returns
    -------
    Surface, in the order of the file, of dots that occur twice the first; normals of another length are brought to unit length

    Raises
    ------
    InputError : not such a file, no normals, NaN or infinite numbers, normals of length 0, no dots

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.read_surface("protein.dms")  # doctest: +SKIP
    >>> dots.points, dots.normals, dots.area  # doctest: +SKIP
    """
    content, found = _read(path)
    return found.read(content, path)


def read_places(path):
    """Read places from a CSV with x,y,z or from a file of dots.

    Parameters
    ----------
    path : told apart by content

    Returns
    -------
    (T, 3) float64, Å, in the order of the file

    Raises
    ------
    InputError : not such a file, NaN or infinite numbers, no places
    """
    content, found = _read(path)
    return csv.read_places(content, path) if found is csv.FORMAT else found.read(content, path).points


def _read(path):
    """The bytes of a file of dots, unpacked, and its Format."""
    content = read_bytes(path)
    for each in FORMATS:
        if each.read and each.sniff(content[:HEAD]):
            return content, each
    raise InputError(
        f"{path} holds no dots; expected a DMS file, a CSV with x,y,z,nx,ny,nz, a PLY or an npz."
    )
