"""`sparsurf surface`: the dots of a molecule."""

from sparsurf import InputError
from sparsurf.calls import options, outputs
from sparsurf.calls.inputs import STRUCTURES, is_structure

EXAMPLES = """\
The columns of a CSV are x,y,z,nx,ny,nz, area (Å^2), kind (0 contact, 1 saddle, 2 concave) and atom (its index among the
atoms taken, from 0).

examples:
  sparsurf surface protein.pdb -o dots.ply
  sparsurf surface protein.pdb --residues 209-214 --density 10 -o dense.csv
  sparsurf surface protein.pdb --trajectory run.xtc --frame 20 -o dots.dms
  sparsurf surface protein.pdb -o - --format npz > dots.npz
"""


def arguments(parser):
    """Options of the command."""
    parser.add_argument("file", metavar="FILE", help="structure")
    outputs_of = outputs.DOTS
    options.add_output(parser, outputs_of)
    options.add_molecule(parser)


def run(wish):
    """Write the dots."""
    if not is_structure(wish.file):
        raise InputError(f"{wish.file} is no structure by its suffix: give one of {', '.join(STRUCTURES)}.")
    surface, molecule = options.read_dots(wish)
    columns = {"area": surface.area, "kind": surface.kind, "atom": surface.atom}
    outputs.write_dots(wish, surface, columns, molecule=molecule)
