"""Dots, triangles and tables written in the format of a file's suffix, or to standard output."""

from __future__ import annotations

import gzip
import logging
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from sparsurf import registry
from sparsurf.api.inputs import MoleculeLike, as_molecule, check_frame, is_subset
from sparsurf.api.page_metadata import About
from sparsurf.api.replacing import beside_mesh, beside_script, path_of_faces, refuse_replacing
from sparsurf.api.scenes import SCENES, chimerax_script, write_scene
from sparsurf.arguments import ColourLimits, public
from sparsurf.errors import InputError, argument, naming_file
from sparsurf.files import as_path, closed_streams, ends_in, shorten
from sparsurf.molecules.formats import title
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.pdb import pdb_b_factor
from sparsurf.surfaces.chosen_points import NamedPoints, Points
from sparsurf.surfaces.formats.colours import KIND_COLOURS, Scale, check_limits, scale_of
from sparsurf.surfaces.formats.csv import TABLE_FORMAT, write_csv
from sparsurf.surfaces.formats.dms import write_dms
from sparsurf.surfaces.formats.meshes import BY_TRIMESH, import_trimesh, write_by_trimesh, write_vtp
from sparsurf.surfaces.formats.msms import Header, write_faces, write_vertices
from sparsurf.surfaces.formats.ply import write_ply
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spheres import write_spheres
from sparsurf.surfaces.surface import ARRAY_NAMES, RECONSTRUCTION_COLUMNS, Surface

if TYPE_CHECKING:
    import pandas as pd

    from sparsurf.evaluation.minimal_subset import Subset
    from sparsurf.surfaces.mesh import Mesh
    from sparsurf.surfaces.surface_atoms import SurfaceAtoms

log = logging.getLogger("sparsurf")

SUFFIXES_OF_NUMBERS = registry.suffixes("fields")  # These files have room for numbers at the dots.
# PLY first: most programs open it
MESHES = tuple(
    sorted(
        (end for end in registry.suffixes("triangles") if end not in SCENES), key=lambda end: end != ".ply"
    )
)
DOTS_ALONE = (*SUFFIXES_OF_NUMBERS, *SCENES)
SUFFIXES_OF_DOTS = registry.suffixes("dots")  # DMS and MSMS name the atom of every dot
TABLE_FORMATS = registry.suffixes("residues")
OF_COLUMN = (".pdb",)  # These files hold one column of a table as B factors.
PAGE_ENDINGS = (".html",)
PAGE_FORMATS = registry.suffixes("page")  # They show dots, or residues.
SCRIPTS = registry.suffixes("script")  # They open files that are written next to them.
VIEWS = (*SCRIPTS, *PAGE_FORMATS)
# What dots of a molecule, other dots, and a mesh are written as
OUTPUTS_OF_DOTS, OUTPUTS_OF_DOTS_ALONE = (*SUFFIXES_OF_DOTS, *VIEWS), (*DOTS_ALONE, *VIEWS)
OUTPUTS_OF_MESH = (*MESHES, *SCENES, *VIEWS)
# Of a .pdb, its viewers choose the colours
COLOURED = (*{*registry.suffixes("colours")} - {".pdb"}, *VIEWS)
POSITION_COLUMNS = ("x", "y", "z", "nx", "ny", "nz")
MAX_NAME_BYTES = 255  # bytes
BESIDE_OUTPUT = ".sparsurf-"  # begins the name of the folder in which a result is written
SECONDS_OF_KILLED = 3600  # a call writes for seconds: a folder of this age is one that a killed call left


@dataclass(frozen=True)
class DotsToWrite:
    """Dots to write.

    Attributes
    ----------
    surface : Surface
    table : DataFrame of N rows, or columns (N,) by name: those besides positions and normals; a column `dot` comes first
    shown : the column that gives colours; by default the kind of the dots
    molecule : Molecule of the dots, and its frame; they cannot be written as DMS without it
    faces : (F, 3) triangles between them if they are known: then this is a mesh
    coloured : whether a PLY, OBJ or GLB has colours; without them all properties of a PLY are floats
    limits : values at the ends of the colours; by default those of the column
    single : whether numbers of an npz are float32 and its triangles int32, as networks take them
    message : what is said when they are written
    about : what a page or picture says besides the dots
    """

    surface: Surface
    table: Mapping[str, np.ndarray]
    shown: str | None = None
    molecule: Any = None
    frame: int = 0
    faces: np.ndarray | None = None
    coloured: bool = True
    limits: ColourLimits = None
    single: bool = False
    message: str = ""
    about: About = About()  # noqa: RUF009, frozen

    @property
    def formats(self) -> tuple[str, ...]:
        """Suffixes that they can be written with; a DMS file holds dots of a molecule, but no weights, a CSV no triangles."""
        if self.faces is not None:
            return OUTPUTS_OF_MESH
        has_atoms = self.molecule is not None and self.shown != "weight"
        return OUTPUTS_OF_DOTS if has_atoms else OUTPUTS_OF_DOTS_ALONE

    @property
    def numbers(self) -> dict[str, np.ndarray]:
        """The columns that hold numbers, by name; `dot` first."""
        columns = {str(name): np.asarray(column) for name, column in self.table.items()}
        columns |= {name: values for name, values in self.surface.fields.items() if name not in columns}
        left_out = {*POSITION_COLUMNS}
        if self.surface.reconstruction is not None:  # a PLY says it in its header
            left_out |= {*RECONSTRUCTION_COLUMNS}
        names = sorted((name for name in columns if name not in left_out), key=lambda name: name != "dot")
        return {name: columns[name] for name in names if columns[name].dtype.kind in "iuf"}

    @property
    def coloured_by(self) -> str:
        """The column that gives colours: `shown`, or the first field; empty for the kinds."""
        return self.shown or next(iter(self.surface.fields), "")

    @property
    def scale(self) -> Scale | None:
        """The numbers (N,) that give colours, and these colours; None for the kinds."""
        name = self.coloured_by
        if not name:
            return None
        values = (self.table if name in self.table else self.surface.fields)[name]
        is_prediction = getattr(_molecule_of(self)[0], "is_prediction", False)
        return scale_of(name, values, self.limits, is_prediction)

    def key(self, output: str | Path) -> Scale | None:
        """Return the scale that colours a file of the dots; None for kinds, one colour, and a format without colours."""
        in_one = self.shown == "weight" and not ends_in(output, ".ply")
        return self.scale if ends_in(output, COLOURED) and not in_one else None

    def columns(self) -> dict[str, Any]:
        """Return all columns, in the order of a CSV."""
        columns = {str(name): column for name, column in self.table.items()}
        columns |= {name: values for name, values in self.surface.fields.items() if name not in columns}
        positions = zip(POSITION_COLUMNS, [*self.surface.points.T, *self.surface.normals.T], strict=True)
        dot = {"dot": columns.pop("dot")} if "dot" in columns else {}
        return (
            dot | dict(positions) | {n: column for n, column in columns.items() if n not in POSITION_COLUMNS}
        )


def parse_output(output: str | Path, formats: Sequence[str]) -> tuple[str, bool, Path | None]:
    """Return the suffix that decides (csv for '-'), whether the file is packed (.gz), and its folder, None for a stream.

    Raise InputError if the suffix is unknown, the folder does not exist, or a folder has this name.
    """
    name = str(output)
    if "\0" in name or len(os.path.basename(name).encode(errors="surrogateescape")) > MAX_NAME_BYTES:
        raise InputError(
            f"{shorten(repr(name))} cannot name a file; choose a shorter name of letters and digits."
        )
    if name == "-" and "stdout" in closed_streams:
        raise InputError("the standard output is closed: open it, or name a file to write.")
    if name != "-" and os.path.isdir(name):
        raise InputError(f"{name} is a folder; name a file to write.")
    bare = name[:-3] if name.lower().endswith(".gz") else name
    suffix = ".csv" if name == "-" else Path(bare).suffix.lower()
    if suffix not in formats:
        why = f"this result cannot be written as {suffix!r}" if suffix else "the name has no suffix"
        is_picture = suffix in PAGE_FORMATS and formats == PAGE_ENDINGS
        other = ", or draw a picture by `sparsurf roughness FILE -o NAME.png`" if is_picture else ""
        raise InputError(f"{name}: {why}; name a file that ends in {', '.join(formats)}{other}.")
    stream = name == "-" or (os.path.exists(name) and not os.path.isfile(name))  # a pipe or a device
    folder = None if stream else Path(os.path.realpath(name)).parent
    if folder is not None and not folder.is_dir():
        raise InputError(f"{name}: there is no folder {folder}; create it first.")
    if folder is not None and not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{name}: you have no permission to write into {folder}; choose another folder.")
    return suffix, bare != name, folder


def write_file(
    output: str | Path, writers: Mapping[str, Callable[[Path], Any]], formats: Sequence[str] = ()
) -> None:
    """Write a result under its final name once it is whole; what is a link, a pipe or a device stays one.

    `writers` are functions of a path by suffix; output and formats, by default these suffixes, are those of `parse_output`.
    """
    suffix, packed, folder = parse_output(output, formats or [*writers])
    if suffix in BY_TRIMESH:
        import_trimesh(output)  # before the folder of the result, whose name the error would have
    _remove_leftovers(folder)
    with tempfile.TemporaryDirectory(dir=folder, prefix=BESIDE_OUTPUT) as temporary:
        path = Path(temporary, f"part{suffix}")
        writers[suffix](path)
        if packed:
            path.write_bytes(gzip.compress(path.read_bytes(), mtime=0))
        if folder is not None:
            os.replace(path, os.path.realpath(output))
        elif str(output) != "-":
            Path(output).write_bytes(path.read_bytes())
        else:
            with open(path, "rb") as content:
                shutil.copyfileobj(content, sys.stdout.buffer)
            sys.stdout.buffer.flush()


def _remove_leftovers(folder: Path | None) -> None:
    """Remove what killed calls left in the folder of an output; by age, as several calls may write into it at once."""
    for left in folder.glob(f"{BESIDE_OUTPUT}*") if folder else ():
        with suppress(OSError):
            if time.time() - left.lstat().st_mtime > SECONDS_OF_KILLED:
                for part in left.glob("part.*"):
                    part.unlink()
                left.rmdir()  # which fails where it holds a file of the user


def write_page(path: str | Path, html: str) -> None:
    """Write a page under its final name once it is whole."""
    write_file(path, {".html": lambda file: file.write_text(html, encoding="utf-8")})


def write_dots(output: str | Path, dots: DotsToWrite) -> None:
    """Write Dots in the format of the suffix."""
    surface, scale, coloured = dots.surface, dots.scale, dots.coloured or dots.limits is not None
    if dots.limits is not None and dots.key(output) is None:
        raise InputError(
            f"{argument('limits')} are those of the colours of a field, and {output} has none; leave them out."
        )
    if ends_in(output, SCRIPTS):
        _write_chimerax(Path(output), dots)
        return

    def ply(path: Path) -> None:
        values = dots.numbers
        if scale and coloured:
            del values[scale.name]
        write_ply(path, surface, scale if coloured else None, values, dots.faces, coloured)

    def by_trimesh(path: Path) -> None:
        assert dots.faces is not None  # `formats` has these suffixes for meshes only
        colours = scale.colours if scale else KIND_COLOURS[surface.kind]
        shown = colours if coloured and path.suffix != ".stl" else None
        write_by_trimesh(path, surface.points, surface.normals, dots.faces, shown)

    def dms(path: Path) -> None:
        molecule = dots.molecule
        write_dms(
            path, surface, molecule.residue_name, molecule.residue, molecule.name, molecule.xyz[dots.frame]
        )

    def npz(path: Path) -> None:
        arrays = {name: getattr(surface, name) for name in ARRAY_NAMES}
        if dots.faces is not None:
            arrays = {"vertices": arrays.pop("points"), **arrays, "faces": dots.faces}
        arrays |= {name: values for name, values in surface.fields.items() if name not in dots.table}
        columns = {str(name): column for name, column in dots.table.items() if name not in POSITION_COLUMNS}
        arrays |= {name: np.asarray(column) for name, column in columns.items() if name not in arrays}
        if dots.single:
            arrays = {name: _single(array) for name, array in arrays.items()}
        _npz(path, arrays)

    n_spheres, names, header = _spheres_of(dots, str(output))

    @cache
    def numbers() -> np.ndarray:
        """Return the numbers of the faces, which both files of MSMS have."""
        from sparsurf.surfaces.components import faces_of_vertices  # here: other formats need no kernels

        return faces_of_vertices(surface)

    writers: dict[str, Callable[[Path], Any]] = {
        ".vert": lambda path: write_vertices(path, surface, numbers(), n_spheres, names, header),
        ".csv": lambda path: write_csv(path, dots.columns(), sorted(surface.fields.keys() - {*dots.table})),
        ".npz": npz,
        ".ply": ply,
        ".dms": dms,
        ".vtp": lambda path: write_vtp(path, surface.points, surface.normals, dots.numbers, dots.faces),
    }
    writers |= dict.fromkeys(BY_TRIMESH, by_trimesh)
    writers |= dict.fromkeys(SCENES, lambda path: _write_scene(path, dots))
    writers[".html"] = lambda path: _write_page(path, dots)
    writers[".png"] = lambda path: _write_picture(path, dots, str(output))
    if dots.faces is not None and ends_in(output, ".csv"):
        raise InputError(
            f"{output}: a CSV cannot store the triangles of a mesh; name a file that ends in {', '.join(dots.formats)}, or write "
            "its vertices."
        )
    if dots.faces is not None:
        refuse_replacing(output, companions=beside_mesh(output))
    write_file(output, writers, dots.formats)
    if (faces := dots.faces) is not None and (second := path_of_faces(output)) is not None:
        write_file(
            second, {".face": lambda path: write_faces(path, surface, numbers(), faces, n_spheres, header)}
        )


def _spheres_of(dots: DotsToWrite, output: str) -> tuple[int, list[str] | None, Header]:
    """Return the number and the names of the spheres that dots lie on, and the header of their files of MSMS."""
    surface, molecule = dots.surface, dots.molecule
    origin = surface.origin
    molecule = origin.molecule if molecule is None and origin else molecule
    n = int(surface.atom.max()) + 1 if origin is None else len(origin.radii)
    names = None
    if molecule is not None and ends_in(output, ".vert"):
        names = _names_of_atoms(molecule)
        n = len(names)
    area = float(surface.area.sum())
    density = len(surface) / area if area > 0 else 0.0  # NaN where areas are unknown
    return n, names, Header(os.path.basename(output), density, origin.rules.probe_radius if origin else 0.0)


def _write_page(path: Path, dots: DotsToWrite) -> None:
    """Write the page of dots; of a subset whose whole surface is known, that of the surface with the kept dots."""
    from sparsurf.api.pages import page_of_surface  # here: other formats need none of its modules

    about, surface = dots.about, dots.surface
    if about.whole is not None:
        surface, about = about.whole, replace(about, kept=np.asarray(dots.table["dot"]))
    html = page_of_surface(surface, about, dots.coloured_by or "kind", limits=dots.limits)
    path.write_text(html, encoding="utf-8")


def _write_picture(path: Path, dots: DotsToWrite, output: str) -> None:
    """Write the picture of dots, by the values shown or by kind: kept ones on their whole surface where it is known."""
    from sparsurf.api.pages import save_picture

    surface, about = dots.surface, dots.about
    if scale := dots.key(path):
        save_picture(path, output, "values_picture", surface, scale, about.name, about.whole)
    elif about.whole is not None:
        save_picture(path, output, "kept_picture", about.whole, surface, about.name)
    else:
        save_picture(path, output, "kinds_picture", surface, about.name)


def _single(array: np.ndarray) -> np.ndarray:
    """Return numbers as float32 or int32, and anything else as it is."""
    single = {"f": np.float32, "i": np.int32}.get(array.dtype.kind)
    return array if single is None or array.dtype.itemsize < 8 else array.astype(single)


def mesh_dots(mesh: Mesh) -> DotsToWrite:
    """Return a Mesh as Dots: its vertices with the area around each, and the atom where it is known."""
    message = f"{len(mesh.triangles):,} triangles, {mesh.volume:,.0f} Å^3"
    vertices = mesh.vertices
    table = replace(vertices, fields={}).columns()
    if vertices.kind.max() < 0:
        del table["kind"]
    return DotsToWrite(vertices, table, faces=mesh.triangles, coloured=False, single=True, message=message)


def recovered_dots(dense: Surface) -> DotsToWrite:
    """Return a surface that was reconstructed from its first dots, which have a 1 in the column kept."""
    assert dense.recovered is not None
    kept = np.arange(len(dense)) < dense.recovered.n_kept
    return DotsToWrite(dense, {"area": dense.area, "kept": kept.astype(int)})


def write_table(
    output: str | Path,
    table: pd.DataFrame | Mapping[str, np.ndarray],
    arrays: Mapping[str, Any] | None = None,
    about: About = About(),  # noqa: B008, frozen
    surface: Surface | None = None,
    *,
    column: str | None = None,
    molecule: Molecule | None = None,
    frame: int = 0,
) -> None:
    """Write a DataFrame or columns by name as CSV, or arrays by name (by default its columns) as npz; a named index is a column.

    Residues can also be written as a page or a picture of their profile; `about` says what the page does besides, and
    `surface` are the dots that they were measured on. A `column` is written as the B factors of a frame of the molecule.
    """
    if column is not None or ends_in(output, OF_COLUMN):
        _write_column(output, _frame(table), column, molecule, frame)
        return

    def csv(path: Path) -> None:
        if isinstance(table, Mapping):
            write_csv(path, table, form=TABLE_FORMAT)
        else:
            table.to_csv(path, index=False, float_format=TABLE_FORMAT)

    table = table if isinstance(table, Mapping) or not table.index.name else table.reset_index()
    columns = {str(name): column for name, column in table.items()} if arrays is None else arrays
    writers: dict[str, Callable[[Path], Any]] = {".csv": csv, ".npz": lambda path: _npz(path, columns)}
    writers |= dict.fromkeys(
        PAGE_FORMATS, lambda path: _write_profile(path, _frame(table), about, surface, str(output))
    )
    write_file(output, writers)


def _frame(table: pd.DataFrame | Mapping[str, np.ndarray]) -> pd.DataFrame:
    """Return a table, or its columns by name, as a DataFrame."""
    import pandas as pd  # here: it takes long to load

    return pd.DataFrame(table)


def _write_column(
    output: str | Path, table: pd.DataFrame, column: str | None, molecule: Molecule | None, frame: int
) -> None:
    """Write a frame of a molecule as PDB, whose B factors are a column of a table of its residues or atoms."""
    from sparsurf.dot_fields.columns import values_from_rows  # here: few results are written in this way

    if column is None or molecule is None:
        missing = "column" if column is None else "molecule"
        raise InputError(
            f"{output}: a PDB file of a table is the molecule with a column as its B factors; give {argument(missing)} as well."
        )
    check_frame(molecule, frame, "the molecule")
    with naming_file("the table"):
        values = values_from_rows(table, column, molecule)
    fitting = pdb_b_factor(values)
    if (np.abs(fitting - values) > 0).any():
        raise InputError(
            f"{output}: {column} is {np.nanmin(values):.6g} to {np.nanmax(values):.6g}, and the B factors of a PDB file hold "
            "-99.99 to 999.99; scale the column."
        )
    if lacking := int(np.isnan(values).sum()):
        log.warning("%s: %d atoms have no %s; their B factor is 0", output, lacking, column)
    write_file(output, {".pdb": lambda file: molecule.write_pdb(file, frame, fitting)})


def _write_profile(
    path: Path, table: pd.DataFrame, about: About, surface: Surface | None, output: str
) -> None:
    """Write the page or the picture of a table of residues, or the page that lists a table of regions."""
    from sparsurf.api.pages import page_of_residues, page_of_surface, refuse_other_table, save_picture

    if surface and "region" in table:
        regions = table[["area", "mean", "residues"]].to_numpy().tolist()
        page = page_of_surface(surface, about, next(iter(surface.fields)), regions=regions)
        path.write_text(page, encoding="utf-8")
        return
    refuse_other_table(table, output)
    if path.suffix == ".html":
        named = about if about.name else replace(about, name=Path(output).stem)
        path.write_text(page_of_residues(table, named, surface), encoding="utf-8")
    else:
        save_picture(path, output, "profile_picture", table, about.name)


@public()
def write(
    result: Surface | Points | Subset | Mesh | Molecule | SurfaceAtoms | pd.DataFrame,
    path: str | Path,
    molecule: MoleculeLike | None = None,
    frame: int = 0,
    *,
    names: Mapping[str, str] | None = None,
    colours: bool | None = None,
    column: str | None = None,
    limits: ColourLimits = None,
) -> None:
    """Write a result in the format that the suffix of a path names, such as .csv, .npz, .ply, .dms, .pml, .html or .png.

    Parameters
    ----------
    result : Surface, Points, Subset, Mesh, Molecule, SurfaceAtoms, or DataFrame
        What is written: a Subset on its surface, a table of `residues` as the roughness along each chain, others as in the notes.
    path : str or Path
        File to write; its folder must exist.
    molecule, frame : path, Molecule, or atoms of another library, optional; int
        Molecule, and its frame (default 0), for a DMS file and for the names of atoms in a table (by default that of the dots).
    names : dict of str to str, optional
        Names that fields get in the file, such as {'hydropathy': 'hphob'}; the other fields keep theirs.
    colours : bool, optional
        Whether PLY, OBJ and GLB have colours, of the first field or the kinds. By default dots do, and a mesh has floats alone.
    column : str, optional
        Column of a table of residues or atoms, such as 'accessible', which a .pdb of `molecule` holds as B factors.
    limits : pair of float, optional
        Values at the ends of the colours, such as (-5, 5). By default ±5 kT/e for potential, ±4.5 for hydropathy, ±1 for shape
        index and hbond, 0.2 to 0.9 for roughness, and else the lowest and highest value, or AlphaFold's bands for pLDDT.

    Raises
    ------
    InputError
        The suffix does not fit the result, the folder does not exist, `names` holds a name that is not a field, or a file would
        be replaced that the molecule was read from or that, next to a .cxc or .vert, was not written there as such.

    Notes
    -----
    .pml and .cxc open the dots on their molecule in PyMOL and ChimeraX, .bild holds spheres, .vtp all numbers, .html the page of
    `show`, .parquet Points in the columns of `sparsurf points`, .png a picture by matplotlib, and .pdb each dot as an atom, whose
    B factor is its weight or first field, with an occupancy of 0 where that is unknown. A molecule is written as .pdb or as
    spheres of the radii 'dms' (.xyzr, .xyzrn); atoms of a surface as .xyzr, .pqr or .pdb (radii as B factors), with probe and
    radii in the header; a mesh as .ply, .vert with a .face, as .npz of `vertices`, `faces` and `normals`, or by trimesh as .obj,
    .glb or .stl. In .ply and .npz, its numbers are float32 and int32; an npz of dots holds `points` in place of `vertices`.

    Examples
    --------
    >>> import sparsurf
    >>> mesh = sparsurf.mesh("data/tdp43/topology.pdb", n_vertices=512, fields="hydropathy")
    >>> sparsurf.write(mesh, "/tmp/mesh.ply", names={"hydropathy": "hphob"})
    """
    refuse_replacing(as_path(path), (result, molecule))
    if names is not None and not isinstance(names, Mapping):
        raise InputError(
            f"write: names is {names!r}; it must be a dictionary such as {{'hydropathy': 'hphob'}}."
        )
    is_table = hasattr(result, "iloc")  # of pandas
    are_surface_atoms = hasattr(
        result, "is_exact"
    )  # their module loads kernels, which other results do not need
    limits = check_limits(limits)
    about_fields = names or colours is not None or limits is not None
    if (is_table or are_surface_atoms or isinstance(result, Molecule)) and about_fields:
        raise InputError(
            "write: names, colours and limits are about fields of dots and meshes; leave them out."
        )
    if column is not None and not is_table:
        raise InputError("write: column is about a table of residues or atoms; leave it out.")
    atoms = None if molecule is None else as_molecule(molecule)
    if is_table:
        if atoms is None:
            _refuse_frame(frame, 0)
        write_table(path, cast("pd.DataFrame", result), column=column, molecule=atoms, frame=frame)
    elif isinstance(result, Molecule):
        _write_molecule(result, path, frame)
    elif are_surface_atoms:
        from sparsurf.api.surface_atoms import writers_of_atoms

        write_file(path, writers_of_atoms(cast("SurfaceAtoms", result)))
    elif isinstance(result, Points) and ends_in(path, ".parquet"):
        if about_fields:
            raise InputError("write: a table of points takes no names, colours or limits; leave them out.")
        _write_points(result, path, _atoms_and_frame(result, atoms, frame)[0])
    else:
        is_shown = ends_in(path, PAGE_FORMATS)
        dots = _dots_of(result, *_atoms_and_frame(result, atoms, frame), is_shown=is_shown)
        coloured = dots.coloured if colours is None else bool(colours)
        write_dots(path, replace(_renamed(dots, names or {}), coloured=coloured, limits=limits))


def _atoms_and_frame(result: Any, atoms: Molecule | None, frame: int) -> tuple[Molecule | None, int]:
    """Return the molecule of dots and its frame: by default their own; raise InputError for another one."""
    if atoms is not None:
        check_frame(atoms, frame, "the molecule")
    result = result.surface if isinstance(result, Points) else result
    if isinstance(result, Surface) and (origin := result.origin):
        if atoms is None:
            _refuse_frame(frame, origin.frame)
            atoms, frame = origin.molecule, origin.frame
        if atoms is not None:
            origin.refuse_molecule("write", atoms, frame)
    return atoms, frame


def _dots_of(result: Any, atoms: Molecule | None, frame: int, is_shown: bool) -> DotsToWrite:
    """Return what is written of dots or a mesh; `is_shown` on a page or picture."""
    if isinstance(result, Points):
        table = {name: column for name, column in result.columns().items() if name not in result.fields}
        return DotsToWrite(result.surface, table, molecule=atoms, frame=frame, single=True)
    if is_subset(result):
        about = About(whole=_whole_of(result) if is_shown else None, notes=result.decision)
        return DotsToWrite(result.surface, result.columns(), "weight", atoms, frame, about=about)
    if isinstance(result, Surface) and result.recovered is not None and atoms is None:
        return recovered_dots(result)
    if isinstance(result, Surface):
        return DotsToWrite(result, replace(result, fields={}).columns(atoms), molecule=atoms, frame=frame)
    if hasattr(result, "triangles"):
        return mesh_dots(result) if atoms is None else replace(mesh_dots(result), molecule=atoms, frame=frame)
    raise InputError(
        f"write: give dots, a mesh, a molecule or a table, not the type {type(result).__name__}."
    )


def _write_points(points: Points, path: str | Path, atoms: Molecule | None) -> None:
    """Write points in the columns of `sparsurf points`, which begin with a name."""
    from sparsurf.api.checkpoints import table_writers  # here: few results are such tables

    files = getattr(atoms, "files", ())
    name = points.name if isinstance(points, NamedPoints) else title(files[0]) if files else ""
    table = points.to_frame()
    table.insert(0, "name", name)
    write_file(path, table_writers([table], {}))


def _write_molecule(molecule: Molecule, path: str | Path, frame: int) -> None:
    """Write a molecule as a PDB, or as the spheres of the program DMS (.xyzr, .xyzrn)."""
    check_frame(molecule, frame, "the molecule")
    xyz = molecule.xyz[frame]

    def spheres(names: list[str] | None) -> Callable[[Path], None]:
        return lambda file: write_spheres(file, xyz, radii(molecule), names)

    writers: dict[str, Callable[[Path], Any]] = {
        ".pdb": lambda file: molecule.write_pdb(file, frame),
        ".xyzr": spheres(None),
        ".xyzrn": spheres(_names_of_atoms(molecule)),
    }
    write_file(path, writers)


def _names_of_atoms(molecule: Molecule) -> list[str]:
    """Return a name without blanks for each atom: its own, and those of residue and chain."""
    labels = zip(molecule.name, molecule.residue_name, molecule.residue, molecule.chain, strict=True)
    return ["_".join(map(str, label)) for label in labels]


def _whole_of(subset: Subset) -> Surface | None:
    """Return the surface that the dots of a subset were chosen from; None if it is not known."""
    from sparsurf.api.whole_surface import placed_again  # here: other formats need none of its modules

    return placed_again(subset.surface)


def _refuse_frame(frame: int, frame_of_dots: int) -> None:
    """Raise InputError for a frame that belongs to no molecule of the arguments; dots may name their own."""
    if frame not in (0, frame_of_dots):
        raise InputError(f"write: frame={frame} is that of `molecule`; leave it out.")


def _renamed(dots: DotsToWrite, names: Mapping[str, str]) -> DotsToWrite:
    """Return dots whose fields have other names."""
    fields = dots.surface.fields
    for name in names:
        if name not in fields:
            listed = f"the fields are {', '.join(fields)}" if fields else "there are none"
            raise InputError(f"write: names has {name!r}, which is not a field here; {listed}.")
    new = {name: names.get(name, name) for name in fields}
    if twice := [name for name in new.values() if [*new.values()].count(name) > 1]:
        raise InputError(f"write: names calls two fields {twice[0]!r}; give each a name of its own.")
    surface = replace(dots.surface, fields={new[name]: values for name, values in fields.items()})
    table = {new.get(name, name): column for name, column in dots.table.items()}
    return replace(dots, surface=surface, table=table)


def _molecule_of(dots: DotsToWrite) -> tuple[Molecule | None, int]:
    """Return the molecule that is shown with dots, and its frame: the one that is given, or else their own."""
    origin = dots.surface.origin if dots.molecule is None else None
    return (origin.molecule, origin.frame) if origin else (dots.molecule, dots.frame)


def _write_chimerax(path: Path, dots: DotsToWrite) -> None:
    """Write dots, or a mesh, as NAME.cxc and the files that it opens; none of these replaces a file of another origin."""
    if parse_output(path, SCRIPTS)[1]:
        raise InputError(f"{path}: ChimeraX opens no packed script; leave out .gz.")
    molecule, frame = _molecule_of(dots)
    companions = beside_script(path)
    bild, pdb = companions
    writers: dict[Path, Callable[[Path], Any]] = {bild: lambda file: _write_scene(file, dots)}
    if molecule is not None:
        writers[pdb] = lambda file: molecule.write_pdb(file, frame)
    refuse_replacing(path, (molecule,), {file: companions[file] for file in writers})
    of_molecule = pdb.name if molecule is not None else None
    script = chimerax_script(path.name, bild.name, of_molecule, dots.key(path))
    writers[path] = lambda file: file.write_text(script, encoding="utf-8")
    for file, writer in writers.items():
        write_file(file, {file.suffix.lower(): writer})


def _write_scene(path: Path, dots: DotsToWrite) -> None:
    """Write dots, or a mesh, with the molecule that they know, for PyMOL or ChimeraX."""
    molecule, frame = _molecule_of(dots)
    write_scene(path, dots.surface, molecule, frame, dots.scale, dots.shown == "weight", dots.faces)


def _npz(path: Path, arrays: Mapping[str, Any]) -> None:
    """Write numpy arrays; strings are kept as such, as short as they are, so that nothing must be unpickled."""
    values = {name: np.asarray(array) for name, array in arrays.items()}
    texts = {
        name: array.astype(object).astype(str) for name, array in values.items() if array.dtype.kind in "OU"
    }
    columns: dict[str, Any] = values | texts
    with open(path, "wb") as stream:
        np.savez(stream, **columns)
