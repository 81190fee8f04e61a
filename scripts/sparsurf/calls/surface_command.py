"""`sparsurf surface`: the dots of a molecule."""

from sparsurf import InputError
from sparsurf.calls import options, outputs
from sparsurf.calls.inputs import STRUCTURES, is_structure
from sparsurf.surfaces.mesh import molecular_mesh, step_of
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.threads import available_cores

EXAMPLES = """\
The columns of a CSV are x,y,z,nx,ny,nz, area (Å^2), kind (0 contact, 1 saddle, 2 concave) and atom (its index among the
atoms taken, from 0). With --mesh, triangles of the surface come instead: the corners lie on it, every edge belongs to two of
them, and they are as fine as --density says, with steps of half the probe's radius at most.

examples:
  sparsurf surface protein.pdb -o dots.ply
  sparsurf surface protein.pdb --mesh -o mesh.ply
  sparsurf surface protein.pdb --residues 209-214 --density 10 -o dense.csv
  sparsurf surface protein.pdb --trajectory run.xtc --frame 20 -o dots.dms
  sparsurf surface protein.pdb -o - --format npz > dots.npz
"""


def arguments(parser):
    """Options of the command."""
    parser.add_argument("file", metavar="FILE", help="structure")
    options.add_output(parser, outputs.DOTS, "triangles of the surface, watertight, instead of dots (PLY)")
    options.add_molecule(parser)


def run(wish):
    """Write the dots."""
    if not is_structure(wish.file):
        raise InputError(f"{wish.file} is no structure by its suffix: give one of {', '.join(STRUCTURES)}.")
    outputs.check(wish, outputs.DOTS)
    if wish.mesh:
        molecule = options.read_atoms(wish)
        xyz, step = molecule.xyz[wish.frame].round(3), step_of(wish.density or DENSITY)
        mesh = molecular_mesh(xyz, radii(molecule, wish.radii), wish.probe, step, available_cores())
        options.say(f"{len(mesh.triangles)} triangles, {mesh.volume:.0f} Å^3")
        outputs.write_mesh(wish, mesh)
        return
    surface, molecule = options.read_dots(wish)
    columns = {"area": surface.area, "kind": surface.kind, "atom": surface.atom}
    outputs.write_dots(wish, surface, columns, molecule=molecule)
