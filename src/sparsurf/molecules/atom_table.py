"""The atoms of an input as one table, whatever it is: a file, a topology, or an object of another library.

The table has one row per atom in the order of the input, and the columns of `COLUMNS`.
"""

from __future__ import annotations

import logging
import math
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any, NamedTuple

import gemmi
import numpy as np

from sparsurf.errors import FILE, InputError, argument
from sparsurf.files import pluralise
from sparsurf.molecules.residues import HEAVY_ATOMS, MAX_RESIDUE_BOND, first_letters, standard_name

log = logging.getLogger("sparsurf")

# Columns, and their values where an input has none
ATOM_COLUMNS: dict[str, Any] = {
    "model": 1,  # number of the model
    "hetero": False,  # not part of a polymer, according to the input
    "name": "", "altloc": "", "residue_name": "", "chain": "", "segid": "",
    "residue": "",  # number with insertion code: '52A', '-5'
    "x": np.nan, "y": np.nan, "z": np.nan,  # Å
    "occupancy": 1.0,
    "b_factor": np.nan,  # Å^2
    "element": "",
    "molecule": 0,  # changes where a molecule ends (TER)
    "unit": 0,  # changes where a residue ends, if the input knows it
}  # fmt: skip
# columns that change where a residue ends
OF_RESIDUE = ("model", "chain", "segid", "residue", "molecule", "unit")
MIN_BOX_VOLUME = 1e-6  # share of the volume of the same box at right angles; a flat box is impossible
BARE_HYDROGENS = ("H", "D")  # names that several hydrogens of a residue may have
# At most so many runs of lines with one label, some with the same names, are joined by bonds.
MAX_RUNS = 100


class AtomTable:
    """Columns of the table by name, which are attributes: text as objects, numbers as numpy has them.

    A DataFrame would do, but pandas takes longer to load than a small protein takes to read.
    """

    def __init__(self, columns: Mapping[str, np.ndarray], row: np.ndarray) -> None:
        self.columns = dict(columns)
        self.row = row  # (A,) int, position of each atom in the input

    def __getattr__(self, name: str) -> np.ndarray:
        """Return a column."""
        try:
            return self.__dict__["columns"][name]
        except KeyError:
            raise AttributeError(f"no column {name!r}") from None

    def __len__(self) -> int:
        return len(self.row)

    @property
    def xyz(self) -> np.ndarray:
        """Positions (A, 3), Å."""
        return np.column_stack([self.x, self.y, self.z]).astype(float)

    def take(self, rows: np.ndarray) -> AtomTable:
        """Return the table of some rows, a mask or indices."""
        return AtomTable({name: column[rows] for name, column in self.columns.items()}, self.row[rows])

    def assign(self, **columns: np.ndarray) -> AtomTable:
        """Return the table with other or further columns (A,)."""
        return AtomTable(self.columns | columns, self.row)

    def labels(self, *names: str) -> list[tuple[Any, ...]]:
        """Return the values of some columns in each row."""
        return list(zip(*(self.columns[name].tolist() for name in names), strict=True))


@dataclass(frozen=True)
class AtomFile:
    """Content of an input without the frames of a trajectory."""

    atoms: AtomTable  # the table described above
    box: np.ndarray | None = None  # (3, 3) float, Å, lattice vectors as rows; None where there is none
    # residue names of each chain, where the file has them
    sequences: dict[str, list[str]] = field(default_factory=dict)
    # (chain, residue) with a bond to another one besides the backbone
    crosslinked: frozenset[tuple[str, str]] = frozenset()
    origin: str = ""  # see `plddt`
    # the box of each model by its number, where a file has several
    boxes: Mapping[int, np.ndarray | None] = field(default_factory=dict)
    # reads the biological assemblies that the file declares
    assemblies: Callable[[], Sequence[gemmi.Assembly]] = tuple

    def box_of(self, model: int) -> np.ndarray | None:
        """Return the box of a model (3, 3), Å; None without one."""
        return self.boxes.get(model, self.box)


def atom_table(**columns: Any) -> AtomTable:
    """Return the table of some columns (A,); the others have the values of `COLUMNS`."""
    n_atoms = len(next(iter(columns.values())))
    table = {}
    for name, default in ATOM_COLUMNS.items():
        values = columns.get(name, [default] * n_atoms)
        text = isinstance(default, str)
        table[name] = np.array([*map(str, values)], object) if text else np.asarray(values)
    return AtomTable(table, np.arange(n_atoms))


def molecules_of_bonds(atoms: AtomTable, bonds: np.ndarray) -> np.ndarray:
    """Return the column `molecule` (A,) from bonds (B, 2): it changes between residues that no bond spans."""
    crossing = np.zeros(len(atoms) + 1, int)
    low, high = np.sort(bonds, axis=1).T if len(bonds) else np.empty((2, 0), int)
    np.add.at(crossing, low, 1)
    np.add.at(crossing, high, -1)
    spanned = np.cumsum(crossing)[: len(atoms) - 1] > 0  # the place between each atom and the next one
    other = _differs(atoms.residue) | _differs(atoms.segid) | _differs(atoms.unit)
    return np.cumsum(np.append(False, other & ~spanned)) if len(bonds) else np.zeros(len(atoms), int)


def box_vectors(a: float, b: float, c: float, alpha: float, beta: float, gamma: float) -> np.ndarray | None:
    """Return lattice vectors (3, 3), Å, from lengths (Å) and angles (degrees); None if the box is impossible or a dummy."""
    if a == b == c == 0:  # no box, as VMD writes it
        return None
    try:
        cell = gemmi.UnitCell(a, b, c, alpha, beta, gamma)
        impossible = cell.is_crystal() and not cell.volume > MIN_BOX_VOLUME * a * b * c
    except RuntimeError:  # an angle of 0 or 180 degrees
        impossible = True
    if impossible:
        edges, angles = (", ".join(f"{x:g}" for x in values) for values in ((a, b, c), (alpha, beta, gamma)))
        message = "%s: a box of %s Å with angles of %s° is impossible: it counts as missing"
        log.warning(message, FILE, edges, angles)
        return None
    return np.array(cell.orth.mat.tolist()).T if cell.is_crystal() and cell.volume > 1 else None


def _differs(column: np.ndarray) -> np.ndarray:
    """Return whether each value but the first differs from the one before."""
    return column[1:] != column[:-1]


def _begins(atoms: AtomTable, *names: str) -> np.ndarray:
    """Return whether one of some columns differs in each row from the row before."""
    begins = np.ones(len(atoms), bool)
    begins[1:] = np.any([_differs(atoms.columns[name]) for name in names], axis=0)
    return begins


def _numbers_of(atoms: AtomTable, *names: str) -> np.ndarray:
    """Return a number for each row, the same where some columns are equal, in the order of their first places."""
    begins = _begins(atoms, *names)
    labels = zip(*(atoms.columns[name][begins].tolist() for name in names), strict=True)
    numbers: dict[Any, int] = {}
    return np.array([numbers.setdefault(label, len(numbers)) for label in labels], int)[np.cumsum(begins) - 1]


def settle_segments(atoms: AtomTable) -> AtomTable:
    """Return the table with the segments of whole residues: hydrogens without one take that of their residue.

    Segments tell molecules of one chain identifier apart. Where they differ between atoms of one residue that are bonded and
    have different names, the column holds something else (charges, scores, marks of a program) and is ignored.
    """
    if not (atoms.segid != "").any():
        return atoms
    of_residue = ("model", "chain", "residue", "residue_name")
    key, first = _numbers_of(atoms, *of_residue), _begins(atoms, *of_residue, "segid")
    labels = zip(key[first].tolist(), atoms.segid[first].tolist(), atoms.residue[first].tolist(), strict=True)
    found = Counter(number for number, _, label in {*labels} if any(map(str.isdigit, label)))
    several = [number for number, count in found.items() if count > 1]
    if not several:
        return atoms
    segid, name, xyz = atoms.segid.copy(), atoms.name.astype(str), atoms.xyz
    hydrogen = _begins_as_hydrogen(atoms)
    rows = np.flatnonzero(np.isin(key, several))
    rows = rows[np.argsort(key[rows], kind="stable")]
    for members in np.split(rows, np.flatnonzero(np.diff(key[rows])) + 1):
        bare = members[hydrogen[members] & (segid[members] == "")]
        named = members[segid[members] != ""]
        if len(bare) and not hydrogen[named].all():
            # that of the atom before it in the residue, or else of the one behind
            before = np.maximum(np.searchsorted(named, bare) - 1, 0)
            segid[bare] = segid[named[before]]
        parts = [members[segid[members] == segment] for segment in dict.fromkeys(segid[members])]
        for first, second in combinations(parts, 2):
            if (
                not set(name[first]) & set(name[second])
                and _shortest(xyz[first], xyz[second]) < MAX_RESIDUE_BOND
            ):
                log.info("%s: the segments differ within residues, so that they are ignored", FILE)
                return atoms.assign(segid=np.full(len(atoms), "", object))
    return atoms.assign(segid=segid)


def _begins_as_hydrogen(atoms: AtomTable) -> np.ndarray:
    """Return whether the name of each atom is one of a hydrogen, (A,) bool."""
    return np.isin(first_letters(atoms.name), ["H", "D"])


def _is_hydrogen(atoms: AtomTable) -> np.ndarray:
    """Return whether each atom is a hydrogen, (A,) bool: by its element, or by its name where it has none."""
    return np.isin(atoms.element, ["H", "D"]) | ((atoms.element == "") & _begins_as_hydrogen(atoms))


def unite_names(atoms: AtomTable) -> AtomTable:
    """Return a table with `residue_index` in which each residue has one name, that of its first atom; locations may differ."""
    plain = np.flatnonzero(atoms.altloc == "")
    if not len(plain):
        return atoms
    key = _numbers_of(atoms.take(plain), "model", "residue_index")
    names = atoms.residue_name[plain]
    first = names[np.unique(key, return_index=True)[1]][key]
    changed = np.flatnonzero(names != first)
    if not len(changed):
        return atoms
    row = plain[changed[0]]
    label = f"{first[changed[0]]} {atoms.residue[row]} {atoms.chain[row]}".strip()
    count = len(np.unique(key[changed]))
    message = "%s: %s its name between its atoms, the first is %s, also called %s; it keeps the first name"
    log.info(message, FILE, pluralise(count, "residue", "changes"), label, names[changed[0]])
    united = atoms.residue_name.copy()
    united[plain] = first
    return atoms.assign(residue_name=united)


def gather_residues(atoms: AtomTable) -> AtomTable:
    """Sort the atoms so that each residue stands together, and number the residues in a column `residue_index`.

    Lines of one label are one residue wherever they stand if no atom repeats, and else where they are bonded to each
    other: hydrogens behind the chain, atoms in the order of their elements, or alternate locations.
    """
    start = _starts(atoms)
    run = np.repeat(np.arange(len(start)), np.diff([*start, len(atoms)]))
    key = _numbers_of(atoms.take(start), "model", "chain", "segid", "residue")
    owner = np.arange(len(start))
    repeated = np.flatnonzero(np.bincount(key)[key] > 1)
    if len(repeated):
        rows = np.split(np.arange(len(atoms)), start[1:])
        names, hydrogens = _located_names(atoms), np.flatnonzero(_is_hydrogen(atoms))
        names[hydrogens] = [f"H{row}\0" for row in hydrogens]  # equal names of hydrogens split no residue
        lines = _Lines(
            names.tolist(),
            atoms.residue_name.tolist(),
            (atoms.altloc != "").tolist(),
            atoms.xyz,
        )
        by_key = repeated[np.argsort(key[repeated], kind="stable")]
        for members in np.split(by_key, np.flatnonzero(np.diff(key[by_key])) + 1):
            owner[members] = members[_join(lines, [rows[k].tolist() for k in members])]
    order = np.argsort(owner[run], kind="stable")
    gathered = atoms.assign(residue_index=owner[run]).take(order)
    first = np.append(True, _differs(gathered.residue_index) | _differs(gathered.model))
    number = np.cumsum(first) - 1
    model = np.append(True, _differs(gathered.model))
    return gathered.assign(residue_index=number - number[model][np.cumsum(model) - 1])


def _starts(atoms: AtomTable) -> np.ndarray:
    """Return the rows where runs of lines of one residue begin; a first atom that recurs beyond MAX_RESIDUE_BOND begins another.

    A run ends where a column of OF_RESIDUE changes, or the name. A change of the name between alternate locations does not count.
    """
    located = atoms.altloc != ""
    begins = _begins(atoms, *OF_RESIDUE)
    begins[1:] |= _differs(atoms.residue_name) & ~(located[1:] & located[:-1])
    run = np.cumsum(begins) - 1
    first = np.flatnonzero(begins)[run]
    name, xyz = _located_names(atoms), atoms.xyz
    again = np.flatnonzero((name == name[first]) & ~begins)
    if len(again):
        again = again[_heavy_atom_recurs(atoms, run)[run[again]]]
    begins[again] = np.linalg.norm(xyz[again] - xyz[first[again]], axis=1) > MAX_RESIDUE_BOND
    return np.flatnonzero(begins)


def _heavy_atom_recurs(atoms: AtomTable, run: np.ndarray) -> np.ndarray:
    """Return whether the first heavy atom of each run of lines (R,) recurs; hydrogens of one residue may all be called H."""
    heavy = np.flatnonzero(~_is_hydrogen(atoms))
    runs, leading = np.unique(run[heavy], return_index=True)
    name_of_first = np.full(run[-1] + 1, "", object)
    name_of_first[runs] = atoms.name[heavy[leading]]
    return np.bincount(run[heavy], atoms.name[heavy] == name_of_first[run[heavy]], minlength=run[-1] + 1) > 1


def _located_names(atoms: AtomTable) -> np.ndarray:
    """Return name and location of each atom as one text; numpy would drop a null that it adds."""
    return np.array([*map("\0".join, atoms.labels("name", "altloc"))], object)


class _Lines(NamedTuple):
    """Columns of the table by which runs of lines are joined: name with location, residue name, located, positions."""

    name: list[str]
    residue_name: list[str]
    located: list[bool]
    xyz: np.ndarray


def _join(lines: _Lines, runs: list[list[int]]) -> list[int]:
    """Return for each of some runs of lines with one label the first run of its residue."""
    first = list(range(len(runs)))
    held = [{lines.name[row] for row in run} for run in runs]
    atoms = [{lines.name[row].partition("\0")[0] for row in run} for run in runs]
    names = {lines.residue_name[run[0]] for run in runs if not lines.located[run[0]]}
    if len(names) < 2 and len(set().union(*atoms)) == sum(map(len, atoms)):
        return [0] * len(runs)
    if len(runs) > MAX_RUNS:
        return first
    pairs = []
    for j, k in combinations(first, 2):
        a, b = runs[j][0], runs[k][0]
        alike = lines.residue_name[a] == lines.residue_name[b] or (lines.located[a] and lines.located[b])
        alike = alike or not (lines.located[a] or lines.located[b])
        if alike and not held[j] & held[k]:
            distance = _shortest(lines.xyz[runs[j]], lines.xyz[runs[k]])
            pairs += [(distance, j, k)] if distance < MAX_RESIDUE_BOND else []
    for _, j, k in sorted(pairs):
        into, other = sorted((first[j], first[k]))
        called = {
            lines.residue_name[runs[number][0]]
            for number, residue in enumerate(first)
            if residue in (into, other)
        }
        located = lines.located[runs[into][0]] or lines.located[runs[other][0]]
        one_residue = len(called) < 2 or located or _is_one_residue(called, held[into] | held[other])
        if into != other and one_residue and not held[into] & held[other]:
            held[into] |= held[other]
            first = [into if residue == other else residue for residue in first]
    return first


def _is_one_residue(names: set[str], atoms: set[str]) -> bool:
    """Return whether atoms under several residue names are not more than one of these residues has, as in GLU and GLUP."""
    size = max(HEAVY_ATOMS.get(standard_name(name), 0) for name in names)
    letters = [name.partition("\0")[0].lstrip("0123456789'*")[:1] for name in atoms]
    return sum(letter not in ("H", "D") for letter in letters) <= size + 1  # and the second oxygen of an end


def _shortest(first: np.ndarray, second: np.ndarray) -> float:
    """Return the shortest distance between two groups of atoms; infinite without coordinates."""
    distance = np.linalg.norm(first[:, None] - second[None], axis=2)
    return float(np.nan_to_num(distance, nan=np.inf).min())


def missing_residues(atoms: AtomTable, sequences: dict[str, list[str]]) -> dict[str, tuple[int, int]]:
    """Find chains that lack residues of their full sequence: chain -> residues (with atoms, in the sequence)."""
    if not sequences:
        return {}
    names: dict[str, dict[str, str]] = defaultdict(dict)
    first_model = atoms.take(atoms.model == atoms.model[0])
    for chain, residue, name in first_model.labels("chain", "residue", "residue_name"):
        names[chain].setdefault(residue, name)
    counts = {
        chain: (sum(map(set(sequence).__contains__, names[chain].values())), len(sequence))
        for chain, sequence in sequences.items()
    }
    return {chain: (present, full) for chain, (present, full) in counts.items() if present < full}


def choose_altlocs(atoms: AtomTable, altloc: str) -> AtomTable:
    """Keep one location of every atom of a table with `residue_index`; raise InputError for another `altloc`.

    All atoms of a residue keep the same location: the first in the file ('first'), the one of highest mean
    occupancy ('highest') or the requested letter where the residue has it, else the first. An atom that only
    other locations of the residue have is kept too, so that there is no hole.
    """
    if not isinstance(altloc, str) or (altloc not in ("first", "highest") and len(altloc.strip()) != 1):
        raise InputError(
            f"{argument('altloc')}: '{altloc}' is neither first, highest nor one letter: choose one of them."
        )
    letters = sorted(set(atoms.altloc) - {""})
    if not letters:
        if altloc not in ("first", "highest"):
            log.warning("%s has no alternate locations: altloc %s changes nothing", FILE, altloc)
        return atoms
    located = atoms.altloc != ""
    if altloc == "highest" and not _is_share(atoms.occupancy[located]).all():
        raise InputError(
            f"{FILE} has an alternate location whose occupancy is not between 0 and 1: name a letter as "
            f"{argument('altloc')}, or 'first'."
        )
    if altloc not in ("first", "highest", *letters):
        message = "%s has no alternate location %s (it has %s): the first is used"
        log.warning(message, FILE, altloc, ", ".join(letters))
    keep = np.ones(len(atoms), bool)
    residue = _numbers_of(atoms, "model", "residue_index")
    rows = np.flatnonzero(np.bincount(residue, located)[residue])
    rows = rows[np.argsort(residue[rows], kind="stable")]
    for rows_of_residue in np.split(rows, np.flatnonzero(_differs(residue[rows])) + 1):
        keep[rows_of_residue] = _choose_location(atoms.take(rows_of_residue), altloc)
    return atoms.take(keep)


def _is_share(occupancy: np.ndarray) -> np.ndarray:
    """Return whether each occupancy lies between 0 and 1."""
    return (occupancy >= 0) & (occupancy <= 1)


def _choose_location(atoms: AtomTable, altloc: str) -> np.ndarray:
    """Return which atoms of a residue are kept, a bool per row."""
    columns = (atoms.name, atoms.altloc, atoms.residue_name, atoms.occupancy)
    names, locations, residue_names, occupancy = (column.tolist() for column in columns)
    rows = range(len(names))
    names = _numbered_hydrogens(names, locations)
    letters = list(dict.fromkeys(letter for letter in locations if letter))
    if altloc == "highest":
        shares = {letter: [occupancy[k] for k in rows if locations[k] == letter] for letter in letters}
        letters.sort(key=lambda letter: -_mean(shares[letter]))  # stable: the first wins a tie
    chosen = altloc if altloc in letters else letters[0]
    keep = np.array([letter in ("", chosen) for letter in locations])
    common, located = ({names[k] for k in rows if locations[k] == letter} for letter in ("", chosen))
    doubled = [k for k in rows if keep[k] and names[k] in common & located]
    if altloc == "highest":
        doubled.sort(key=lambda k: (math.isnan(occupancy[k]), -occupancy[k]))
    elif altloc in letters:
        doubled.sort(key=lambda k: locations[k] == "")
    _drop_repeated(keep, doubled, names)
    residues_kept = {residue_names[k] for k in rows if locations[k] == chosen}
    names_kept = {names[k] for k in rows if keep[k]}
    missing = [k for k in rows if residue_names[k] in residues_kept and names[k] not in names_kept]
    keep[missing] = True
    _drop_repeated(keep, missing, names)
    return keep


def _numbered_hydrogens(names: list[str], locations: list[str]) -> list[str]:
    """Return names in which a number tells the hydrogens of a location apart that are all called H."""
    found: dict[tuple[str, str], int] = defaultdict(int)
    numbered = []
    for name, location in zip(names, locations, strict=True):
        if name in BARE_HYDROGENS:
            found[name, location] += 1
            name = f"{name}{found[name, location]}\0"
        numbered.append(name)
    return numbered


def _mean(values: list[float]) -> float:
    """Return the mean of numbers, whose sum is compensated for rounding (Kahan), as that of pandas is."""
    total = lost = 0.0
    for value in values:
        value -= lost
        lost = (total + value) - total - value
        total += value
    return total / len(values)


def _drop_repeated(keep: np.ndarray, rows: list[int], names: list[str]) -> None:
    """Keep the first of several rows with the same name."""
    seen: set[str] = set()
    for k in rows:
        if names[k] in seen:
            keep[k] = False
        seen.add(names[k])


def refuse_control_characters(atoms: AtomTable) -> None:
    """Raise InputError if a name has characters that cannot be printed, such as escape codes for a terminal."""
    for column in ("name", "residue_name", "chain", "segid", "element", "residue"):
        damaged = next(
            (text for text in dict.fromkeys(getattr(atoms, column).tolist()) if not text.isprintable()), None
        )
        if damaged is not None:
            raise InputError(
                f"{FILE} has an atom whose {column.replace('_', ' ')} is {damaged!r}: repair the file."
            )


def report_duplicates(atoms: AtomTable) -> None:
    """Warn of repeated atom names in a residue (a repeated line); the surface counts a position once."""
    first_model = atoms.take(atoms.model == atoms.model[0])
    bare = np.isin(first_model.name, BARE_HYDROGENS)  # all hydrogens of a residue may be called H
    names = {*first_model.take(~bare).labels("residue_index", "residue_name", "name")}
    places = {*first_model.take(bare).labels("residue_index", "residue_name", "name", "x", "y", "z")}
    count = len(first_model) - len(names) - len(places)
    if count:
        whose = "its residue" if count == 1 else "their residues"
        log.warning("%s: %s repeated in %s", FILE, pluralise(count, "atom", "is"), whose)


def report_occupancies(atoms: AtomTable) -> None:
    """Warn of occupancies that are not between 0 and 1; they count only where they decide between alternate locations."""
    impossible = ~_is_share(atoms.occupancy)
    if impossible.any():
        message = "%s: %s an occupancy outside 0 to 1, such as %g; is another quantity in its column?"
        counted = pluralise(int(impossible.sum()), "atom", "has")
        log.warning(message, FILE, counted, atoms.occupancy[impossible][0])
