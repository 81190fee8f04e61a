"""The atoms that determine a molecular surface: those that the probe touches, and inner ones (plugs) that keep it out of voids.

The ball of atom k, of radius r_k + r_p around its centre, holds the positions that the probe's centre cannot take; let U be the
union of these balls. Near a point of the border of U only the balls of atoms reach that the probe touches there. So a set of
atoms that holds all touched ones has the border of U, and beyond it only the borders of voids: positions that are free in the
set, lie inside a ball of the molecule, and are closed off from its surface. An atom of the molecule whose ball holds a place of
such a void is a *plug*. The set determines the surface exactly if and only if the probe that rolls over it takes the same
positions as over the molecule, which is a finite comparison: of arcs, fixed probes and spheres that touch no other.

This needs general position (no probe touches four atoms), which the random shift of `relative_positions` provides. The set is the
outer part of the dual shape of the balls (Edelsbrunner, Discrete Comput. Geom. 13:415, 1995).
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sparsurf.arguments import Cavities, RadiiTable, index_array
from sparsurf.display import Shown
from sparsurf.errors import InputError
from sparsurf.kernels import njit
from sparsurf.surfaces.components import joined_arcs, label_centres
from sparsurf.surfaces.dot_placement import Rolled, roll_checked
from sparsurf.surfaces.grid import PointGrid, columns_around, in_column, sort_into_grid
from sparsurf.surfaces.rolling_probe import (
    ARC_RADIUS,
    E1,
    E2,
    PHI_0,
    PHI_1,
    RolledAtoms,
    Rolling,
    T,
    blocker,
    roll,
    squared_distance_to_arc,
)
from sparsurf.surfaces.spheres import Spheres
from sparsurf.surfaces.surface import Placement, Rules, Surface
from sparsurf.surfaces.vectors import point, set_of_arcs, slots, squared_distance, vector_at

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import ArrayLike

    from sparsurf.molecules.molecule import Molecule

log = logging.getLogger("sparsurf")

# Å, by which a position is inside a ball; the second is tried where the first leaves a void
DEPTHS = (1e-6, 1e-9)
MAX_ROUNDS = 30  # of plugs; proteins need at most five
N_BALLS = 1_500_000  # above any number of atoms; the numbers of three atoms and a bit fit into 63 bits


@dataclass(frozen=True, eq=False)
class SurfaceAtoms(Shown):
    """Atoms that determine a molecular surface; its length is their number.

    The arrays cannot be written to, since `is_exact` is computed from them once.

    Attributes
    ----------
    centres : (n, 3) float64, Å
    radii : (n,) float64, Å
    atom : (n,) int64, their indices among the atoms of the molecule, ascending
    touched : (n,) bool, whether the probe touches the atom; the others are plugs, which keep the probe out of the inside
    probe_radius : float, Å, of the probe
    cavities : 'keep' or 'remove', whether the walls of closed cavities are part of the surface
    table : name of the table of radii, None for spheres
    spheres : Spheres, all atoms of the molecule
    molecule : Molecule, or None for spheres
    frame : int, position of its frame
    """

    centres: NDArray[np.float64]
    radii: NDArray[np.float64]
    atom: NDArray[np.int64]
    touched: NDArray[np.bool_]
    probe_radius: float
    cavities: Cavities
    table: RadiiTable | None
    spheres: Spheres
    molecule: Molecule | None = None
    frame: int = 0

    @property
    def rules(self) -> Placement:
        """How dots are placed on them."""
        return Placement(self.probe_radius, radii=self.table or "dms", cavities=self.cavities)

    def __post_init__(self) -> None:
        for name in ("centres", "radii", "atom", "touched"):
            array = np.array(getattr(self, name))
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    def __repr__(self) -> str:
        return (
            f"SurfaceAtoms: {len(self):,} of {len(self.spheres.radii):,} atoms, of which the probe touches "
            f"{self.touched.sum():,}"
        )

    def __len__(self) -> int:
        return len(self.atom)

    def __getitem__(self, atoms: ArrayLike | slice) -> SurfaceAtoms:
        """Return some of the atoms: a mask, indices or a slice; whether they are exact is computed anew."""
        chosen = atoms if isinstance(atoms, slice) else np.atleast_1d(index_array(atoms, len(self), "atoms"))
        if not len(self.atom[chosen]):
            raise InputError("atoms: none is left; choose at least one.")
        return SurfaceAtoms(
            self.centres[chosen], self.radii[chosen], self.atom[chosen], self.touched[chosen], self.probe_radius,
            self.cavities, self.table, self.spheres, self.molecule, self.frame,
        )  # fmt: skip

    @cached_property
    def is_exact(self) -> bool:
        """Whether the probe takes the same positions as on the molecule, which is computed and never assumed."""
        xyz, radii = self.spheres.xyz, self.spheres.radii
        if not (
            np.array_equal(self.centres, xyz[self.atom]) and np.array_equal(self.radii, radii[self.atom])
        ):
            return False
        rolled = roll_checked(xyz, radii, self.probe_radius, cavities=self.cavities)
        whole = _free_positions(rolled)
        return _are_equal(
            whole, _free_positions(rolled, np.flatnonzero(np.isin(rolled.atom, self.atom)), whole)
        )

    def to_frame(self) -> pd.DataFrame:
        """Tabulate x, y, z and radius (Å), touched, and the labels of the atoms where these are known, else their index."""
        import pandas as pd  # here: it takes long to load

        columns = dict(zip("xyz", self.centres.T, strict=True)) | {
            "radius": self.radii,
            "touched": self.touched,
        }
        labels = {"atom": self.atom} if self.molecule is None else self.molecule.label_columns(self.atom)
        return pd.DataFrame(columns | labels)


class _Positions(NamedTuple):
    """Positions of the probe that touch atoms, as far as they shape the surface."""

    rolling: Rolling
    ids: np.ndarray  # (A,) int64, number of each atom of the roll among all balls
    arcs: np.ndarray  # (B,) bool, whether an arc shapes the surface
    probes: np.ndarray  # (P,) bool, fixed ones
    spheres: np.ndarray  # int64, the atoms that the probe touches without touching another one
    outside: (
        np.ndarray
    )  # (n, 3) float64, Å, the fixed probes that are in no cavity; none where cavities are kept

    def pairs(self, arcs: np.ndarray) -> np.ndarray:
        """Return a number for the two atoms of each of the arcs, a mask or indices."""
        return self.ids[self.rolling.pair[arcs]] @ [N_BALLS, 1]

    def names(self, probes: np.ndarray) -> np.ndarray:
        """Return a number for each of the fixed probes, a mask or indices: of its three atoms and the side of their plane."""
        triple = self.rolling.triple[probes]
        corner, second, third = (self.rolling.atoms.centre[atom] for atom in triple.T)
        above = np.cross(second - corner, third - corner) * (self.rolling.probes[probes] - corner)
        return self.ids[triple] @ [2 * N_BALLS**2, 2 * N_BALLS, 2] + (above.sum(axis=1) > 0)


def atoms_of_surface(
    spheres: Spheres, rules: Rules, plugs: bool, molecule: Molecule | None = None, frame: int = 0
) -> SurfaceAtoms:
    """Find the atoms that determine the surface of spheres, which may be those of a frame of a molecule."""
    rolled = roll_checked(spheres.xyz, spheres.radii, rules.probe_radius, cavities=rules.cavities)
    whole = _free_positions(rolled)
    touched = _touched_atoms(whole, len(rolled.atom))
    chosen = touched.copy()
    is_exact = _plug(rolled, whole, chosen) if plugs else None
    by_atom = np.argsort(rolled.atom[chosen])
    atom = rolled.atom[chosen][by_atom]
    table: Any = None if molecule is None else rules.radii
    made = SurfaceAtoms(
        spheres.xyz[atom], spheres.radii[atom], atom, touched[chosen][by_atom], rolled.probe, rolled.cavities, table, spheres,
        molecule, frame,
    )  # fmt: skip
    if is_exact is not None:
        made.__dict__["is_exact"] = (
            is_exact  # else computed when it is first read, as for some of these atoms
        )
    if is_exact is False:
        log.warning(
            "surface_atoms: a probe touches four or more atoms at once, and these atoms may not determine the surface exactly."
        )
    return made


def atoms_of_dots(dots: Surface) -> SurfaceAtoms:
    """Find the atoms that determine the surface on which dots were placed, by the rules of their placement."""
    origin = dots.origin
    assert origin is not None
    spheres = Spheres(origin.xyz, origin.radii, [])
    return atoms_of_surface(spheres, origin.rules, True, origin.molecule, origin.frame)


def _free_positions(
    rolled: Rolled, ids: np.ndarray | None = None, whole: _Positions | None = None
) -> _Positions:
    """Find the positions of a probe on all balls, or rolled over those of `ids`, that shape the surface.

    `whole` are the positions on all balls, which tell the outside where cavities are removed.
    """
    rolling, probe = rolled.rolling, rolled.probe
    if ids is None:
        ids = np.arange(len(rolled.atom))
    else:
        rolling = roll(rolling.atoms.centre[ids], rolling.atoms.reach[ids])
    without_arcs = np.ones(len(ids), bool)
    without_arcs[rolling.pair] = False
    spheres = np.flatnonzero(without_arcs)
    spheres = spheres[_are_free(rolling.atoms, spheres)]
    arcs, probes = np.ones(len(rolling.arcs), bool), np.ones(len(rolling.probes), bool)
    positions = _Positions(rolling, ids, arcs, probes, spheres, np.empty((0, 3)))
    if rolled.cavities == "keep":
        return positions
    return _without_cavities(positions, probe) if whole is None else _without_voids(positions, probe, whole)


def _without_cavities(positions: _Positions, probe: float) -> _Positions:
    """Leave out the positions in cavities, but for those that shape the outside all the same.

    `surface` removes the part of a concave face that lies inside another probe, also of one in a cavity. No such probe is
    farther from a fixed probe of the outside than two radii. Of a cavity, the nearest position to one outside of it lies on an
    arc. What floats in a cavity stays.
    """
    rolling, labels = positions.rolling, label_centres(positions.rolling)
    at_probes = _sets_at_probes(labels.roots, labels.meeting, len(rolling.probes))
    outside = rolling.probes[~labels.closed[at_probes]]
    shapes = ~labels.closed | labels.faces_outwards
    hidden = np.flatnonzero(~shapes[labels.roots])
    shapes[labels.roots[hidden[_are_near(rolling.arcs, hidden, outside, 2 * probe)]]] = True
    spheres = positions.spheres[shapes[labels.label[positions.spheres]]]
    return positions._replace(
        arcs=shapes[labels.roots], probes=shapes[at_probes], spheres=spheres, outside=outside
    )


def _without_voids(positions: _Positions, probe: float, whole: _Positions) -> _Positions:
    """Leave out the positions on a part of the balls that are not those of `whole`, and too far from its outside to shape it."""
    rolling = positions.rolling
    joined, meeting = joined_arcs(rolling)
    roots = set_of_arcs(joined)
    shapes = np.zeros(len(roots), bool)
    at_probes = _sets_at_probes(roots, meeting, len(rolling.probes))
    probes = np.arange(len(rolling.probes))
    shapes[at_probes[np.isin(positions.names(probes), whole.names(whole.probes))]] = True
    circles = np.flatnonzero((meeting < 0).all(axis=1))
    shapes[circles] = np.isin(positions.pairs(circles), whole.pairs(whole.arcs))
    hidden = np.flatnonzero(~shapes[roots])
    shapes[roots[hidden[_are_near(rolling.arcs, hidden, whole.outside, 2 * probe)]]] = True
    return positions._replace(arcs=shapes[roots], probes=shapes[at_probes])


def _sets_at_probes(roots: np.ndarray, meeting: np.ndarray, n_probes: int) -> np.ndarray:
    """Return the set of the arcs that end at each fixed probe, (n_probes,) int."""
    sets, at_end = np.zeros(n_probes, np.int64), meeting >= 0
    sets[meeting[at_end]] = np.repeat(roots[:, None], 2, axis=1)[at_end]
    return sets


def _are_near(arcs: np.ndarray, chosen: np.ndarray, positions: np.ndarray, distance: float) -> np.ndarray:
    """Return whether each of the chosen arcs passes nearer than a distance to one of the positions, (n,) bool."""
    if not len(positions) or not len(chosen):
        return np.zeros(len(chosen), bool)
    grid = sort_into_grid(positions, distance + arcs[chosen, ARC_RADIUS].max())
    return _pass_near(arcs, chosen, grid, distance)


def _touched_atoms(positions: _Positions, n_atoms: int) -> np.ndarray:
    """Return the balls on which the probe takes a position that shapes the surface, (n_atoms,) bool."""
    touched = np.zeros(n_atoms, bool)
    touched[positions.ids[positions.rolling.pair[positions.arcs]]] = True
    touched[positions.ids[positions.spheres]] = True
    return touched


def _are_equal(whole: _Positions, part: _Positions) -> bool:
    """Return whether the probe takes the same positions on both: the same arcs, fixed probes and spheres of the same atoms."""
    numbers = [
        (positions.pairs(positions.arcs), positions.names(positions.probes), positions.ids[positions.spheres])
        for positions in (whole, part)
    ]
    return all(np.array_equal(np.sort(a), np.sort(b)) for a, b in zip(*numbers, strict=True))


def _plug(rolled: Rolled, whole: _Positions, chosen: np.ndarray) -> bool:
    """Add plugs to the chosen balls, in place, until the set determines the surface; return whether it does.

    After the first round only the neighbourhood of the voids is rolled over, unless labels of cavities need the whole.
    """
    atoms, is_local = whole.rolling.atoms, False
    ids = np.flatnonzero(chosen)
    for depth in DEPTHS:
        for _ in range(MAX_ROUNDS):
            part = _free_positions(rolled, ids, whole)
            positions, owner = _places(part)
            first, holder = _holders(positions, owner, atoms, chosen, depth, is_local)
            in_void = np.diff(first) > 0
            if not in_void.any():
                if not is_local:
                    break
                ids, is_local = np.flatnonzero(chosen), False
                continue
            new = _cover(first, holder, len(chosen))
            chosen |= new
            ids, is_local = np.flatnonzero(chosen), rolled.cavities == "keep"
            if is_local:
                around = _around(part, in_void, new, atoms)
                ids = np.flatnonzero(around & chosen)
        if _are_equal(whole, part):
            return True
        ids, is_local = np.flatnonzero(chosen), False
    return False


def _around(part: _Positions, in_void: np.ndarray, new: np.ndarray, atoms: RolledAtoms) -> np.ndarray:
    """Return the balls that bound voids or were added, and all that overlap one of them, (A,) bool."""
    core, n_probes = new.copy(), int(part.probes.sum())
    n_arcs = int(part.arcs.sum())
    rolling = part.rolling
    core[part.ids[rolling.triple[part.probes][in_void[:n_probes]]]] = True
    core[part.ids[rolling.pair[part.arcs][in_void[n_probes : n_probes + n_arcs]]]] = True
    core[part.ids[part.spheres[in_void[n_probes + n_arcs :]]]] = True
    around = core.copy()
    for atom in np.flatnonzero(core).tolist():
        around[atoms.near[atoms.start[atom] : atoms.start[atom + 1]]] = True
    return around


def _places(part: _Positions) -> tuple[np.ndarray, np.ndarray]:
    """Return a position on each piece, (n, 3): fixed probes, middles of arcs, tops of spheres; and a ball that each touches."""
    rolling, arcs = part.rolling, part.rolling.arcs[part.arcs]
    middle = (arcs[:, PHI_0] + arcs[:, PHI_1])[:, None] / 2
    outward = np.cos(middle) * arcs[:, E1 : E1 + 3] + np.sin(middle) * arcs[:, E2 : E2 + 3]
    on_arcs = arcs[:, T : T + 3] + arcs[:, [ARC_RADIUS]] * outward
    tops = rolling.atoms.centre[part.spheres] + rolling.atoms.reach[part.spheres][:, None] * [1.0, 0.0, 0.0]
    owner = [rolling.triple[part.probes, 0], rolling.pair[part.arcs, 0], part.spheres]
    return np.concatenate([rolling.probes[part.probes], on_arcs, tops]), part.ids[np.concatenate(owner)]


@njit()
def _are_free(atoms: RolledAtoms, spheres: np.ndarray) -> np.ndarray:
    """Return whether spheres without arcs are free, (n,) bool: all of one is, or nothing, so that one position decides."""
    free = np.empty(len(spheres), np.bool_)
    for k in range(len(spheres)):
        i = spheres[k]
        x, y, z = point(atoms.centre, i)
        free[k] = blocker((x + atoms.reach[i], y, z), i, atoms, -1) < 0
    return free


@njit()
def _pass_near(arcs: np.ndarray, chosen: np.ndarray, grid: PointGrid, distance: float) -> np.ndarray:
    """Return `_are_near`; the cells of the positions are as wide as the distance and an arc."""
    near = np.zeros(len(chosen), np.bool_)
    for a in range(len(chosen)):
        arc = arcs[chosen[a]]
        columns = columns_around(grid.lattice, vector_at(arc, T), grid.lattice.side)
        for c in range(columns.n):
            for q in in_column(grid.start, columns, c):
                near[a] |= squared_distance_to_arc(point(grid.xyz, q), arc) < distance * distance
    return near


@njit()
def _holders(
    positions: np.ndarray,
    owner: np.ndarray,
    atoms: RolledAtoms,
    chosen: np.ndarray,
    depth: float,
    is_local: bool,
) -> tuple[np.ndarray, np.ndarray]:
    """List the balls that hold each position by more than a depth: those of position q are holder[first[q]:first[q + 1]].

    They overlap the ball `owner` that the position touches. Chosen balls hold none, but for positions on a part of them
    (`is_local`), which are none of the whole.
    """
    first, holder, n = np.zeros(len(positions) + 1, np.int64), np.empty(16 * len(positions) + 64, np.int64), 0
    for q in range(len(positions)):
        position, begin = point(positions, q), n
        for slot in slots(atoms.start, owner[q]):
            k = atoms.near[slot]
            if chosen[k] and not is_local:
                continue
            inside = max(atoms.reach[k] - depth, 0.0)
            if squared_distance(point(atoms.centre, k), position) >= inside * inside:
                continue
            if chosen[k]:
                n = begin
                break
            if n == len(holder):
                longer = np.empty(2 * n, np.int64)
                longer[:n] = holder
                holder = longer
            holder[n] = k
            n += 1
        first[q + 1] = n
    return first, holder[:n]


@njit()
def _cover(first: np.ndarray, holder: np.ndarray, n_atoms: int) -> np.ndarray:
    """Choose balls so that each position with holders lies in one, always the ball with the most positions that are left."""
    count, chosen = np.zeros(n_atoms, np.int64), np.zeros(n_atoms, np.bool_)
    for k in holder:
        count[k] += 1
    # no cumsum, copy or flatnonzero: a stored kernel that calls them imports scipy.linalg when it is loaded
    begin, free = np.zeros(n_atoms + 1, np.int64), np.empty(n_atoms, np.int64)
    for k in range(n_atoms):
        free[k], begin[k + 1] = begin[k], begin[k] + count[k]
    held, is_left = np.empty(len(holder), np.int64), np.ones(len(first) - 1, np.bool_)
    for q in range(len(first) - 1):
        for slot in slots(first, q):
            held[free[holder[slot]]] = q
            free[holder[slot]] += 1
    candidates = [np.int64(k) for k in range(n_atoms) if count[k] > 0]
    while True:
        best = candidates[0] if candidates else np.int64(-1)
        for k in candidates:
            if count[k] > count[best]:
                best = k
        if best < 0 or count[best] == 0:
            return chosen
        chosen[best] = True
        for slot in slots(begin, best):
            q = held[slot]
            if is_left[q]:
                is_left[q] = False
                for other in slots(first, q):
                    count[holder[other]] -= 1
