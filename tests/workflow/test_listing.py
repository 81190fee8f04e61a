"""Proteins from a table or a folder, and from the network."""

import hashlib
import http.server
import json
import threading
import time
from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conftest import ROOT
from sparsurf.errors import InputError
from sparsurf.molecules.formats import SELF_CONTAINED, STRUCTURES, TOPOLOGIES, TRAJECTORIES
from sparsurf.workflow.config import check_config
from sparsurf.workflow.download import fetch, file_name, variable
from sparsurf.workflow.listing import from_folder, from_table

TOPOLOGY = ROOT / "data" / "tdp43" / "topology.pdb"


def test_a_table_becomes_proteins_with_files_beside_it(tmp_path):
    (tmp_path / "a.pdb").write_bytes(TOPOLOGY.read_bytes())
    table = tmp_path / "proteins.csv"
    table.write_text(
        "name,structure,chains,model,ligands,sampling\none,a.pdb,A B,2,TRUE,\ntwo,a.pdb,,,HEM XK2,false\n"
    )
    proteins = from_table(str(table))
    one = {"structure": str(tmp_path / "a.pdb"), "chains": ["A", "B"], "model": 2, "ligands": True}
    assert proteins["one"] == one
    assert proteins["two"] == {
        "structure": str(tmp_path / "a.pdb"),
        "ligands": ["HEM", "XK2"],
        "sampling": False,
    }
    assert set(check_config({"proteins": str(table)})["proteins"]) == {"one", "two"}


@pytest.mark.parametrize(
    "text, words",
    [
        ("", "needs a header with the column name"),
        ("structure\na.pdb\n", "needs a header with the column name"),
        ("name;structure\nx;a.pdb\n", "separated by commas"),
        ("name,structure, structure\nx,a.pdb,b.pdb\n", "has the column 'structure' twice"),
        ("name,structure\nx,a.pdb\nx,b.pdb\n", "line 3 of .* earlier line"),
        ("name,structure\n,a.pdb\n", "line 2 of .* has no name"),
        ("name,structure\n\n\nx,a.pdb\n\n,b.pdb\n", "line 6 of .* has no name"),
        ("name,structure\nx,a.pdb,more\n", "line 2 of .* number of cells"),
        ('name,structure\nx,"a.pdb\n', "is not a CSV table"),
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
    names = "x.pdb x.cif.gz x.pdb.gz y.pdb y_long.xtc z.dms notes.txt .hidden.pdb αβ γ.pdb t.dcd"
    for name in names.split():
        (tmp_path / name).write_text("")
    proteins = from_folder(str(tmp_path))
    assert proteins == {
        "x_pdb": {"structure": str(tmp_path / "x.pdb")},
        "x_pdb_gz": {"structure": str(tmp_path / "x.pdb.gz")},
        "x_cif_gz": {"structure": str(tmp_path / "x.cif.gz")},
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


@pytest.mark.parametrize("ending", [*TOPOLOGIES, *SELF_CONTAINED, *STRUCTURES])
def test_whatever_can_be_read_is_listed_with_its_trajectory(tmp_path, ending):
    for name in (f"x{ending}", *(f"x_{k}{other}" for k, other in enumerate(TRAJECTORIES))):
        (tmp_path / name).write_text("")
    proteins = from_folder(str(tmp_path))
    assert sorted(proteins) == sorted(f"x_{k}" for k in range(len(TRAJECTORIES)))
    assert {protein["structure"] for protein in proteins.values()} == {str(tmp_path / f"x{ending}")}


def test_half_a_protein_is_left_out_by_name(tmp_path, caplog):
    for name in ("topol.top", "topol_run.xtc", "alone.psf", "good.pdb"):
        (tmp_path / name).write_text("")
    assert list(from_folder(str(tmp_path))) == ["good"]
    said = [record.getMessage() for record in caplog.records]
    assert [sentence.split(" is left out: ")[0] for sentence in said] == [
        str(tmp_path / name) for name in ("alone.psf", "topol_run.xtc")
    ]
    (tmp_path / "good.pdb").unlink()
    with pytest.raises(InputError, match="holds no protein"):
        from_folder(str(tmp_path))


@given(st.lists(st.text(min_size=1, max_size=12), min_size=1, max_size=6, unique=True))
@settings(max_examples=50, deadline=None)
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


def test_an_empty_or_missing_folder_is_a_sentence(tmp_path):
    with pytest.raises(InputError, match="holds no protein: none of its files ends in one of"):
        from_folder(str(tmp_path))
    with pytest.raises(InputError, match="there is no such folder"):
        check_config({"proteins": {"folder": str(tmp_path / "none")}})


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


def test_the_size_on_record_is_that_of_what_came(server, tmp_path):
    sha256 = hashlib.sha256(b"ATOM ").hexdigest()
    fetch(f"{server}/streamed", sha256, tmp_path / "a.pdb", tmp_path / "a.json", "x")
    assert json.loads((tmp_path / "a.json").read_text())["bytes"] == 5


@pytest.mark.parametrize(
    ("url", "sha256"),
    [
        ("file:///etc/passwd", "0" * 64),
        ("http://127.0.0.1:9/a.pdb", None),
        ("https:///a.pdb", None),
        ("https://127.0.0.1:99999/a.pdb", None),
        ("https://127.0.0.1:0/a.pdb", None),
    ],
)
def test_only_the_web_is_fetched_and_only_what_is_safe(tmp_path, url, sha256):
    """Refused before anything is fetched: by the config, and by the job itself."""
    with pytest.raises(InputError, match="only complete https:// URLs"):
        fetch(url, sha256, tmp_path / "a", tmp_path / "b", "A1")
    with pytest.raises(InputError, match=r"proteins\.A1\.url"):
        check_config({"proteins": {"A1": {"url": url} | ({"sha256": sha256} if sha256 else {})}})
    check_config({"proteins": {"A1": {"url": "http://x.org/a.pdb", "sha256": "0" * 64}}})


def test_a_redirect_to_where_one_may_fetch_is_followed(server, tmp_path):
    sha256 = hashlib.sha256(TOPOLOGY.read_bytes()).hexdigest()
    fetch(f"{server}/to/{server}/my%20file.pdb", sha256, tmp_path / "a.pdb", tmp_path / "b", "A1")
    assert (tmp_path / "a.pdb").read_bytes() == TOPOLOGY.read_bytes()


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
        ("", "SPARSURF_A1"),  # the variable that names a file in its place
    ],
)
def test_what_cannot_be_fetched_is_refused_and_not_kept(server, tmp_path, monkeypatch, path, words):
    monkeypatch.setattr("sparsurf.workflow.download.MAX_SECONDS", 0.5)
    monkeypatch.setattr("sparsurf.workflow.download.MOST", 200_000)
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
    assert variable("my-protein.1") == "SPARSURF_MY_PROTEIN_1"


def test_a_local_copy_replaces_a_fetched_one(monkeypatch):
    config = {"proteins": {"A1": {"url": "https://x.org/a.pdb", "sha256": "0" * 64, "chains": ["A"]}}}
    monkeypatch.setenv("SPARSURF_A1", str(TOPOLOGY))
    assert check_config(config)["proteins"]["A1"] == {"structure": str(TOPOLOGY), "chains": ["A"]}
    monkeypatch.delenv("SPARSURF_A1")
    assert "url" in check_config(config)["proteins"]["A1"]


def test_names_that_differ_in_case_only_are_kept_apart(tmp_path):
    for name in ("Protein.pdb", "γ.pdb", "A.pdb", "a.cif"):  # no letter of the second can name a folder
        (tmp_path / name).write_text("")
    assert set(from_folder(str(tmp_path))) == {"Protein", "protein_", "A_pdb", "a_cif"}


def test_a_trajectory_and_its_topology_are_one_protein_of_their_name(tmp_path):
    for name in ("x.gro", "x.xtc"):
        (tmp_path / name).write_text("")
    assert list(from_folder(str(tmp_path))) == ["x"]
