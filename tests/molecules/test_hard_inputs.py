"""The files that go wrong elsewhere: each is read right, or refused in one sentence that says why.

The last tests damage good files at random; SPARSURF_FUZZ_CASES sets how many.
"""

import gzip
import logging
import multiprocessing
import os
import random
import re
from pathlib import Path

import mdtraj
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from peptides import atom_line, peptide, write
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule

GOOD = peptide() + "END\n"
SHORT = "\n".join(line[:54] for line in GOOD.split("\n"))
SEQUENCE = "SEQRES   1 A    9  ALA ALA ALA ALA ALA ALA ALA ALA ALA\n"
ITEMS = (
    "group_PDB",
    "auth_atom_id",
    "auth_comp_id",
    "auth_asym_id",
    "auth_seq_id",
    "Cartn_x",
    "Cartn_y",
    "Cartn_z",
)
GRO_LINE = "    1ALA     CA    1   0.100   0.200   0.300\n"
CIF = "data_x\nloop_\n" + "".join(f"_atom_site.{item}\n" for item in ITEMS)
CIF += "ATOM CA ALA A 1 1.0 2.0 3.0\nATOM CB ALA A 1 2.0 2.0 3.0\n"


def refused(path, words, trajectory=None, **keys):
    """The sentence, checked: the words, the name of the file, one line, one full stop at the end."""
    with pytest.raises(InputError, match=words) as caught:
        read_molecule(path, trajectory, **keys)
    message = str(caught.value)
    assert Path(trajectory or path).name in message
    assert "\n" not in message and message.endswith(".")


# --- files of the reference data -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("1ubi_CAonly.pdb", "13% of the heavy atoms .*C-alpha"),
        ("3enl_TRUNCATED_at60000bytes.pdb", "cut short: it stops in the middle of an atom"),
        ("header_only.pdb", "holds no atoms"),
        ("adk_notop_BAD.psf", "cannot be read .* damaged"),
    ],
)
def test_bad_files_are_refused(shared, name, words):
    refused(shared / "data" / "bad" / name, words)


# file: frames, atoms, residues chosen by default
READ = {
    "bad/1lcd_models_differ.pdb": (3, 497, 51),  # the models differ in their waters only
    "bad/blank_occupancy.pdb": (1, 3, 1),
    "structures/1BD2.cif.gz": (1, 6339, 815),
    "structures/1BD2.pdb.gz": (1, 6339, 815),
    "structures/1a8o_mse.cif": (1, 556, 70),
    "structures/1a8o_mse.pdb": (1, 556, 70),
    "structures/1fas.cif": (1, 468, 61),
    "structures/1hvr_dimer_ligand_CSO.pdb": (1, 1844, 198),
    "structures/1ubi.pdb": (1, 602, 76),
    "structures/2beg_fibril5chains.pdb": (1, 1855, 130),
    "structures/2k39_nmr15.pdb.gz": (15, 1231, 76),
    "structures/3mht_dna.pdb": (1, 2606, 327),
    "structures/3nzmA_negres.pdb.gz": (1, 1285, 163),
    "structures/4cup.cif": (1, 924, 115),
    "structures/6zu5_ribosome.cif.gz": (1, 80970, 10308),
    "structures/7etn_tiny.cif.gz": (1, 150, 8),
    "structures/A6PA6_13res_nochain.pdb": (1, 137, 13),
    "structures/ala3_3res.pdb": (1, 33, 3),
    "structures/cobrotoxin_gmx_nochain.pdb": (1, 918, 62),
    "structures/neopetrosiamide_nmr24.pdb": (24, 392, 28),
    "trajectories/1vii_3frames.pdb": (3, 596, 36),
    "trajectories/ala2.h5": (100, 22, 3),
    "trajectories/trpcage_38models.pdb.gz": (38, 304, 20),
    "trajectories/adk.psf": (98, 3341, 214),
    "trajectories/DPDP.parm7": (100, 332, 22),
    "trajectories/tz2.parm7": (101, 223, 13),
}
TRAJECTORY_OF = {"adk.psf": "adk_dims.dcd", "DPDP.parm7": "DPDP.nc", "tz2.parm7": "tz2.nc"}


@pytest.mark.parametrize("name", READ)
def test_every_good_file_is_read_whole(shared, name):
    path = shared / "data" / name
    trajectory = TRAJECTORY_OF.get(path.name)
    molecule = read_molecule(path, path.parent / trajectory if trajectory else None)
    assert (molecule.n_frames, molecule.n_atoms, molecule.n_residues) == READ[name]
    assert np.isfinite(molecule.xyz).all()
    assert set(molecule.element) <= {"C", "N", "O", "S", "H", "SE"}


def test_what_is_missing_is_said(shared, caplog):
    with caplog.at_level(logging.INFO, "sparsurf"):
        read_molecule(shared / "data" / "structures" / "1BD2.pdb.gz")
        read_molecule(shared / "data" / "structures" / "2beg_fibril5chains.pdb")
        trajectories = shared / "data" / "trajectories"
        read_molecule(trajectories / "adk.psf", trajectories / "adk_dims.dcd", stride=10)
    for words in (
        "left out 39 HOH", "55 residues lack heavy atoms, the first is ARG A 17",
        "no coordinates for 17 residues of the sequence: 1 in chain B, 14 in chain D, 2 in chain E",
        "80 residues of the sequence", "its header announces 500 frames, 10 were read",
    ):  # fmt: skip
        assert words in caplog.text


def test_trajectory_and_topology_have_to_fit(shared):
    folder = shared / "data" / "trajectories"
    refused(folder / "tz2.parm7", "DPDP.nc has 332 atoms and .*tz2.parm7 has 223", folder / "DPDP.nc")
    refused(folder / "tz2.parm7", "DPDP.nc .*332 .*223", folder / "DPDP.nc", selection="name CA CB")
    refused(shared / "example" / "topology.pdb", "has 22 atoms and", folder / "ala2.h5")
    refused(folder / "tz2.parm7", "holds no coordinates: give the trajectory")
    assert read_molecule(folder / "tz2.parm7", folder / "tz2.nc").residue[[0, -1]].tolist() == ["1", "13"]
    refused(
        folder / "tz2.nc", "is a trajectory: give it as the trajectory, and its topology as the structure"
    )
    refused(folder / "tz2.parm7", "is not a trajectory by its extension", folder / "1vii_3frames.pdb")
    refused(folder / "tz2.parm7", "does not exist", folder / "none.xtc")
    refused(
        folder / "tz2.parm7", "is compressed, which is not supported for trajectories", folder / "none.xtc.gz"
    )


def test_trajectory_cut_short_is_refused(shared, tmp_path):
    topology = shared / "example" / "topology.pdb"
    content = (shared / "example" / "trajectory.xtc").read_bytes()
    for size in (0, 50, len(content) // 3):
        (tmp_path / "cut.xtc").write_bytes(content[:size])
        refused(topology, "cut.xtc cannot be read", tmp_path / "cut.xtc")


def test_nan_in_a_trajectory_is_refused(shared, tmp_path):
    topology = shared / "example" / "topology.pdb"
    frames = mdtraj.load(str(shared / "example" / "trajectory.xtc"), top=str(topology), stride=300)
    frames.xyz[2, 5, 1] = np.nan
    frames.save(str(tmp_path / "nan.dcd"))
    refused(topology, "not numbers .* in frame 2", tmp_path / "nan.dcd")


# --- made for the test ---------------------------------------------------------------------------------

REFUSED = {
    "no-atoms.pdb": ("REMARK nothing\n", "holds no atoms"),
    "empty.pdb": ("", "holds no atoms"),
    "Damaged.PDB": (GOOD.replace("   1.460", "   1x460", 1), "line 2 of .* no readable coordinates"),
    "stars.pdb": (GOOD.replace("   1.460", "********", 1), r"line 2 of .* coordinates \('\*{8}   0\.000   0\.000'\)"),
    "nan.pdb": (GOOD.replace("   1.460", "     nan", 1), "line 2 of .* no readable coordinates"),
    "short-line.pdb": (GOOD.replace("\n", "\n", 1)[:40] + "\n" + GOOD, "line 1 of .* is cut short"),
    "shifted.pdb": (GOOD.replace("A   1  ", "A   1 1", 1), "line 1 of .* not in the columns"),
    "keyword.pdb": (GOOD.replace("ATOM  ", "ATQM  ", 1), "line 1 of .* holds an atom but begins with 'ATQM"),
    "piece.pdb": (GOOD + "ATO\n", "holds an atom but begins with 'ATO"),
    "letter.pdb": (GOOD + "H", "holds an atom but begins with 'H"),
    "tab.pdb": (GOOD.replace("ATOM  ", "ATOM\t", 1), "line 1 of .* holds an atom but begins with 'ATOM"),
    "nameless.pdb": (GOOD.replace(" CA ", "    ", 1), "line 2 of .* not in the columns"),
    "number.pdb": (GOOD.replace("A   1 ", "A  1x ", 1), "line 1 of .* not in the columns"),
    "short-joined.pdb": (SHORT.replace("\n", "", 1), "line 1 of .* not in the columns"),
    "joined.pdb": (GOOD.replace("\n", "", 1), "line 1 of .* not in the columns"),
    "cut.pdb": (GOOD[:-24], "cut short: it stops in the middle"),
    "zeros.pdb": (GOOD + "\0", "damaged or not a text file"),
    "open-model.pdb": ("MODEL        1\n" + peptide(), "its last MODEL has no ENDMDL"),
    "no-end.pdb": (SEQUENCE + peptide(), "4 of the 9 residues .* SEQRES .* no END"),
    "connected-before.pdb": (SEQUENCE + "CONECT    1    2\n" + peptide(), "4 of the 9 residues"),
    "ca-only.pdb": ("".join(line + "\n" for line in GOOD.split("\n") if " CA " in line), "20% of the heavy atoms"),
    "backbone.pdb": (
        "".join(line + "\n" for line in peptide(["LEU"] * 4).split("\n") if line and " CB " not in line),
        "50% of the heavy atoms",
    ),
    "ions.pdb": (
        "".join(atom_line("NA  ", "NA", residue=str(i), place=(i, 0, 0), element="NA") for i in range(3)),
        "there is no protein; the file has chains A with 3 NA",
    ),
    "nine-ions.pdb": (
        "".join(atom_line("NA  ", f"I{i}", residue=str(i), place=(i, 0, 0), element="NA") for i in range(9)),
        r"with 1 I0, (1 I\d, ){6}1 I7\.$",
    ),
    "models.pdb": (
        f"MODEL        1\n{peptide()}ENDMDL\nMODEL        2\n{peptide(['ALA'] * 3)}ENDMDL\n",
        "models of different atoms .* 20 15.*model",
    ),
    "names.pdb": (
        f"MODEL        1\n{peptide()}ENDMDL\nMODEL        2\n{peptide(['SER'] * 4)}ENDMDL\n",
        "models of different atoms .* 20 20.*model",
    ),
    "ten-models.pdb": (
        "".join(f"MODEL {k}\n{peptide(['ALA'] * (3 + k % 2))}ENDMDL\n" for k in range(1, 11)),
        r"\(selected atoms: (20 15 ){4}20\)",
    ),
    "one-place.pdb": (re.sub(r"(?m)^(.{30}).{24}", r"\1   0.000   0.000   0.000", peptide()), "all atoms at one position"),
    "is-cif.pdb": (CIF, "is an mmCIF file by its content: rename"),
    "is-pdb.cif": (GOOD, "not a readable mmCIF"),
    "no-loop.cif": ("data_x\n_cell.length_a 10\n", "holds no atoms"),
    "nan.cif": (CIF.replace("3.0", "nan", 1), "not numbers"),
    "unknown.cif": (CIF.replace("3.0", "?", 1), "not numbers"),
    "cut.cif": (CIF[:-8], "not a readable mmCIF file .*Wrong number of values"),
    "no-x.cif": (CIF.replace("Cartn_y", "Cartn_q"), "has no y in its _atom_site"),
    "number.cif": (CIF.replace(" A 1 ", " A one ", 1), "residue numbered 'one'"),
    "lost-chain.cif": (
        "data_x\nloop_\n_struct_asym.id\nA\nB\n" + CIF[7:-1].replace("auth_asym_id", "label_asym_id"),
        "cut short: it has no atoms for B",
    ),
    "notes.txt": (GOOD, "not a structure by its extension: give one of .pdb, .ent, .cif"),
    "is-not.pdb.gz": (GOOD, "is named .gz but is not gzip"),
    "broken.gro": ("title\n 2\n    1ALA     CA    1   0.1\n", "line 3 has no three coordinates"),
    "count.gro": ("title\nx\n", "line 2 is not the number of atoms"),
    "few.gro": (f"title\n 2\n{GRO_LINE}", "has 1 of 2 atoms"),
    "no-box.gro": (f"title\n 1\n{GRO_LINE}1.0 1.0\n", "line 4 is not a box of 3 or 9 numbers"),
    "empty.psf": ("", "cannot be read"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_refused_in_one_sentence(tmp_path, name):
    content, words = REFUSED[name]
    refused(write(tmp_path / name, content), f"(?i){words}")


def test_path_that_is_no_file(tmp_path):
    refused(tmp_path / "none.pdb", "does not exist")
    (tmp_path / "folder.pdb").mkdir()
    refused(tmp_path / "folder.pdb", "is a folder")


def test_gzip_cut_short(tmp_path):
    (tmp_path / "a.pdb.gz").write_bytes(gzip.compress(GOOD.encode())[:-9])
    refused(tmp_path / "a.pdb.gz", "cut short or damaged inside its gzip")


SEVERAL = peptide(["ALA"] * 3)
FINE = {
    "crlf.pdb": (GOOD.replace("\n", "\r\n"), 4),
    "mac.pdb": (GOOD.replace("\n", "\r"), 4),
    "name.ent": (GOOD, 4),
    "UPPER.PDB": (GOOD, 4),
    "no-newline.pdb": (GOOD[:-1], 4),
    "rstripped.pdb": ("\n".join(line.rstrip() for line in peptide().split("\n")), 4),
    "no-end.pdb": (peptide(), 4),
    "no-end-no-newline.pdb": (peptide()[:-1], 4),
    "disordered.pdb": (SEQUENCE + GOOD, 4),
    "connected.pdb": (SEQUENCE + peptide() + "CONECT10001    2\n", 4),
    "master.pdb": (SEQUENCE + peptide() + "MASTER        0    0\n", 4),
    "one-atom.pdb": (atom_line(), 1),
    "one-residue.pdb": (peptide(["ALA"]), 1),
    "no-chain.pdb": (peptide(chain=" "), 4),
    "short-lines.pdb": (SHORT, 4),
    "shorter-lines.pdb": ("\n".join([*GOOD.split("\n")[:18], *SHORT.split("\n")[18:20]]), 4),
    "words.pdb": (f"{'AUTHOR':30}   1.000 and.so  and.so  \n" + GOOD, 4),
    "no-element.pdb": ("\n".join(line[:66] for line in GOOD.split("\n")), 4),
    "hybrid36.pdb": (SEVERAL.replace("   1    ", "A000    ", 5), 3),
    "five-digits.pdb": (SEVERAL.replace("A   1    ", "A10001   ", 5), 3),
    "glycan.pdb": (GOOD[:-4] + peptide(["NAG"], first=9, origin=(0, 0, 9)).replace("ATOM  ", "HETATM"), 4),
    "heavy-water.pdb": (GOOD[:-4] + atom_line("D1", "DOD", residue="9", record="HETATM", element="D"), 4),
    "latin.pdb": ("REMARK Ångström naïve\n" + GOOD, 4),
    "remark.pdb": (peptide().replace("ATOM  ", "REMARK") + peptide().replace("ATOM  ", "SIGATM") + GOOD, 4),
    "plain.cif": (CIF, 1),
    "uncertain.cif": (CIF.replace("3.0", "3.0(2)"), 1),
    "a name with blanks, Å and ü.pdb": (GOOD, 4),
}


@pytest.mark.parametrize("name", FINE)
def test_unusual_but_fine(tmp_path, name):
    content, residues = FINE[name]
    molecule = read_molecule(write(tmp_path / name, content))
    assert molecule.n_residues == residues
    assert set(molecule.element) <= {"C", "N", "O"}


def test_numbers_of_a_gro_file_may_touch(tmp_path):
    atoms = [line.split() for line in peptide().splitlines()]
    places = np.array([line[6:9] for line in atoms], float) - 2000  # Å: eight characters each, in nm
    rows = "".join(
        f"{line[5]:>5s}ALA  {line[2]:>5s}{k:5d}" + "".join(f"{x / 10:8.3f}" for x in place) + "\n"
        for k, (line, place) in enumerate(zip(atoms, places, strict=True), 1)
    )
    path = write(tmp_path / "a.gro", f"touching\n{len(atoms)}\n{rows}   0.00000   0.00000   0.00000\n")
    assert rows.count("-200.000-200.000-200.000") == 1
    molecule = read_molecule(path)
    np.testing.assert_allclose(molecule.xyz[0], places, atol=0.006)
    assert list(dict.fromkeys(molecule.residue.tolist())) == ["1", "2", "3", "4"]


def test_deuterium_is_hydrogen(tmp_path):
    path = write(tmp_path / "a.pdb", GOOD[:-4] + atom_line("D", residue="4", place=(1, 1, 1), element="D"))
    assert read_molecule(path).n_atoms == 21
    assert read_molecule(path, hydrogens="remove").n_atoms == 20


def test_read_only_folder(tmp_path):
    path = write(tmp_path / "a.pdb", GOOD)
    path.chmod(0o444)
    tmp_path.chmod(0o555)
    try:
        assert read_molecule(path).n_atoms == 20
    finally:
        tmp_path.chmod(0o755)


# --- damage at random ----------------------------------------------------------------------------------


@given(st.binary(max_size=300), st.sampled_from([".pdb", ".cif", ".pdb.gz", ".ent", ".gro", ".psf", ".h5"]))
@settings(max_examples=40, deadline=None)
def test_any_bytes_are_read_or_refused(tmp_path_factory, content, extension):
    path = tmp_path_factory.mktemp("fuzz") / f"a{extension}"
    path.write_bytes(content)
    with pytest.raises(InputError):
        read_molecule(path)


STRUCTURES = (
    "structures/ala3_3res.pdb", "structures/1a8o_mse.pdb", "structures/1a8o_mse.cif", "structures/1fas.cif",
    "structures/7etn_tiny.cif.gz", "structures/3nzmA_negres.pdb.gz", "structures/1hvr_dimer_ligand_CSO.pdb",
    "structures/cobrotoxin_gmx_nochain.pdb", "structures/1BD2.cif.gz", "trajectories/1vii_3frames.pdb",
)  # fmt: skip
MADE = ("xtc", "trr", "dcd", "h5", "gro")
FUZZED = [  # (topology or structure, trajectory, which of the two is damaged); those of a process of their own less
    *((f"data/{name}", None, 0) for name in STRUCTURES * 2),
    ("data/trajectories/ala2.h5", None, 0),
    ("data/trajectories/tz2.parm7", "data/trajectories/tz2.nc", 0),
    ("data/trajectories/tz2.parm7", "data/trajectories/tz2.nc", 1),
    ("data/trajectories/adk.psf", "data/trajectories/adk_dims.dcd", 0),
    *(("example/topology.pdb", f"made/twin.{extension}", 1) for extension in MADE),
]


def damaged(content, rng):
    """One random fault of the kinds that disks, editors and killed copies make."""
    data = bytearray(content)
    start, length = rng.randrange(len(data)), rng.choice([1, 4, 16, 81, 1000])
    fault = rng.choice(["cut", "flip", "delete", "repeat", "insert", "zero", "header", "lines", "digits"])
    if fault == "cut":
        del data[start:]
    elif fault == "flip":
        for _ in range(rng.choice([1, 5, 50])):
            data[rng.randrange(len(data))] = rng.randrange(256)
    elif fault == "delete":
        del data[start : start + length]
    elif fault == "repeat":
        data[start:start] = data[start : start + length]
    elif fault == "insert":
        data[start:start] = rng.randbytes(length)
    elif fault == "zero":
        data[start : start + length] = bytes(len(data[start : start + length]))
    elif fault == "header":  # where binary formats keep their counts
        data[start % 400 : start % 400 + 4] = rng.choice(
            [b"\xff\xff\xff\x7f", bytes(4), b"\x7f\xff\xff\xff", b"9999"]
        )
    elif fault == "lines":
        lines = bytes(data).split(b"\n")
        first, second = rng.randrange(len(lines)), rng.randrange(len(lines))
        lines[first], lines[second] = lines[second], lines[first][: rng.choice([10, 50, 1000])]
        data = b"\n".join(lines)
    else:
        digits = [at for at in range(start, min(start + 3000, len(data))) if chr(data[at]).isdigit()]
        for at in digits[: rng.choice([1, 3])]:
            data[at] = rng.choice(b"0123456789-.x *")
    return bytes(data)


def read_in_a_loop(connection):
    """Body of the process that reads: a crash of a foreign parser shows as its death."""
    logging.disable()
    while True:
        try:
            read_molecule(*connection.recv())
            connection.send("read")
        except InputError:
            connection.send("refused")
        except EOFError:
            return
        except BaseException as error:
            connection.send(f"{type(error).__name__}: {error}")


@pytest.fixture
def reader():
    """Reads paths in another process; 'died' after a crash of it, 'hangs' after a minute."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=read_in_a_loop, args=(theirs,), daemon=True)
    process.start()
    theirs.close()

    def read(*paths):
        ours.send(paths)
        try:
            return ours.recv() if ours.poll(60) else "hangs"
        except EOFError:
            return "died"

    yield read
    ours.close()
    process.join(5)
    process.kill()


def test_damaged_files_are_read_or_refused(shared, tmp_path, reader):
    """Never a crash, a hang, or an error that is not a sentence."""
    (tmp_path / "made").mkdir()
    topology = shared / "example" / "topology.pdb"
    frames = mdtraj.load(str(shared / "example" / "trajectory.xtc"), top=str(topology), stride=100)
    for extension in MADE:
        frames.save(str(tmp_path / "made" / f"twin.{extension}"))
    rng = random.Random(20260101)
    outcomes = []
    for case in range(int(os.environ.get("SPARSURF_FUZZ_CASES", "40"))):
        *names, which = FUZZED[case % len(FUZZED)]
        roots = [tmp_path if name and name.startswith("made") else shared for name in names]
        paths = [root / name if name else None for root, name in zip(roots, names, strict=True)]
        victim = tmp_path / f"{case}{''.join(paths[which].suffixes)}"
        victim.write_bytes(damaged(paths[which].read_bytes(), rng))
        paths[which] = victim
        outcomes.append(reader(*paths))
        assert outcomes[-1] in ("read", "refused"), f"case {case}, {names[which]}: {outcomes[-1]}"
        victim.unlink()
    print({each: outcomes.count(each) for each in ("read", "refused")})
    assert outcomes.count("refused") > len(outcomes) / 4
