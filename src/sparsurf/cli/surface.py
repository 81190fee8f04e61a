"""`sparsurf surface`: the dots of a molecule."""

import pandas as pd

from sparsurf import InputError
from sparsurf.cli import options, outputs
from sparsurf.cli.inputs import STRUCTURES, is_structure
from sparsurf.cli.making import components, mesh
from sparsurf.files import pluralise
from sparsurf.patches.index import D_LINK
from sparsurf.surfaces.components import COMPONENT_FIELD, summarize_components
from sparsurf.surfaces.spacing import DENSITY as PUBLISHED

OF_DOTS = {
    "fields": None,
    "table": None,
    "charges": "table",
    "d_link": D_LINK,
    "plain": False,
}  # options without a meaning for a mesh
EXAMPLES = """\
The columns of a CSV are x,y,z,nx,ny,nz, area (Å^2), kind (0 contact, 1 saddle, 2 concave), component (0 is the largest), chain,
residue, residue_name, atom_name and atom (its index among the atoms taken, from 0). A PLY has triangles between the dots.
--mesh writes a finer closed surface instead of dots. Its corners lie on the surface, and every edge belongs to two triangles.
A cavity is a component inside the molecule, which no probe leaves.

examples:
  sparsurf surface protein.pdb -o dots.ply
  sparsurf surface protein.pdb --mesh -o mesh.ply
  sparsurf surface protein.pdb --cavities remove -o outside.ply
  sparsurf surface protein.pdb --fields hydropathy,potential -o dots.csv
  sparsurf surface protein.pdb --residues 209-214 --density 10 -o dense.csv
  sparsurf surface protein.pdb --trajectory run.xtc --frame 20 -o dots.dms
  sparsurf surface models.pdb --model all -o dots_{frame}.ply
  sparsurf surface protein.pdb -o - --format npz > dots.npz
"""


def arguments(parser):
    """Options of the command."""
    parser.add_argument("file", metavar="FILE", help="structure")
    options.add_output(parser, outputs.DOTS)
    options.add_mesh(parser, mesh=True)
    options.add_fields(parser)
    options.add_molecule(parser)


def run(asked):
    """Write the dots or triangles."""
    if not is_structure(asked.file):
        raise InputError(
            f"{asked.file} is no structure by its suffix: give one of {', '.join(STRUCTURES)}; frames come by --trajectory."
        )
    for name, default in OF_DOTS.items() if asked.mesh else ():
        if getattr(asked, name) != default:
            option = name.replace("_", "-")
            raise InputError(
                f"--{option}: it is of dots, and --mesh writes triangles; leave out one of the two."
            )
    outputs.check(asked, outputs.MESHES if asked.mesh else outputs.DOTS)
    outputs.write_each(asked, _meshes(asked) if asked.mesh else _dots(asked))


def _dots(asked):
    for frame, dots, molecule in options.surfaces(asked):
        dots = options.with_fields(asked, dots, molecule, frame)
        component, parts = components(molecule, dots, frame=frame, probe=asked.probe, radii=asked.radii)
        table = pd.DataFrame({"area": dots.area, "kind": dots.kind, COMPONENT_FIELD: component})
        table = table.join(molecule.labels(dots.atom))
        words = f"{len(dots):,} dots, {dots.area.sum():,.0f} Å^2, {_words(parts)}"
        yield frame, outputs.Dots(dots, table, None, molecule, frame, words=words)


def _words(parts):
    """What the command tells of the components of a surface."""
    found = summarize_components(parts)
    words = f"{found['volume']:,.0f} Å^3, {pluralise(found['components'], 'component')}"
    if not found["cavities"]:
        return words
    noun = "cavity" if found["cavities"] == 1 else "cavities"
    return f"{words}, of which {found['cavities']} {noun} with {found['cavity_dots']:,} dots"


def _meshes(asked):
    molecule = options.read_atoms(asked)
    how = {key: getattr(asked, key) for key in ("probe", "radii", "cavities")}
    how["density"] = asked.density or PUBLISHED
    for frame in options.frames_of(asked, molecule):
        yield frame, outputs.mesh_dots(mesh(molecule, frame=frame, **how))
