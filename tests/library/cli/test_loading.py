"""What a command loads: mistakes are reported before numba is, and a library only where it is needed."""

import subprocess
import sys

import pytest

from peptides import peptide

CALL = """
import sys
from sparsurf.cli.{} import main
try:
    code = main(sys.argv[1:])
except SystemExit as end:
    code = end.code
print(code, *sorted(sys.modules))
"""


def loaded(folder, *words, module="command"):
    """The exit code of a command, and the modules that it loaded."""
    call = [sys.executable, "-c", CALL.format(module), *words]
    run = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=True)
    code, *modules = run.stdout.splitlines()[-1].split()
    return int(code), set(modules)


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ("surface nonexist.pdb -o x.npz", 1),
        ("surface nonexist.pdb -o x.xyz", 1),
        ("surface nonexist.pdb --densty 3 -o x.npz", 2),
        ("surface nonexist.pdb --probe-radius -1 -o x.npz", 2),
        ("roughness nonexist.csv -o x.npz", 1),
        ("residues nonexist.pdb -o x.csv", 1),
    ],
)
def test_a_mistake_is_reported_before_numba_is_loaded(tmp_path, words, code):
    ended, modules = loaded(tmp_path, *words.split())
    assert ended == code and "numba" not in modules


# The packages that each command may load, besides numpy, numba, gemmi, threadpoolctl and what numba imports of scipy
LARGE = (
    "pandas",
    "pydantic",
    "scipy.linalg",
    "scipy.spatial",
    "mdtraj",
    "jinja2",
    "matplotlib",
    "tqdm",
    "numba.np.arraymath",
)
MAY_LOAD = {
    "areas p.pdb -o x.csv": "",
    "areas p.pdb --residues 2 --of atoms -o x.csv": "",
    "points p.pdb -n 20 -o x.npz": "",
    "points p.pdb -n 20 -o x.ply": "",
    "surface p.pdb -o x.npz": "",
    "surface p.pdb -o x.ply": "",
    "residues p.pdb -o x.csv": "pydantic",
    "roughness p.pdb -o x.npz": "pydantic",
    "surface p.pdb -o x.csv": "",
    "surface p.pdb --mesh -o x.ply": "",
    "points p.pdb -n 20 -o x.csv": "",
    "atoms p.pdb -o x.pdb": "",
    "regions p.pdb --field hydropathy --above 1 --min-area 1 -o x.csv": "pydantic",
    "minimal p.pdb --percent 20 -o x.csv": "pydantic",
    "show p.pdb --no-open -o x.html": "pandas pydantic jinja2",
}


@pytest.mark.parametrize("command", MAY_LOAD)
def test_a_warm_command_loads_nothing_that_it_does_not_need(tmp_path, command):
    """`scipy.linalg` and `numba.np.arraymath` are what numba loads before it compiles."""
    (tmp_path / "p.pdb").write_text(peptide(["ALA", "GLY", "SER"]) + "END\n")
    for _ in range(2):  # the first may compile kernels
        code, modules = loaded(tmp_path, *command.split(), "-q")
        if modules & {*LARGE} <= {*MAY_LOAD[command].split()}:
            break
    assert code == 0 and (tmp_path / command.split()[-1]).stat().st_size
    assert modules & {*LARGE} <= {*MAY_LOAD[command].split()}


def test_the_command_of_msms_loads_neither_pandas_nor_scipy(tmp_path):
    (tmp_path / "p.xyzr").write_text("0 0 0 1.5\n3 0 0 1.5\n1.5 2 0 1.5\n1.5 1 2 1.5\n")  # with concave parts
    large = {"pandas", "scipy.spatial", "pydantic", "mdtraj", "xml.sax"}
    for _ in range(2):  # the first may compile kernels
        code, modules = loaded(tmp_path, *["-if", "p.xyzr", "-of", "x", "-af", "x"], module="msms")
        if not modules & large:
            break
    assert code == 0 and " 3 " in (tmp_path / "x.vert").read_text()
    assert not modules & large


@pytest.mark.parametrize(("words", "is_own_process"), [("", True), ("['--version']", False)])
def test_garbage_is_collected_rarely_in_the_process_of_a_command_alone(words, is_own_process):
    """Who calls `main` from Python keeps the thresholds of the process."""
    code = "import gc\nfrom sparsurf.cli.command import main\nbefore = gc.get_threshold()\n"
    code += f"try:\n    main({words})\nexcept SystemExit:\n    print(gc.get_threshold() == before)\n"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines()[-1] == str(not is_own_process)


def test_an_interrupt_while_modules_load_is_one_line():
    code = """
import sys
from sparsurf.__main__ import main
class Interrupting:
    def find_spec(name, *_):
        if name == "sparsurf.garbage_collection":  # one of those that the command needs
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interrupting)
sys.exit(main())
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (130, "sparsurf: interrupted\n")


@pytest.mark.parametrize(
    ("stream", "output", "sentence"),
    [
        (None, "-", ""),
        (None, "x.csv", ""),
        (None, "x.unknown", "this result cannot be written as '.unknown'"),
        ("/dev/full", "-", "the output: No space left on device."),
        ("/dev/full", "x.csv", ""),
        ("closed", "-", "the standard output is closed"),
        ("closed", "x.csv", ""),
    ],
)
def test_the_command_that_ends_early_has_written_all(tmp_path, stream, output, sentence):
    (tmp_path / "p.pdb").write_text(peptide(["ALA", "GLY", "SER"]) + "END\n")
    code = "from sparsurf.__main__ import run\nrun()"
    call = [sys.executable, "-c", code, "areas", "p.pdb", "-q", "-o", output]
    if stream == "closed":
        closing = "import os, sys; os.close(1); os.execv(sys.argv[1], sys.argv[1:])"
        call = [sys.executable, "-c", closing, *call]
    with open(stream if stream == "/dev/full" else tmp_path / "-", "wb") as out:
        run = subprocess.run(call, cwd=tmp_path, stdout=out, stderr=subprocess.PIPE, text=True, check=False)
    assert bool(run.returncode) == bool(sentence), run.stderr
    assert sentence in run.stderr and "Traceback" not in run.stderr
    if not sentence:
        table = (tmp_path / output).read_text()
        assert table.endswith("\n") and [row.split(",")[1] for row in table.splitlines()[1:]] == [
            "1",
            "2",
            "3",
        ]
