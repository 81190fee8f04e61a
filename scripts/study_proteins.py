"""Measure what the default study measures on many proteins: `python scripts/study_proteins.py structures results/over_proteins`.

Every structure of a folder is read (first model, protein only, without hydrogens), small ones first; one whose sequence is
like that of a protein already measured is left out. A protein that is there is not measured again; `--most-dots` leaves
out what is larger. `--recovered N` measures a quarter of the grid of the N smallest again, each subset made a surface of its
own, and `--whole N` all of the grid that way; `--variants N` measures the N smallest of 400 atoms or more again, with one
rule changed at a time.
"""

import argparse
import sys
import time
from pathlib import Path

from sparsurf import InputError
from sparsurf.molecules.formats import STRUCTURES, suffix
from sparsurf.molecules.likeness import ALIKE, likeness, words_of
from sparsurf.molecules.reading import read_molecule
from sparsurf.recovery.readings import RECOVERED
from sparsurf.sampling import law
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.study import protein_variants
from sparsurf.study.protein_files import save
from sparsurf.study.protein_scores import OF_RECOVERED, READINGS, WHOLE, Rules, measure, thin_grid
from sparsurf.threads import available_cores
from sparsurf.workflow.config import check

FEWEST_ATOMS = 150  # a peptide of fewer has no patch that its neighbours do not share
VARIED = 400  # atoms of the smallest protein that is measured with rules changed
ALL_HYDROGENS = 0.4  # of the atoms; a protein has about as many as other atoms
ATOM_DOTS = 35.0  # dots of an atom without hydrogens, about


def structures(folder):
    """Name, path and molecule without hydrogens of every readable structure of a folder, the smallest first."""
    found = []
    for path in sorted(Path(folder).iterdir()):
        if suffix(path) not in STRUCTURES:
            continue
        try:
            molecule = read_molecule(path, hydrogens="remove")
        except InputError as error:
            print(f"{path.name}: left out, {error}", flush=True)
            continue
        found.append((path.name.split(".")[0], path, molecule))
    if not found:
        raise InputError(f"{folder} holds no structure that can be read.")
    return sorted(found, key=lambda each: (each[2].n_atoms, each[0]))


def distinct(found):
    """Those that are no conformation or near relative of a smaller one."""
    seen = {}
    for name, path, molecule in found:
        words = words_of(molecule)
        like = [other for other, theirs in seen.items() if likeness(words, theirs) > ALIKE]
        if molecule.n_atoms < FEWEST_ATOMS or like:
            why = (
                f"its sequence is like that of {like[0]}" if like else f"{molecule.n_atoms} atoms are too few"
            )
            print(f"{name}: left out, {why}", flush=True)
            continue
        seen[name] = words
        yield name, path, molecule


def combinations_of(sampling):
    """The grid of the config's `sampling`, (K, 4)."""
    return law.grid(*(sampling[key] for key in PARAMETERS))


def main(folder, out, most_dots=None, recovered=0, whole=0, variants=0, threads=1):
    """Measure what is missing."""
    out = Path(out)
    found = structures(folder)
    sampling = check({"proteins": {"any": {"structure": str(found[0][1])}}})["sampling"]
    proteins = list(distinct(found))
    every, thin = combinations_of(sampling), combinations_of(thin_grid(sampling))
    for name, _, molecule in proteins:
        _measure_one(out / name, molecule, every, Rules(), threads, most_dots=most_dots)
    for folder, combinations, number in ((RECOVERED, thin, recovered), (WHOLE, every, whole)):
        for name, _, molecule in proteins[:number]:
            place = out / folder / name
            _measure_one(place, molecule, combinations, Rules(), threads, OF_RECOVERED, readings=(RECOVERED,))
    if variants:
        measure_variants(proteins, out / "variants", thin, variants, threads)


def measure_variants(proteins, out, combinations, number, threads):
    """Measure a few proteins with one rule changed at a time."""
    protein_variants.enter_short_descriptor()
    some = [(name, molecule) for name, _, molecule in proteins if molecule.n_atoms >= VARIED][:number]
    whole = with_hydrogens(proteins, number)
    bare = {name: molecule for name, _, molecule in proteins}
    subjects = dict.fromkeys(protein_variants.VARIANTS, some) | {protein_variants.HYDROGENS: whole}
    names = dict.fromkeys(name for name, _ in some + whole)
    subjects[protein_variants.DEFAULT] = [(name, bare[name]) for name in names]
    for variant, rules in ((variant, protein_variants.rules_of(variant)) for variant in subjects):
        for name, molecule in subjects[variant]:
            place = out / variant / name
            _measure_one(place, molecule, combinations, rules, threads, protein_variants.COUNTS)


def with_hydrogens(proteins, number):
    """Name and molecule with its hydrogens of the first proteins whose files hold them all, about."""
    found = []
    for name, path, _ in proteins:
        molecule = read_molecule(path)
        if (molecule.element == "H").mean() > ALL_HYDROGENS:
            found.append((name, molecule))
        if len(found) == number:
            break
    return found


def _measure_one(
    place, molecule, combinations, rules, threads, counts=None, readings=READINGS, most_dots=None
):
    """Measure one protein into a folder of its own, unless that is there or the protein is too large."""
    if place.is_dir():
        return
    begin = time.monotonic()
    dots = ATOM_DOTS * molecule.n_atoms
    if most_dots and dots > most_dots:
        print(f"{place.name}: left out, about {dots:.0f} dots", flush=True)
        return
    try:
        tables = measure(molecule, place.name, combinations, rules, threads, counts, readings)
    except InputError as error:
        print(f"{place.name}: left out, {error}", flush=True)
        return
    save(place, *tables, n_atoms=int(molecule.n_atoms), n_residues=int(molecule.n_residues))
    seconds = time.monotonic() - begin
    print(f"{place.parent.name}/{place.name}: {tables[0].n_dots} dots, {seconds:.1f} s", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("structures", help="folder of structures")
    parser.add_argument("results", help="folder of results, one per protein")
    parser.add_argument("--most-dots", type=float, help="leave out proteins with about more dots")
    parser.add_argument(
        "--recovered",
        type=int,
        default=0,
        metavar="N",
        help="proteins a quarter of whose grid is recovered too",
    )
    parser.add_argument(
        "--whole", type=int, default=0, metavar="N", help="proteins all of whose grid is recovered too"
    )
    parser.add_argument(
        "--variants", type=int, default=0, metavar="N", help="proteins measured with rules changed"
    )
    parser.add_argument("--threads", type=int, default=available_cores())
    wish = parser.parse_args()
    try:
        main(
            wish.structures,
            wish.results,
            wish.most_dots,
            wish.recovered,
            wish.whole,
            wish.variants,
            wish.threads,
        )
    except InputError as error:
        sys.exit(str(error))
