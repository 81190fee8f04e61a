"""Whether two molecules are the same protein, or nearly, by their sequences."""

WORD = 5  # residues
ALIKE = 0.25  # share of the words of the smaller one; unrelated proteins share next to none


def words_of(molecule):
    """Every run of `WORD` residue names within a chain of protein, a set."""
    residues = molecule.residues
    found = set()
    for _, names in residues.groupby("chain", sort=False)["residue_name"]:
        names = names.tolist()
        found |= {tuple(names[k : k + WORD]) for k in range(len(names) - WORD + 1)}
    return found


def likeness(one, other):
    """Share of the words of the smaller set that the larger one has too, 0 to 1; 0 where a set is empty."""
    least = min(len(one), len(other))
    return len(one & other) / least if least else 0.0
