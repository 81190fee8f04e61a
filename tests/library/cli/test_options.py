"""Every option of a command reaches its result: the file differs from that of the command without the option."""

import pytest

import sparsurf
from peptides import two_models, write
from sparsurf.cli import command

CALLS = {  # with which options are combined
    "surface": "two.pdb",
    "residues": "two.pdb",
    "roughness": "two.pdb",
    "descriptors": "two.pdb --every 40",
    "minimal": "two.pdb --percent 10",
    "recover": "few.csv",
    "points": "two.pdb --n-dots 40",
}
OF_ATOMS = ["--chains A", "--selection backbone", "--ligands LIG", "--frame 1", "--model 2", "--assembly"]
OF_DOTS = [*OF_ATOMS, "--d-link 0.7"]
OPTIONS = {
    "surface": [*OF_ATOMS, "--residues 2-4", "--probe-radius 1.6", "--density 9", "--radii bondi",
     "--fields hydropathy", "--mesh", "--mesh --step 0.6",
     "--mesh --colours"],
    "residues": [*OF_ATOMS, "--residues 2-4", "--fields hydropathy"],
    "roughness": [*OF_DOTS, "--residues 2-4", "--r-patch 3"],
    "descriptors": [*OF_DOTS, "--residues 2-4", "--at 0,5", "--every 30", "--r-zernike 5", "--down",
     "--descriptor rotation_robust"],
    "minimal": [*OF_DOTS, "--fields hydropathy", "--percent 12", "--n-dots 50", "--density 0.6", "--error 0.1", "--max-z 1.5",
     "--sampler uniform", "--seed 2", "--error-99 0.2"],
    "points": [*OF_ATOMS, "--n-dots 50", "--density 0.5", "--seed 3", "--probe-radius 1.6", "--radii bondi",
     "--fields roughness"],
    "recover": ["--density 9", "--reach 1.2", "--at few.csv", "--mesh", "--mesh --step 0.4", "--mesh --colours",
     "--model interpolant"],
}  # fmt: skip
# test_command.py, and of models that are copies tests/library/test_corpus.py
ELSEWHERE = {"--help", "--output", "--trajectory", "--cavities", "--jobs"}
TOO_FEW = ("recover", "--model interpolant")  # dots to infer atoms from; tests/library/sampling/test_cover.py
INSTEAD = {
    "--n-dots": ("--density",),
    "--percent": ("--n-dots", "--density", "--error", "--error-99", "--max-z"),
    "--every": ("--at",),
}  # options that exclude one another


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a file of two models, and its minimal subset."""
    place = tmp_path_factory.mktemp("options")
    write(place / "two.pdb", two_models())
    write(place / "apart.pdb", two_models(shift=40))  # for --assembly
    sparsurf.write(sparsurf.minimal(place / "two.pdb", percent=10), place / "few.csv")
    return place


def result(folder, out, name, call, options="", apart=False):
    """Return the bytes that a command writes."""
    words = call.replace("two", "apart" if apart else "two").split()
    for option, others in INSTEAD.items():
        if {option, *others} & {*options.split()} and option in words:
            del words[words.index(option) : words.index(option) + 2]
    suffix = "ply" if "--mesh" in options or name == "points" else "csv"
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
    ("name", "options"),
    [(name, words) for name, rows in OPTIONS.items() for words in rows if (name, words) != TOO_FEW],
)
def test_an_option_changes_the_result(folder, tmp_path, monkeypatch, name, options):
    monkeypatch.chdir(folder)
    (tmp_path / "without").mkdir()
    apart = options == "--assembly"
    without = result(folder, tmp_path / "without", name, CALLS[name], apart=apart)
    assert result(folder, tmp_path, name, CALLS[name], options, apart) != without


ERRORS = {  # of functions that name arguments of Python or keys of a study
    "surface two.pdb --chains Q": "two.pdb has no chain Q",
    "surface two.pdb --residues 9-5": "--residues: '9-5' ends",
    "roughness two.pdb --d-link 0.01": "needs more than 100 dots per Å^2; give a larger --d-link.",
    "surface two.pdb --assembly": "conformations and not parts of one molecule; leave out `--assembly`.",
    "minimal mixed.pdb --percent 10": "choose one by `--model`, or take all models as one molecule by `--assembly`.",
    "points mixed.pdb": "choose one by `--model`, or take all models as one molecule by `--assembly`.",
}


@pytest.mark.parametrize("call", ERRORS)
def test_an_error_names_the_options_of_its_command(folder, monkeypatch, capsys, call):
    monkeypatch.chdir(folder)
    text = (folder / "two.pdb").read_text()
    (folder / "mixed.pdb").write_text(text[: text.rindex("ATOM")] + "ENDMDL\nEND\n")
    name, *words = call.split()
    assert command.main([name, *words, "-o", "x.npz"]) == 1
    message = capsys.readouterr().err.splitlines()[-1]
    assert message.startswith(f"sparsurf {name}: ") and ERRORS[call] in message
