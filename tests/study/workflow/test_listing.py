"""Proteins and pairs from a table, from a folder or from the network; which of them have a single form."""

import gzip
import hashlib
import http.server
import json
import subprocess
import sys
import threading
import time
from contextlib import suppress

import gemmi
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conftest import ROOT
from peptides import peptide
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf_study.config.check import Protein, check_config
from sparsurf_study.config.conformations import file_has_one_model, has_one_model, without_zeros
from sparsurf_study.config.download import fetch, file_name, variable
from sparsurf_study.config.listing import from_folder, from_table, pairs_from_folder, pairs_from_table

TOPOLOGY = ROOT / "data" / "tdp43" / "topology.pdb"


def test_a_table_becomes_proteins_with_files_beside_it(tmp_path):
    (tmp_path / "a.pdb").write_bytes(TOPOLOGY.read_bytes())
    table = tmp_path / "proteins.csv"
    table.write_text(
        "name,structure,chains,model,ligands,sampling,assembly,plddt,trajectory\n"
        "two,a.pdb,,,HEM XK2,false,,,t.xtc\none,a.pdb,A B,2,TRUE,,True,70,\n"
        ",,,,,,,,\n, ,,,,,,,,,\n,\n"  # as a spreadsheet writes below a table
    )
    (tmp_path / "t.xtc").write_text("")
    proteins = from_table(str(table))
    one = {"structure": str(tmp_path / "a.pdb"), "chains": ["A", "B"], "model": 2, "ligands": True}
    assert proteins["one"] == one | {"assembly": True, "plddt": 70}
    assert proteins["two"] == {
        "structure": str(tmp_path / "a.pdb"),
        "trajectory": str(tmp_path / "t.xtc"),
        "ligands": ["HEM", "XK2"],
        "sampling": False,
    }
    assert [*check_config({"proteins": str(table)})["proteins"]] == ["two", "one"]  # as in the table


@pytest.mark.parametrize(
    "text, words",
    [
        ("", "column name"),
        ("structure\na.pdb\n", "column name"),
        ("name;structure\nx;a.pdb\n", "separated by commas"),
        ("name,structure, structure\nx,a.pdb,b.pdb\n", "column 'structure' twice"),
        ("name,structure\nx,a.pdb\nx,b.pdb\n", "line 3 of .* earlier line"),
        ("name,structure\n,a.pdb\n", "line 2 of .* has no name"),
        ("name,structure\n,\n", "least one row"),
        ("name,structure\n,\nx,a.pdb\n", "line 2 of .* has no name"),
        ("name,structure\n\n\nx,a.pdb\n\n,b.pdb\n", "line 6 of .* has no name"),
        ("name,structure\nx,a.pdb,more\n", "line 2 of .* number of cells"),
        ('name,structure\nx,"a.pdb\n', "CSV table"),
        ("name,structure\nx,a.pdb\n".encode("utf-16"), "UTF-16"),
        ("name,structure\nx,a.pdb\n".encode("utf-16-le"), "contains null bytes"),
    ],
)
def test_a_bad_table_is_a_sentence(tmp_path, text, words):
    table = tmp_path / "proteins.csv"
    table.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError, match=words):
        from_table(str(table))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_a_table_of_any_program_is_read(tmp_path, encoding, end):
    text = 'name, structure ,residues\nx,ä.pdb,"1-3,\n5"\n\ny,b.pdb,\n'.replace("\n", end)
    (tmp_path / "proteins.csv").write_bytes(text.encode(encoding))
    assert from_table(str(tmp_path / "proteins.csv")) == {
        "x": {"structure": str(tmp_path / "ä.pdb"), "residues": "1-3,\n5"},
        "y": {"structure": str(tmp_path / "b.pdb")},
    }


def test_a_folder_becomes_proteins(tmp_path):
    names = "x.pdb x.cif.gz x.pdb.gz w.pdb W.cif y.pdb y_long.xtc z.dms notes.txt .hidden.pdb αβ γ.pdb t.dcd"
    for name in names.split():
        (tmp_path / name).write_text("")
    (tmp_path / "folder.pdb").mkdir()
    proteins = from_folder(str(tmp_path))
    assert proteins == {
        "x_pdb": {"structure": str(tmp_path / "x.pdb")},
        "x_pdb_gz": {"structure": str(tmp_path / "x.pdb.gz")},
        "x_cif_gz": {"structure": str(tmp_path / "x.cif.gz")},
        "w_pdb": {"structure": str(tmp_path / "w.pdb")},
        "W_cif": {"structure": str(tmp_path / "W.cif")},
        "y_long": {"structure": str(tmp_path / "y.pdb"), "trajectory": str(tmp_path / "y_long.xtc")},
        "z": {"surface": str(tmp_path / "z.dms")},
        "protein": {"structure": str(tmp_path / "γ.pdb")},
    }


def test_a_trajectory_belongs_to_the_longest_name_that_it_begins_with(tmp_path):
    for name in ("y.pdb", "y_long.pdb", "y_long_1.xtc", "y_other.xtc", "run1.gro", "run10.xtc", "run1_a.dcd"):
        (tmp_path / name).write_text("")
    # run10.xtc is not the first run's: it is left out
    own = {"structure": "y_long.pdb", "trajectory": "y_long_1.xtc"}
    expected = {
        "run1_a": {"structure": "run1.gro", "trajectory": "run1_a.dcd"},
        "y_long_1": own,
        "y_other": {"structure": "y.pdb", "trajectory": "y_other.xtc"},
    }
    assert from_folder(str(tmp_path)) == {
        name: {key: str(tmp_path / file) for key, file in entry.items()} for name, entry in expected.items()
    }


def test_half_a_protein_is_left_out_by_name(tmp_path, caplog):
    for name in ("topol.top", "topol_run.xtc", "alone.psf", "good.pdb"):
        (tmp_path / name).write_text("")
    assert list(from_folder(str(tmp_path))) == ["good"]
    said = [record.getMessage() for record in caplog.records]
    lacking = {"alone.psf": "trajectory", "topol_run.xtc": "topology or structure whose name it begins with"}
    assert said == [
        f"{tmp_path / file} is left out: its folder has no {what}." for file, what in lacking.items()
    ]
    (tmp_path / "good.pdb").unlink()
    with pytest.raises(InputError, match="holds no protein"):
        from_folder(str(tmp_path))


def test_structures_that_a_folder_leaves_out_are_told(tmp_path, caplog):
    (tmp_path / "below").mkdir()
    for name in ("1abc.pdb1", "old.brk", "model.txt", "below/x.pdb"):
        (tmp_path / name).write_text(peptide())
    assert [*from_folder(str(tmp_path))] == ["1abc", "old"]
    assert "left out 2 files" in caplog.text and "model.txt" in caplog.text


@given(st.lists(st.text(min_size=1, max_size=12), min_size=1, max_size=6, unique=True))
@settings(max_examples=50)
def test_names_of_files_never_leave_the_results(tmp_path_factory, stems):
    folder = tmp_path_factory.mktemp("files")
    for stem in stems:
        if "/" not in stem and "\0" not in stem:
            try:
                (folder / f"{stem}.pdb").write_text("")
            except (OSError, UnicodeError):
                continue
    try:
        names = from_folder(str(folder))
    except InputError:
        return
    assert len(names) == len(list(folder.glob("[!.]*.pdb")))
    for name in names:
        assert "/" not in name and not name.startswith((".", "-")) and name


@pytest.fixture
def server(tmp_path):
    """A web server on this machine that serves one structure."""
    (tmp_path / "served").mkdir()
    (tmp_path / "served" / "my file.pdb").write_bytes(TOPOLOGY.read_bytes())

    class Handler(http.server.SimpleHTTPRequestHandler):
        def __init__(self, *args):
            super().__init__(*args, directory=tmp_path / "served")

        def log_message(self, *args):
            pass

        def do_GET(self):
            if self.path.startswith("/to/"):
                self.send_response(302)
                self.send_header("Location", self.path.removeprefix("/to/"))
                self.end_headers()
            elif self.path == "/cut":
                self.send_response(200)
                self.send_header("Content-Length", "9")
                self.end_headers()
                self.wfile.write(b"ATOM ")
            elif self.path == "/streamed":  # by a server that does not know its length before
                self.send_response(200)
                self.end_headers()
                self.wfile.write(b"ATOM ")
            elif self.path.startswith("/dripped"):  # its headers, or its bytes
                answer = b"HTTP/1.0 200 OK\r\n" + b"\r\n" * (self.path == "/dripped_bytes")
                with suppress(OSError):  # nobody listens any more
                    for k in range(40):
                        self.wfile.write(answer if k == 0 else b"A")
                        time.sleep(0.05)
            else:
                super().do_GET()

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as serving:
        threading.Thread(target=serving.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{serving.server_address[1]}"
        serving.shutdown()


def test_a_fetched_file_is_verified_and_recorded(server, tmp_path):
    url, sha256 = f"{server}/my%20file.pdb", hashlib.sha256(TOPOLOGY.read_bytes()).hexdigest()
    fetch(url, sha256, tmp_path / "a.pdb", tmp_path / "a.json", "x")
    assert (tmp_path / "a.pdb").read_bytes() == TOPOLOGY.read_bytes()
    assert json.loads((tmp_path / "a.json").read_text()) == {
        "url": url,
        "bytes": TOPOLOGY.stat().st_size,
        "sha256": sha256,
    }
    fetch(url, sha256.upper(), tmp_path / "b.pdb", tmp_path / "b.json", "x")  # as other programs write it
    assert (tmp_path / "b.json").read_text() == (tmp_path / "a.json").read_text()
    fetch(
        f"{server}/streamed", hashlib.sha256(b"ATOM ").hexdigest(), tmp_path / "c", tmp_path / "c.json", "x"
    )
    assert (tmp_path / "c").read_bytes() == b"ATOM "


@pytest.mark.parametrize(
    ("url", "sha256"),
    [
        ("file:///etc/passwd", "0" * 64),
        ("http://127.0.0.1:9/a.pdb", None),
        ("https:///a.pdb", None),
        ("https://127.0.0.1:99999/a.pdb", None),
        ("https://127.0.0.1:0/a.pdb", None),
        ("https://me:secret@127.0.0.1/a.pdb", None),
        ("http://:secret@127.0.0.1/a.pdb", "0" * 64),
    ],
)
def test_only_the_web_is_fetched_and_only_what_is_safe(tmp_path, url, sha256):
    """Refused before anything is fetched: by the config, and by the job itself."""
    with pytest.raises(InputError, match="complete https:// URLs") as by_job:
        fetch(url, sha256, tmp_path / "a", tmp_path / "b", "A1")
    with pytest.raises(InputError, match=r"proteins\.A1\.url") as by_config:
        check_config({"proteins": {"A1": {"url": url} | ({"sha256": sha256} if sha256 else {})}})
    assert "secret" not in f"{by_job.value}{by_config.value}" and not [*tmp_path.iterdir()]
    check_config({"proteins": {"A1": {"url": "http://x.org/a.pdb", "sha256": "0" * 64}}})


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("my%20file.pdb", r"sha256 .*, not 0{64}"),
        ("large.pdb", "larger than 0 MB"),
        ("none.pdb", "File not found"),
        ("cut", "5 of 9 bytes"),
        ("dripped_headers", "more than 0.5 s"),
        ("dripped_bytes", "more than 0.5 s"),
        ("to/file:///etc/passwd", "file:.*not allowed"),
        ("to/ftp://127.0.0.1/a.pdb", "ftp:.*only complete https"),
        ("to/http://me:secret@127.0.0.1/a.pdb", r"leads to http://\*\*\*@127\.0\.0\.1/a\.pdb"),
        ("", "SPARSURF_A1"),  # the variable that names a file in its place
    ],
)
def test_what_cannot_be_fetched_is_refused_and_not_kept(server, tmp_path, monkeypatch, path, words):
    monkeypatch.setattr("sparsurf_study.config.download.MAX_SECONDS", 0.5)
    monkeypatch.setattr("sparsurf_study.config.download.MOST", 200_000)
    (tmp_path / "served" / "large.pdb").write_bytes(bytes(200_001))
    url = f"{server}/{path}" if path else "http://127.0.0.1:9/a.pdb"
    with pytest.raises(InputError, match=rf"A1.*{words}"):
        fetch(url, "0" * 64, tmp_path / "a", tmp_path / "b", "A1")
    assert not (tmp_path / "a").exists()


def test_names_and_variables():
    assert file_name("https://x.org/a/pdb%20files/208/cluster1.pdb") == "cluster1.pdb"
    assert file_name("https://x.org/..%2f..%2fpasswd") == "_2f.._2fpasswd"
    assert file_name("https://x.org/.hidden.pdb") == "hidden.pdb"
    assert file_name("https://x.org/") == "structure.pdb"
    assert file_name(f"https://x.org/{'a' * 200}.pdb?x=1") == f"{'a' * 116}.pdb"  # of 120 characters
    assert file_name(f"https://x.org/b.{'a' * 115}.pdb") == f"{'a' * 115}.pdb"
    assert variable("my-protein.1") == "SPARSURF_MY_PROTEIN_1"


@pytest.fixture
def folder(tmp_path):
    """A complex, as one file and as two."""
    (folder := tmp_path / "pairs").mkdir()
    for name in ("both", "both_r", "both_l"):
        (folder / f"{name}.pdb").write_text("")
    return folder


def test_pairs_come_from_a_table_or_a_folder(folder):
    head = "name,first,second,complex,chains_1,chains_2\n"
    (table := folder / "pairs.csv").write_text(
        f"{head} two ,,,both.pdb, H L ,A\none,both_r.pdb,both_l.pdb,,,\n,,,,,\n"
    )
    found = pairs_from_table(str(table))
    assert found["one"] == {"files": [str(folder / "both_r.pdb"), str(folder / "both_l.pdb")]}
    assert found["two"] == {"complex": str(folder / "both.pdb"), "chains": [["H", "L"], ["A"]]}
    assert pairs_from_folder(str(folder)) == {"both": found["one"]}
    assert [*check_config({"pairs": str(table)})["pairs"]] == ["two", "one"]  # as in the table
    assert set(check_config({"pairs": {"folder": str(folder)}})["pairs"]) == {"both"}


@pytest.mark.parametrize("key", ["pairs", "proteins"])
def test_a_folder_stands_alone(folder, key):
    with pytest.raises(InputError, match=f"{key}.folder cannot stand next to other keys .mine."):
        check_config({key: {"folder": str(folder), "mine": {"files": ["a.pdb", "b.pdb"]}}})


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name,first\na,b\n", "line 2 of"),
        ("first,second\na,b\n", "either first"),
        ("name,first,second\n", "least one row"),
        (
            "name,complex,chains_1,chains_2,first,second\na,x.pdb,A,B,1.pdb,\n",
            "line 2 of .* needs name and either",
        ),
    ],
)
def test_a_wrong_table_of_pairs_is_refused(tmp_path, text, words):
    (path := tmp_path / "t.csv").write_text(text)
    with pytest.raises(InputError, match=words):
        pairs_from_table(str(path))
    with pytest.raises(InputError, match="holds no two structures"):
        pairs_from_folder(str(tmp_path))


def test_pairs_of_a_folder_are_kept_apart_and_what_is_left_out_is_named(tmp_path, caplog):
    pairs = {"x_y": ("x y_r", "x y_l"), "x_y_": ("x+y_r", "x+y_l"), "B": ("B_1", "B_2"), "b_": ("b_r", "b_l")}
    for name in [*sum(pairs.values(), ()), "alone_r", "whole", "._b_r", "._b_l"]:
        (tmp_path / f"{name}.pdb").write_text("")
    (tmp_path / "notes_r.txt").write_text("")
    found = pairs_from_folder(str(tmp_path))
    expected = {name: [str(tmp_path / f"{file}.pdb") for file in both] for name, both in pairs.items()}
    assert {name: pair["files"] for name, pair in found.items()} == expected
    assert [record.getMessage().split(" (")[0] for record in caplog.records] == [
        f"{tmp_path / name} is left out: its folder has no partner" for name in ("alone_r.pdb", "whole.pdb")
    ]


MODEL = "MODEL     {}\n" + peptide() + "ENDMDL\n"


@pytest.mark.parametrize(
    ("content", "single"),
    [
        (peptide() + "END\n", True),
        (MODEL.format(1) + "END\n", True),
        (MODEL.format(1) + MODEL.format(2) + "END\n", False),
        ((MODEL.format(1) + MODEL.format(2)).replace("ENDMDL\n", ""), False),
        (peptide() + "END\n" + peptide() + "END\n", False),
        (peptide(), True),
    ],
)
def test_models_of_a_file_are_counted_packed_or_not(tmp_path, content, single):
    (tmp_path / "plain.pdb").write_text(content)
    (tmp_path / "packed.pdb.gz").write_bytes(gzip.compress(content.encode()))
    for name in ("plain.pdb", "packed.pdb.gz"):
        assert file_has_one_model(str(tmp_path / name)) == single
        assert (read_molecule(tmp_path / name).n_frames == 1) == single


def test_a_file_that_must_be_looked_at_more_closely_has_no_single_form_for_certain(tmp_path):
    """An mmCIF file whose model is no last column, or without atoms; an XYZ file."""
    head = "data_x\nloop_\n_atom_site.group_PDB\n_atom_site.id\n_atom_site.{}\n"
    rows = "ATOM 1 1\nATOM 2 1\n"
    for name, text in (
        ("a.cif", head.format("type_symbol") + rows),
        ("b.cif", head.format("pdbx_PDB_model_num")),
        ("c.cif", head.format("pdbx_PDB_model_num") + "ATOM 1 1\nATOM 2\n1\n"),
        ("d.xyz", "1\n\nC 0 0 0\n"),
    ):
        (tmp_path / name).write_text(text)
        assert not file_has_one_model(str(tmp_path / name)), name
    (tmp_path / "e.cif").write_text(head.format("pdbx_PDB_model_num") + rows)
    assert file_has_one_model(str(tmp_path / "e.cif"))


@pytest.mark.parametrize(
    ("name", "short"),
    [
        ("p/f0007", "p/f7"),
        ("p/c10", "p/c10"),
        ("p/f000", "p/f0"),
        ("f01/c02/x", "f01/c2/x"),
        ("p/c0a", "p/c0a"),
    ],
)
def test_a_conformation_goes_by_its_number_without_zeros(name, short):
    assert without_zeros(name) == short


def test_a_packed_file_that_is_torn_is_looked_at_by_the_rule_that_reads_it(tmp_path):
    (path := tmp_path / "torn.pdb.gz").write_bytes(gzip.compress(peptide().encode())[:-20])
    assert not file_has_one_model(str(path))


def test_a_packed_file_that_grows_beyond_the_bound_is_not_unpacked_by_the_plan(tmp_path):
    """256 MB of blanks in 250 kB, under a bound of 1 MB: the memory of the process hardly grows."""
    path = tmp_path / "bomb.pdb.gz"
    with gzip.open(path, "wb", compresslevel=9) as stream:
        for _ in range(256):
            stream.write(b" " * 2**20)
    code = (
        "import resource, sys; from sparsurf import files; from sparsurf_study.config.conformations import file_has_one_model\n"
        "files.MAX_UNPACKED_BYTES = 2**20; before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "print(file_has_one_model(sys.argv[1]), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50_000)"
    )
    done = subprocess.run([sys.executable, "-c", code, path], capture_output=True, text=True, check=True)
    assert done.stdout == "False True\n"


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize(("n_models", "single"), [(1, True), (2, False)])
def test_models_of_an_mmcif_file_are_counted_by_their_column(tmp_path, n_models, single, packed):
    structure = gemmi.read_pdb_string("".join(MODEL.format(k + 1) for k in range(n_models)) + "END\n")
    structure.setup_entities()
    content = structure.make_mmcif_document().as_string().encode()
    path = tmp_path / ("m.cif.gz" if packed else "m.cif")
    path.write_bytes(gzip.compress(content) if packed else content)
    assert file_has_one_model(str(path)) == single
    assert (read_molecule(path).n_frames == 1) == single


@pytest.mark.parametrize(
    ("entry", "single"),
    [
        ({}, True),
        ({"trajectory": "frames.xtc"}, False),
        ({"model": 1}, False),
        ({"simulate": {"ns": 1}}, False),
    ],
)
def test_a_protein_that_moves_has_no_single_form_for_certain(tmp_path, entry, single):
    (tmp_path / "a.pdb").write_text(peptide() + "END\n")
    assert has_one_model(Protein(structure=str(tmp_path / "a.pdb"), **entry)) == single


def test_a_simulation_holds_the_chosen_atoms_alone():
    keys = {"chains": ["A"], "residues": "2-4", "altloc": "B", "hydrogens": "remove"}
    plain, simulated = (Protein(structure="a.pdb", **keys, **more) for more in ({}, {"simulate": {}}))
    assert plain.molecule_options == plain.file_options == simulated.file_options == keys
    assert simulated.molecule_options == {"hydrogens": "remove"}
