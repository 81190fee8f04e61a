"""Collect what the pages and pictures of surfaces and residues say, for `show` and for the suffixes .html and .png."""

from __future__ import annotations

import itertools
import logging
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.api.fields import DEFAULT_FIELDS
from sparsurf.api.origin import rows_of_origin, rows_of_surface, shown_part
from sparsurf.api.page_metadata import About, heard, refuse_missing_matplotlib
from sparsurf.api.shown_surface import ShownSurface, shown_surface
from sparsurf.api.surroundings import (
    MAX_NAMED,
    contacts_on_page,
    drawn_without_surface,
    ligands_first,
    relative_areas,
    with_surroundings,
)
from sparsurf.arguments import ColourLimits
from sparsurf.dot_fields.named_fields import compute_fields, label_and_unit
from sparsurf.errors import InputError
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.residues import residue_table
from sparsurf.files import pluralise
from sparsurf.messages import no_warnings
from sparsurf.molecules.formats import title
from sparsurf.molecules.selection import POLYMERS
from sparsurf.molecules.source import open_source
from sparsurf.progress import Progress
from sparsurf.sampling.samplers import farthest
from sparsurf.settings import PatchesSettings, Settings
from sparsurf.surfaces.components import (
    COMPONENT_FIELD,
    fields_without_component,
)
from sparsurf.surfaces.grid import nearest_of
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd

    from sparsurf.molecules.molecule import Molecule
    from sparsurf.streams import Streams
    from sparsurf.surfaces.mesh import Mesh
    from sparsurf.surfaces.surface import Surface
    from sparsurf.views.viewer.dots import ShownDots
    from sparsurf.views.viewer.scene import DotValues


log = logging.getLogger("sparsurf")

# Of the grid of triangles between them: 4.3 corners for each dot. The triangles of a wider grid look angular
STEP_PER_DISTANCE = 1.25
MIN_DOTS_OF_MESH = 100
MAX_SPACING_OF_DENSE = 0.7  # Å, of dots between which a mesh needs no reconstruction
LINKS_OF_VIEW = ("surface.html", "Roughness and residues"), ("../../index.html", "All of this run")
STEPS_OF_PAGE = 4  # of a page: the roughness, the triangles, the fields, and the page itself


def page_of_surface(
    surface: Surface,
    about: About,
    colour: str = "roughness",
    values: np.ndarray | None = None,
    limits: ColourLimits = None,
    regions: Sequence[list[Any]] = (),
) -> str:
    """Return the page of a surface: its picture, its residues if the dots know their molecule, and what was left out.

    It opens in the colours of `values` (N,) of the dots, or of `colour`: 'roughness', 'kind' or a field. `limits` are theirs.
    `regions` are the area, Å^2, the mean and the residues of each region of the field. `shown_surface` says what is drawn.
    A surface of several chains opens coloured by chain, unless a field, limits, `about` or a study ask for others.
    """
    if len(surface) < 2:
        raise InputError("a page needs a surface, and there is a single dot; give all dots of a surface.")
    from sparsurf.views.page.page import Facts, Notes, in_list, numbers_of_residues, render_page
    from sparsurf.views.viewer.scene import (
        MAX_BYTES,
        MAX_BYTES_IN_REPORT,
        MAX_LARGE_BYTES,
        DotValues,
        PageScene,
        ResidueValues,
        roughness_values,
    )
    from sparsurf.views.viewer.shapes import DrawnAtoms, Shape

    steps = Progress("steps of the page", STEPS_OF_PAGE)
    patches = about.patches or PatchesSettings()
    shown = shown_surface(surface, about, patches, values)
    surface, molecule, values = shown.surface, shown.surface.molecule, shown.values
    prepared = PreparedSurface(surface, Settings(patches=patches), shown.roughness, threads=available_cores())
    steps.advance()
    mesh = drawn_mesh(surface, shown.distance)
    steps.advance()
    with heard("fields") as of_fields:
        with_fields, missing = with_default_fields(surface, molecule)
    steps.advance()
    table = None
    if molecule is not None:
        table = residue_table(with_fields, prepared.roughness, molecule, cavity=shown.cavity)
        table = shown.with_roughness(table)
    named = [] if values is None else [DotValues("values", "value", "", values)]
    named += values_of_fields(with_fields, shown.components)
    if np.isfinite(prepared.roughness).any():
        named.insert(0, roughness_values(prepared.roughness))
    has_kinds = values is None and colour == "kind" and (surface.kind >= 0).any()
    colour = "value" if values is not None else colour
    first = next((k for k, of_dots in enumerate(named) if of_dots.symbol == colour), 0)
    if named and limits:
        named[first] = replace(named[first], limits=limits)
    left_out, read = (about.heard.left_out, about.heard.sentences) if about.heard else (None, [])
    sentences = [*about.notes, *read, *of_fields.sentences]
    numbers = [] if table is None else [*numbers_of_residues(table)]
    atoms, buried, xyz, answer = None, None, np.empty((0, 3)), about.answer
    opens = "kind" if has_kinds or not named else f"value {first}"
    if molecule is not None and surface.origin is not None:
        drawn, frame, rules = with_surroundings(molecule), surface.origin.frame, surface.origin.rules
        atoms = DrawnAtoms(drawn, molecule.n_residues)
        xyz = atoms.placed(drawn.xyz[frame])
        with heard("contacts") as of_contacts:
            buried = contacts_on_page(drawn, [drawn.xyz[frame]], rules)
        buried, touched = ligands_first(buried, molecule)
        answer = " ".join(filter(None, (answer, touched)))
        chains = {*molecule.chain[np.isin(molecule.kind, POLYMERS)].tolist()}
        is_asked = colour != "roughness" or about.roughness is not None or limits or about.links
        if not is_asked and len(chains) > 1:
            opens = "chain"
        relative = relative_areas(molecule, frame, rules)
        numbers.append(ResidueValues("relative accessible area", "", relative[None], 2, "buried", "exposed"))
        sentences += [*of_contacts.sentences, *drawn_without_surface(drawn, molecule.n_atoms)]
        if atoms.is_trace:
            sentences.append("The picture holds one atom of each residue, since the molecule is large.")
    listed, n_ranked = ([], 0) if table is None else in_list(table)
    scene = PageScene(
        [Shape(mesh, xyz)],
        atoms,
        surface,
        named,
        numbers=numbers,
        dots=_drawn_dots(shown, prepared, has_mesh=mesh is not None),
        contacts=buried,
        colour=opens,
        order=listed,
        n_ranked=n_ranked,
        regions=regions,
        is_prediction=molecule is not None and molecule.is_prediction,
    )
    is_large, n_given = shown.distance > 0, len(shown.given)
    of_whole = shown.roughness_of_whole if shown.stands_for_whole else None
    facts = Facts(
        subset=len(shown.kept),
        dots=len(surface),
        extent=shown.extent,
        mean=float((prepared.roughness if of_whole is None else of_whole).mean()),
        reconstructed_from=n_given if shown.is_reconstructed else 0,
        chosen_from=n_given if is_large else 0,
        why=shown.why,
        r_patch=prepared.patches.r_patch,
        d_link=prepared.patches.d_link,
        probe=surface.origin.rules.probe_radius if surface.origin else None,
    )
    page = render_page(
        title_of(about, shown.given),
        scene,
        facts,
        table,
        max_bytes=MAX_BYTES_IN_REPORT if about.links else MAX_LARGE_BYTES if is_large else MAX_BYTES,
        notes=Notes(left_out, sentences),
        missing=[label_and_unit(name)[0] for name in missing],
        counts=_counts(molecule) if molecule else "",
        links=about.links,
        origin=rows_of_surface(about, surface),
        answer=answer,
    )
    steps.close()
    return page


def _drawn_dots(shown: ShownSurface, prepared: PreparedSurface, has_mesh: bool) -> ShownDots | None:
    """Return the dots that are drawn on the mesh: the kept ones, or those of a selection or without a molecule; else None."""
    from sparsurf.views.viewer.dots import ShownDots

    if len(shown.kept):
        are_given = shown.is_reconstructed and len(shown.kept) == len(shown.given)
        name = "the given dots" if are_given else "the kept dots"
        return ShownDots(prepared, shown.kept, shown.kept, name)
    if not shown.is_selection and shown.surface.molecule is not None:
        return None
    order = prepared.stream("view").permutation(len(shown.surface))
    return ShownDots(prepared, order, opens="all" if shown.is_selection or not has_mesh else "none")


def drawn_mesh(surface: Surface, distance: float = 0.0) -> Mesh | None:
    """Return the mesh that a picture shows of dots: that of their atoms, or one between the dots; None where there is none.

    Where the dots are some of a large surface, at a `distance`, Å, the triangles lie between them, since those of its atoms take
    minutes.
    """
    from sparsurf.recovery.interpolated_surface import recovered_mesh
    from sparsurf.surfaces.decimation import WIDEST_STEP
    from sparsurf.surfaces.grid_mesh import mesh_of_dense
    from sparsurf.surfaces.spacing import spacing
    from sparsurf.surfaces.thinning import DENSITY_OF_PICTURES, coarsened, mesh_of_picture

    try:
        if surface.origin is not None and not distance:
            return mesh_of_picture(surface.origin)
        apart = distance or spacing(surface.points)
        if len(surface) < MIN_DOTS_OF_MESH:
            return None
        step = max(WIDEST_STEP, STEP_PER_DISTANCE * distance)
        with no_warnings():
            if distance or apart < MAX_SPACING_OF_DENSE:
                mesh = mesh_of_dense(surface.points, surface.normals, step, available_cores())
            else:
                mesh = recovered_mesh(
                    surface.points, surface.normals, step, 2 / step**2, threads=available_cores()
                )
            mesh = coarsened(mesh, DENSITY_OF_PICTURES)
    except InputError:  # a grid around it does not fit into the memory, or the dots enclose nothing
        return None
    nearest = nearest_of(surface.points, mesh.vertices.points)[0]
    return replace(mesh, vertices=replace(mesh.vertices, atom=surface.atom[nearest]))


def title_of(about: About, surface: Surface) -> str:
    """Return the heading of a page."""
    molecule = surface.molecule
    if not about.name and molecule is not None and molecule.files:
        about = replace(about, name=title(molecule.files[0]))
    return f"{heading_of(about, molecule)}{shown_part(about, surface)}" if about.name else repr(surface)


def heading_of(about: About, molecule: Molecule | None) -> str:
    """Return the title that the file of a molecule states, or its name with its chains."""
    if stated := stated_in(molecule):
        return stated
    chains = [] if molecule is None else [name for name in dict.fromkeys(molecule.chain.tolist()) if name]
    few = 0 < len(chains) <= MAX_NAMED
    return (
        f"{about.name}, {'chain' if len(chains) == 1 else 'chains'} {', '.join(chains)}"
        if few
        else about.name
    )


def stated_in(molecule: Molecule | None) -> str:
    """Return the title that the file of a molecule states, or an empty one."""
    from gemmi import cif

    try:
        source = open_source(molecule.files[0]) if molecule is not None and molecule.files else None
        if source is not None and source.format.name == "pdb":
            with source.lines() as lines:
                before = [
                    *itertools.takewhile(lambda line: not line.startswith(("ATOM", "HETATM", "MODEL")), lines)
                ]
            titles = [line[10:80].strip() for line in before if line.startswith("TITLE")]
            return " ".join(" ".join(titles).split())
        if source is not None and source.format.name == "mmcif":
            block = cif.read_string(source.text()).sole_block()
            stated = cif.as_string(block.find_value("_struct.title") or "")
            return " ".join(stated.split())
    except (InputError, OSError, RuntimeError, ValueError):  # the file was read before, and may be gone
        pass
    return ""


def with_default_fields(surface: Surface, molecule: Molecule | None) -> tuple[Surface, list[str]]:
    """Return a surface with the fields of its molecule, and the names of those without a value there."""
    missing: list[str] = []
    if molecule is None or surface.origin is None:
        return surface, missing
    fields = dict(surface.fields)
    for name in DEFAULT_FIELDS:
        try:
            table = compute_fields(
                (name,), molecule.frame(surface.origin.frame), surface.points, dots=surface
            )
        except InputError:
            missing.append(name)
        else:
            fields.setdefault(name, table[name])
    return replace(surface, fields=fields), missing


def values_of_fields(surface: Surface, components: np.ndarray | None) -> list[DotValues]:
    """Return the fields of a surface, and the components of its dots, (N,), where there are several, as their values."""
    from sparsurf.views.viewer.scene import DotValues

    shown = []
    for name, numbers in fields_without_component(surface).items():
        label, unit = label_and_unit(name)
        shown.append(DotValues(label, name, f" {unit}".rstrip().replace("^2", "²"), numbers))
    if components is not None and components.max() > 0:
        parts = components.astype(float)
        shown.append(DotValues("component of the surface", COMPONENT_FIELD, "", parts, "largest", "smallest"))
    return shown


def page_of_dots(
    title: str,
    dots: ShownDots,
    values: Sequence[DotValues],
    labels: Sequence[str] = (),
    *,
    colour: int = 0,
    turn: np.ndarray | None = None,
    links: Sequence[tuple[str, str]] = (),
    origin: Sequence[tuple[str, str]] = (),
) -> str:
    """Return the page on which dots are sampled and picked, of a study.

    Parameters
    ----------
    title : heading
    dots : the dots, with their roughness
    values : further values of all dots of the surface
    labels : name of the residue of each atom, where the dots do not know their molecule
    colour : the values that are shown first, 0 for the roughness
    turn : (3, 3), whose rows point right, up and to the viewer
    links : addresses and words of other pages
    origin : rows that say where the page is from
    """
    from sparsurf.views.page.page import render_page_of_dots
    from sparsurf.views.viewer.scene import PageScene, roughness_values
    from sparsurf.views.viewer.shapes import DrawnAtoms, Shape

    surface, rough = dots.prepared.surface, dots.prepared.roughness
    atoms, xyz, molecule = None, np.empty((0, 3)), surface.molecule
    if molecule is not None and surface.origin is not None:
        drawn = with_surroundings(molecule)
        atoms = DrawnAtoms(drawn, molecule.n_residues)
        xyz = atoms.placed(drawn.xyz[surface.origin.frame])
    scene = PageScene(
        [Shape(drawn_mesh(surface), xyz)], atoms, surface, [roughness_values(rough, "roughness R_i"), *values],
        labels, dots=dots, colour=f"value {colour}", turn=turn,
    )  # fmt: skip
    answer = f"{len(surface):,} dots, mean roughness {rough.mean():.2f}."
    return render_page_of_dots(title, scene, answer, links, origin)


def page_of_values(
    title: str,
    surface: Surface,
    settings: Settings,
    streams: Streams,
    values: Sequence[DotValues],
    labels: Sequence[str] = (),
    origin: Sequence[tuple[str, str]] = (),
    turn: np.ndarray | None = None,
) -> str:
    """Return the page of the dots of a surface, which opens with all of them in the colours of the first values."""
    from sparsurf.views.viewer.dots import MAX_DOTS, ShownDots

    prepared = PreparedSurface(surface, settings, None, streams)
    order = farthest(prepared, min(len(surface), MAX_DOTS), prepared.stream("view"))
    dots = ShownDots(prepared, order, opens="all", samples=True)
    return page_of_dots(
        title, dots, values, labels, colour=1, turn=turn, links=LINKS_OF_VIEW[1:], origin=origin
    )


def _counts(molecule: Molecule) -> str:
    """Return how large a molecule is, in words."""
    chains = len(set(molecule.chain.tolist()))
    return f"{molecule.counted_residues} in {pluralise(chains, 'chain')}, of {molecule.n_atoms:,} atoms"


def page_of_residues(table: pd.DataFrame, about: About, surface: Surface | None) -> str:
    """Return the page of a table of residues: their profile, the roughest, and the surface that they are measured on."""
    from sparsurf.views.page.page import render_residues

    origin = rows_of_origin(about) if surface is None else rows_of_surface(about, surface)
    part = "" if surface is None else shown_part(about, surface)
    return render_residues(f"The residues of {about.name}{part}", table, origin)


def refuse_other_table(table: pd.DataFrame, name: str) -> None:
    """Raise InputError unless a table is one of residues with a roughness."""
    needed = ("chain", "residue", "residue_name", "mean_roughness", "area", "dots")
    absent = [column for column in needed if column not in table]
    if absent:
        raise InputError(
            f"{name}: a page or picture of a table shows residues, and this one has no column {absent[0]!r}; "
            "name a file that ends in .csv or .npz."
        )
    if not table["mean_roughness"].notna().any():
        raise InputError(
            f"{name}: no residue has a roughness, since all are buried; name a file that ends in .csv or .npz."
        )


def save_picture(path: Path, name: str, figure: str, *values: Any) -> None:
    """Draw a picture of `views.pictures`, by the name of its function, and save it as a PNG; `name` is the output's."""
    refuse_missing_matplotlib(name)
    from sparsurf.views import layout, pictures

    layout.save(getattr(pictures, figure)(*values), path)
