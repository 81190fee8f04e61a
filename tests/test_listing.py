"""Proteins from a table or a folder, and from the network."""

import hashlib
import http.server
import json
import threading

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conftest import ROOT
from sparsurf import InputError
from sparsurf.config import check
from sparsurf.download import fetch, file_name, source, variable
from sparsurf.listing import from_folder, from_table

TOPOLOGY = ROOT / "data" / "tdp43" / "topology.pdb"


def test_a_table_becomes_proteins_with_files_beside_it(tmp_path):
    (tmp_path / "a.pdb").write_bytes(TOPOLOGY.read_bytes())
    table = tmp_path / "proteins.csv"
    table.write_text("name,structure,chains,model,ligands\none,a.pdb,A B,2,\ntwo,a.pdb,,,HEM XK2\n")
    proteins = from_table(str(table))
    assert proteins["one"] == {"structure": str(tmp_path / "a.pdb"), "chains": ["A", "B"], "model": 2}
    assert proteins["two"] == {"structure": str(tmp_path / "a.pdb"), "ligands": ["HEM", "XK2"]}
    assert set(check({"proteins": str(table)})["proteins"]) == {"one", "two"}


@pytest.mark.parametrize(
    "text, words",
    [
        ("", "needs a header with the column name"),
        ("structure\na.pdb\n", "needs a header with the column name"),
        ("name,structure\nx,a.pdb\nx,b.pdb\n", "line 3 of .* has a name given before"),
        ("name,structure\n,a.pdb\n", "line 2 of .* has no name"),
        ("name,structure\nx,a.pdb,more\n", "line 2 of .* has not as many cells"),
    ],
)
def test_a_bad_table_is_a_sentence(tmp_path, text, words):
    table = tmp_path / "proteins.csv"
    table.write_text(text)
    with pytest.raises(InputError, match=words):
        from_table(str(table))


def test_a_folder_becomes_proteins(tmp_path):
    for name in [
        "x.pdb",
        "x.cif.gz",
        "y.pdb",
        "y_long.xtc",
        "z.dms",
        "notes.txt",
        ".hidden.pdb",
        "αβ",
        "γ.pdb",
        "t.dcd",
    ]:
        (tmp_path / name).write_text("")
    proteins = from_folder(str(tmp_path))
    assert proteins == {
        "x_pdb": {"structure": str(tmp_path / "x.pdb")},
        "x_cif": {"structure": str(tmp_path / "x.cif.gz")},
        "y_long": {"structure": str(tmp_path / "y.pdb"), "trajectory": str(tmp_path / "y_long.xtc")},
        "z": {"surface": str(tmp_path / "z.dms")},
        "protein": {"structure": str(tmp_path / "γ.pdb")},
        "t": {"structure": str(tmp_path / "t.dcd")},
    }


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
    with pytest.raises(InputError, match="holds no file that ends in one of"):
        from_folder(str(tmp_path))
    with pytest.raises(InputError, match="there is no such folder"):
        check({"proteins": {"folder": str(tmp_path / "none")}})


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


def test_another_checksum_is_refused(server, tmp_path):
    with pytest.raises(InputError, match=r"has the sha256 .*, not 0{64}"):
        fetch(f"{server}/my%20file.pdb", "0" * 64, tmp_path / "a.pdb", tmp_path / "a.json", "x")
    assert not (tmp_path / "a.pdb").exists()


def test_no_network_is_a_sentence(tmp_path):
    with pytest.raises(InputError, match=r"A1 cannot be fetched from .* SPARSURF_A1"):
        fetch("http://127.0.0.1:9/a.pdb", None, tmp_path / "a", tmp_path / "b", "A1")


def test_a_missing_file_is_a_sentence(server, tmp_path):
    with pytest.raises(InputError, match=r"cannot be fetched from .* \(File not found\)"):
        fetch(f"{server}/none.pdb", None, tmp_path / "a", tmp_path / "b", "A1")


def test_only_the_web_is_fetched(tmp_path):
    with pytest.raises(InputError, match="must start with https"):
        fetch("file:///etc/passwd", None, tmp_path / "a", tmp_path / "b", "A1")


def test_names_and_variables():
    assert file_name("https://x.org/a/pdb%20files/208/cluster1.pdb") == "cluster1.pdb"
    assert file_name("https://x.org/..%2f..%2fpasswd") == "_2f.._2fpasswd"
    assert source({"pdb": "1ubi"}).endswith("/1UBI.cif.gz")
    assert variable("my-protein.1") == "SPARSURF_MY_PROTEIN_1"


def test_a_local_copy_replaces_a_fetched_one(monkeypatch):
    config = {"proteins": {"A1": {"url": "https://x.org/a.pdb", "sha256": "0" * 64, "chains": ["A"]}}}
    monkeypatch.setenv("SPARSURF_A1", str(TOPOLOGY))
    assert check(config)["proteins"]["A1"] == {"structure": str(TOPOLOGY), "chains": ["A"]}
    monkeypatch.delenv("SPARSURF_A1")
    assert "url" in check(config)["proteins"]["A1"]
