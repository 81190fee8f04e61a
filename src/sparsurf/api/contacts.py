"""What touches what: the area that each chain and each ligand buries of the residues of others, and the ligands of a file."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.errors import InputError
from sparsurf.messages import no_warnings
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.molecules.selection import POLYMERS
from sparsurf.surfaces.areas import areas_of_spheres
from sparsurf.surfaces.radii import RADII, radii

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd

    from sparsurf.molecules.molecule import Molecule
    from sparsurf.surfaces.surface import Rules

LEAST_BURIED = 0.5  # Å^2, of a row
BURIED_IN_FRAME = 1.0  # Å^2, from which a residue touches its partner in a frame
NEAR_MOLECULE = 6.0  # Å, from a ligand that is drawn to the molecule
SAME_POSITION = 0.01  # Å
MAX_ATOMS = 30_000  # of a molecule whose contacts a page lists


def surroundings(molecule: Molecule) -> Molecule | None:
    """Return the ligands, ions and nucleic acids of a molecule's file that lie close to it and are no part of it, or None.

    There are none where the molecule was moved since it was read, or has other frames than its file.
    """
    from scipy.spatial import cKDTree

    if not molecule.files or molecule.masked_residues:
        return None
    try:
        with no_warnings():
            whole = read_molecule(*molecule.files[:2], selection="all")
    except (InputError, OSError, TypeError):
        return None
    if whole.n_frames != molecule.n_frames:
        return None
    atoms, of_file = _keys(molecule), _keys(whole)
    place = {key: k for k, key in enumerate(of_file)}
    placed = np.array([place.get(key, -1) for key in atoms])
    if (placed < 0).any() or np.abs(whole.xyz[:, placed] - molecule.xyz).max() > SAME_POSITION:
        return None
    near = cKDTree(molecule.xyz[0]).query(whole.xyz[0], distance_upper_bound=NEAR_MOLECULE)[0] < NEAR_MOLECULE
    near &= ~np.isin(np.arange(len(near)), placed) & ~np.isin(whole.kind, ("protein", "water"))
    residues = whole.residue_index[near]
    chains = np.unique(whole.chain[near & (whole.kind == "nucleic")])
    strands = (whole.kind == "nucleic") & np.isin(whole.chain, chains)  # nucleic acids are drawn whole
    chosen = strands | np.isin(whole.residue_index, residues)
    chosen[placed] = False
    return whole.take(chosen) if chosen.any() else None


def _keys(molecule: Molecule) -> list[tuple[str, ...]]:
    """Return what identifies each atom."""
    columns = (molecule.chain, molecule.residue, molecule.residue_name, molecule.name)
    return [*zip(*(column.tolist() for column in columns), strict=True)]


def units_of(parts: Sequence[Molecule]) -> tuple[list[str], np.ndarray]:
    """Return the partners, which are the chains of polymers and each ligand by itself, and that of each atom, (A,)."""
    names = [
        (f"chain {chain}" if chain else "the chain") if kind in POLYMERS else part.residue_label(atom)
        for part in parts
        for atom, (chain, kind) in enumerate(zip(part.chain.tolist(), part.kind.tolist(), strict=True))
    ]
    order = list(dict.fromkeys(names))
    number = {name: k for k, name in enumerate(order)}
    return order, np.array([number[name] for name in names])


def touching(
    molecule: Molecule, around: Molecule | None, frame: int, rules: Rules, xyz: np.ndarray | None = None
) -> pd.DataFrame:
    """Return the accessible area of each residue, alone with a partner, that this partner buries, the largest first.

    Columns are the `number` of the residue, those of `around` after those of the molecule, the `partner` and `buried`, Å^2. `xyz`
    are positions in place of those of the frame.
    """
    import pandas as pd

    parts = [molecule] if around is None else [molecule, around]
    names, unit = units_of(parts)
    if xyz is None:
        xyz = np.concatenate([part.xyz[frame] for part in parts])
    xyz, table = xyz.round(3), rules.radii if rules.radii in RADII else "dms"
    sizes = np.concatenate([radii(part, table) for part in parts])
    first = np.cumsum([0, *(part.n_residues for part in parts)])
    number = np.concatenate([
        before + part.residue_index for before, part in zip(first, parts, strict=False)
    ])  # fmt: skip
    low, high = (
        np.array([end(xyz[unit == k], axis=0) for k in range(len(names))]) for end in (np.min, np.max)
    )
    reach, rows = 2 * (sizes.max() + rules.probe_radius), []
    for a, b in combinations(range(len(names)), 2):
        if (np.maximum(low[a], low[b]) - np.minimum(high[a], high[b]) > reach).any():
            continue
        two = (unit == a) | (unit == b)
        buried = areas_of_spheres(
            xyz[two], sizes[two], rules.probe_radius, unit[two], with_excluded=False
        ).buried
        for side, other in ((a, b), (b, a)):
            areas = np.bincount(number[two][unit[two] == side], buried[unit[two] == side])
            rows += [(int(k), names[other], float(areas[k])) for k in np.flatnonzero(areas > LEAST_BURIED)]
    found = pd.DataFrame(rows, columns=["number", "partner", "buried"])
    return found.sort_values("buried", ascending=False, kind="stable", ignore_index=True)


def occupancy(tables: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Return the contacts over frames: the `share` of the frames in which at least 1 Å^2 is buried, mean and largest area."""
    import pandas as pd

    rows = pd.concat(tables, ignore_index=True)
    rows = rows[rows["buried"] >= BURIED_IN_FRAME]
    groups = rows.groupby(["number", "partner"], sort=False)["buried"]
    found = groups.agg(share="size", buried="sum", largest="max").reset_index()
    found["share"], found["buried"] = found["share"] / len(tables), found["buried"] / len(tables)
    return found.sort_values("buried", ascending=False, kind="stable", ignore_index=True)
