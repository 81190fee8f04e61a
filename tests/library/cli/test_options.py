"""Every option of a command reaches its result: the file differs from that of the command without the option."""

import pytest

import sparsurf
from peptides import atom_line, peptide, write
from sparsurf.cli import command

CALLS = {  # with which options are combined
    "surface": "two.pdb",
    "residues": "two.pdb",
    "roughness": "two.pdb",
    "descriptors": "two.pdb --every 40",
    "minimal": "two.pdb --percent 10",
    "recover": "few.csv",
}
OF_ATOMS = ["--chains A", "--selection backbone", "--ligands LIG", "--frame 1"]
OF_DOTS = [*OF_ATOMS, "--d-link 0.7"]
OPTIONS = {
    "surface": [*OF_ATOMS, "--residues 2-4", "--probe-radius 1.6", "--density 9", "--radii bondi",
     "--fields hydropathy", "--mesh"],
    "residues": [*OF_ATOMS, "--residues 2-4", "--fields hydropathy"],
    "roughness": [*OF_DOTS, "--residues 2-4", "--r-patch 3"],
    "descriptors": [*OF_DOTS, "--residues 2-4", "--at 0,5", "--every 30", "--r-zernike 5", "--down",
     "--descriptor rotation_robust"],
    "minimal": [*OF_DOTS, "--fields hydropathy", "--percent 12", "--n-dots 50", "--density 0.6", "--error 0.1", "--max-z 1.5",
     "--sampler uniform", "--seed 2"],
    "recover": ["--density 9", "--reach 1.2", "--at few.csv", "--mesh"],
}  # fmt: skip
# test_command.py, and of models that are copies tests/library/test_corpus.py
ELSEWHERE = {"--help", "--output", "--trajectory", "--cavities", "--assembly"}
INSTEAD = {
    "--percent": ("--n-dots", "--density", "--error", "--max-z"),
    "--every": ("--at",),
}  # options that exclude one another


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A file of two models with two chains, a place with two locations, a hydrogen and a ligand; files for its options."""
    place = tmp_path_factory.mktemp("options")
    texts = []
    for k in range(2):
        origin = (0, 0.4 * k, 0)
        first = peptide(("ALA", "SER", "LYS", "VAL"), origin=origin)
        first += atom_line("CB", "GLY", "A", "5", (13.3, 5.7, 0), altloc="A", occupancy=0.6)
        first += atom_line("CB", "GLY", "A", "5", (13.3, 6.7, 1), altloc="B", occupancy=0.4)
        first += atom_line("CA", "GLY", "A", "5", (13.3, 5.7, 1.5 + k)) + atom_line(
            "H", "GLY", "A", "5", (14, 7.4, 2)
        )
        second = peptide(("LEU", "GLY"), "B", origin=(0, 6, 0))
        ligand = atom_line("C1", "LIG", "C", "1", (5, 4.5, 4), record="HETATM")
        texts.append(f"MODEL     {k + 1:4d}\n{first}TER\n{second}TER\n{ligand}ENDMDL\n")
    write(place / "two.pdb", "".join(texts) + "END\n")
    sparsurf.write(sparsurf.minimal(place / "two.pdb", percent=10), place / "few.csv")
    return place


def result(folder, out, name, call, options=""):
    """Return the bytes that a command writes."""
    words = call.split()
    for option, others in INSTEAD.items():
        if {option, *others} & {*options.split()} and option in words:
            del words[words.index(option) : words.index(option) + 2]
    suffix = "ply" if "--mesh" in options else "csv"
    path = out / f"x.{suffix}"
    assert command.main([name, *words, *options.split(), "--quiet", "-o", str(path)]) == 0
    return path.read_bytes()


@pytest.mark.parametrize("name", OPTIONS)
def test_every_option_is_in_the_table(name):
    listed = {word for words in OPTIONS[name] for word in words.split() if word.startswith("--")}
    actions = [
        action.option_strings[-1]
        for action in command.build_parser(name)[1]._actions
        if action.option_strings
    ]
    assert {*actions} - ELSEWHERE == listed


@pytest.mark.parametrize(
    ("name", "options"), [(name, words) for name, rows in OPTIONS.items() for words in rows]
)
def test_an_option_changes_the_result(folder, tmp_path, monkeypatch, name, options):
    monkeypatch.chdir(folder)
    (tmp_path / "without").mkdir()
    without = result(folder, tmp_path / "without", name, CALLS[name])
    assert result(folder, tmp_path, name, CALLS[name], options) != without
