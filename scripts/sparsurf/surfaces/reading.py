"""Reading of a surface from a file of any format."""

from sparsurf import InputError
from sparsurf.surfaces.formats.registry import FORMATS
from sparsurf.texts import read_bytes

HEAD = 100_000  # bytes that tell the format


def read_surface(path):
    """Read dots from a DMS file (with normals), the authors' CSV, the vertices of a PLY mesh or our npz, each also as .gz.

    Parameters
    ----------
    path : told apart by content

    Returns
    -------
    Surface, see `surface.surface_of_columns`

    Raises
    ------
    InputError : not such a file, no normals, NaN or infinite numbers, normals of length 0, no dots

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.read_surface("protein.dms")  # doctest: +SKIP
    >>> dots.points, dots.normals, dots.area  # doctest: +SKIP
    """
    content = read_bytes(path)
    for each in FORMATS:
        if each.read and each.sniff(content[:HEAD]):
            return each.read(content, path)
    raise InputError(
        f"{path} holds no dots; expected a DMS file, a CSV with x,y,z,nx,ny,nz, a PLY or an npz."
    )
