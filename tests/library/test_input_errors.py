"""An error of the user, whose message each door words in its own way."""

import logging
import pickle
import threading
from argparse import Namespace
from concurrent.futures import ThreadPoolExecutor

import gemmi
import mdtraj
import numpy as np
import pytest

from peptides import peptide, write
from sparsurf.api.inputs import as_dots, as_molecule
from sparsurf.cli.options import requested_atoms
from sparsurf.dot_fields.columns import columns_of
from sparsurf.errors import FILE, InputError, argument, naming_file
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.spheres import read_spheres
from sparsurf.surfaces.surface import Surface


def test_each_door_words_the_arguments_of_an_error():
    error = InputError(f"{argument('patches.d_link')} is 5; choose `{argument('r_patch')}` above it.")
    assert error.arguments == ("patches.d_link", "r_patch")
    assert str(error) == "d_link is 5; choose `r_patch` above it."
    assert error.worded(str.upper) == "PATCHES.D_LINK is 5; choose `R_PATCH` above it."


def test_an_error_keeps_its_arguments_on_the_way_from_another_process():
    error = pickle.loads(pickle.dumps(InputError(f"{argument('seed')} is -1.")))
    assert error.arguments == ("seed",) and str(error) == "seed is -1."


def test_messages_call_the_file_that_is_read_by_its_name(caplog):
    """The innermost file is named, also after an error, and each thread reads its own."""

    def refuse(name, both=None):
        with naming_file(name):
            if both:
                both.wait()  # until the other thread reads its file, too
            raise InputError(f"{FILE}: line 3 is wrong.")

    with naming_file("top.pdb"), caplog.at_level(logging.WARNING, "sparsurf"):
        with pytest.raises(InputError, match=r"^run\.xtc: line 3"):
            refuse("run.xtc")
        logging.getLogger("sparsurf").warning("%s has %d atoms", FILE, 5)
        both = threading.Barrier(2)
        with ThreadPoolExecutor(2) as pool:
            answers = [pool.submit(refuse, name, both) for name in ("a.gro", "b.gro")]
            errors = [answer.exception() for answer in answers]
    assert caplog.messages == ["top.pdb has 5 atoms"]
    assert [str(error) for error in errors] == ["a.gro: line 3 is wrong.", "b.gro: line 3 is wrong."]
    assert str(InputError(f"{FILE} holds no atoms.")) == "the file holds no atoms."


def small(folder):
    """A peptide as a molecule."""
    return read_molecule(write(folder / "small.pdb", peptide() + "END\n"))


def of_mdtraj(folder):
    trajectory = mdtraj.load(str(write(folder / "small.pdb", peptide() + "END\n")))
    trajectory.xyz[:] = 0
    return as_molecule(trajectory)


def of_mdanalysis(_folder):
    return as_molecule(pytest.importorskip("MDAnalysis").Universe.empty(12, trajectory=True))


def without_coordinates(folder):
    """A topology that has names only, and a trajectory with a damaged line."""
    atoms = "".join(
        f"{k:8d} P    1    ALA  {name:4s} X     0.0    12.0   0\n" for k, name in enumerate("NCO", 1)
    )
    topology = write(folder / "top.psf", f"PSF\n\n       1 !NTITLE\n title\n\n       3 !NATOM\n{atoms}")
    run = write(folder / "run.xyz", "3\nfirst frame\nN 0.0 0.0 0.0\nC 1.5 x 0.0\nO 2.0 1.0 0.0\n")
    return read_molecule(topology, run)


NOWHERE = np.zeros((60, 3)), np.tile([0, 0, 1.0], (60, 1))
DOORS = {
    "a trajectory": (without_coordinates, "{folder}/run.xyz: line 4 has no three coordinates"),
    "an npz of a study": (lambda folder: read_npz(write(folder / "a.npz", "PK")), "{folder}/a.npz is not a surface"),
    "spheres": (lambda folder: read_spheres(write(folder / "a.xyzr", "1 2\n")), "{folder}/a.xyzr: line 1 does not"),
    "a table": (lambda folder: columns_of(write(folder / "a.csv", "x\n")), "{folder}/a.csv has no column residue"),
    "residues of a command": (
        lambda folder: requested_atoms(Namespace(file="a.pdb", residues="99"), small(folder)),
        "residues: '99' is not in a.pdb, which has",
    ),
    "a molecule": (lambda folder: small(folder).select(chains="Q"), "the molecule has no chain Q"),
    "arrays of a pair": (lambda _: as_dots(NOWHERE), "surface: all its dots lie in one place"),
    "arrays": (lambda _: Surface(np.eye(3), np.eye(3), area=[1, -1, 1]), "surface: dot 2 has a negative area"),
    "mdtraj": (of_mdtraj, "the trajectory has all atoms at one position"),
    "gemmi": (lambda _: as_molecule(gemmi.Structure()), "the structure of gemmi has no atoms"),
    "MDAnalysis": (of_mdanalysis, "the AtomGroup"),
}  # fmt: skip


@pytest.mark.parametrize("door", DOORS)
def test_each_door_names_what_it_reads(tmp_path, door):
    call, begin = DOORS[door]
    with pytest.raises(InputError) as error:
        call(tmp_path)
    assert str(error.value).startswith(begin.format(folder=tmp_path))


def test_arrays_in_half_precision_are_called_a_surface(caplog):
    Surface(np.eye(3, dtype=np.float16), np.eye(3))
    assert caplog.messages[0].startswith("surface: its positions")
