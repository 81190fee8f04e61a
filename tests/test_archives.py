"""Structures inside tar and zip archives: read one by one, damaged archives refused in one sentence."""

import gzip
import io
import os
import tarfile
import zipfile

import numpy as np
import pytest

import sparsurf
from peptides import peptide
from sparsurf import InputError, archives, files
from sparsurf.batches.assignment import size_as_pdb
from sparsurf.workflow.config import check_config
from sparsurf.workflow.listing import from_archive

TEXT = (peptide() + "END\n").encode()
PACKED = gzip.compress(TEXT, mtime=0)


def pack(path, contents):
    """Write an archive of the contents by name; return its path as a string."""
    if path.suffix == ".zip":
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, content in contents:
                archive.writestr(name, content)
        return str(path)
    with tarfile.open(path, "w") as archive:
        for name, content in contents:
            info = tarfile.TarInfo(name)
            info.size = len(content)
            archive.addfile(info, io.BytesIO(content))
    return str(path)


@pytest.fixture(params=[".tar", ".zip"])
def archive(request, tmp_path):
    """Path of an archive of two structures, one of them compressed and in a folder, and other files."""
    contents = [("./a.pdb", TEXT), ("models/b.pdb.gz", PACKED), ("._a.pdb", b"x"), ("notes.txt", b"x")]
    return pack(tmp_path / f"models{request.param}", contents)


def test_members_are_listed_and_read_as_files_of_a_folder(archive, tmp_path):
    assert from_archive(archive) == {
        "a": {"structure": f"{archive}/a.pdb"},
        "b": {"structure": f"{archive}/models/b.pdb.gz"},
    }
    assert list(from_archive(archive, "*.gz")) == ["b"]
    (tmp_path / "a.pdb").write_bytes(TEXT)
    expected = sparsurf.read_molecule(tmp_path / "a.pdb")
    for name in ("a.pdb", "models/b.pdb.gz"):
        assert np.array_equal(sparsurf.read_molecule(f"{archive}/{name}").xyz, expected.xyz)
    assert sorted(os.listdir(tmp_path)) == ["a.pdb", os.path.basename(archive)]
    assert size_as_pdb(f"{archive}/a.pdb") == len(TEXT)
    assert size_as_pdb(f"{archive}/models/b.pdb.gz") == 4 * len(PACKED)


def test_a_config_takes_an_archive_and_its_pattern(archive):
    config = {"proteins": {"archive": archive, "files": "*.pdb"}, "sampling": False, "batch": "auto"}
    assert check_config(config)["proteins"] == {"a": {"structure": f"{archive}/a.pdb"}}
    with pytest.raises(InputError, match=r"holds no file '\*.cif' that ends in one of"):
        check_config(config | {"proteins": {"archive": archive, "files": "*.cif"}})
    with pytest.raises(InputError, match="there is no file"):
        check_config(config | {"proteins": {"a": {"structure": f"{archive}/c.pdb"}}})


def test_an_archive_that_was_replaced_is_listed_again(archive, tmp_path):
    assert len(archives.members(archive)) == 4
    os.remove(archive)
    pack(tmp_path / os.path.basename(archive), [("c.pdb", TEXT)])
    os.utime(archive, (1, 1))
    assert list(archives.members(archive)) == ["c.pdb"]


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 0.6, 0.9])
def test_an_archive_that_is_cut_short_is_refused(archive, share):
    with open(archive, "rb") as stream:
        content = stream.read()
    end = content.rstrip(b"\0")  # a tar may have more zeros than it needs
    with open(archive, "wb") as stream:
        stream.write(end[: int(share * len(end))])
    with pytest.raises(InputError, match="is cut short, damaged or no archive") as error:
        from_archive(archive)
    assert "\n" not in str(error.value)


def test_a_tar_that_stops_between_two_members_is_refused(tmp_path):
    path = pack(tmp_path / "x.tar", [("a.pdb", bytes(512)), ("b.pdb", bytes(512))])
    with open(path, "r+b") as stream:
        stream.truncate(1024)
    with pytest.raises(InputError, match="it lacks its end"):
        from_archive(path)


@pytest.mark.parametrize("end", [".tar", ".zip"])
@pytest.mark.parametrize(
    ("names", "words"),
    [
        (["../a.pdb"], r"holds '../a.pdb', which leads outside"),
        (["/tmp/a.pdb"], r"holds '/tmp/a.pdb', which leads outside"),
        (["x/../../a.pdb"], r"holds '../a.pdb', which leads outside"),
        (["a.pdb", "./a.pdb"], r"holds 'a.pdb' 2 times"),
        (["x/a.pdb", "y/A.pdb"], r"x/a.pdb and y/A.pdb have one name"),
        (["a.pdb", "a.cif.gz"], r"a.cif.gz and a.pdb have one name; choose one kind"),
        (["a.txt"], r"holds no file '\*' that ends in one of .pdb"),
        ([], r"holds no file '\*'"),
    ],
)
def test_names_that_cannot_be_taken_are_a_sentence(tmp_path, end, names, words):
    path = pack(tmp_path / f"x{end}", [(name, TEXT) for name in names])
    with pytest.raises(InputError, match=words) as error:
        from_archive(path)
    assert str(error.value).endswith((".", ")."))


@pytest.mark.parametrize("name", ["x.tar.gz", "x.tgz", "x.rar", "none.zip"])
def test_other_files_are_a_sentence(tmp_path, name):
    if name != "none.zip":
        (tmp_path / name).write_bytes(b"content")
    words = {"x.rar": "is not an archive", "none.zip": "does not exist"}.get(
        name, "uncompress it to a .tar file"
    )
    with pytest.raises(InputError, match=words):
        from_archive(str(tmp_path / name))


def test_links_and_folders_are_no_members(tmp_path):
    with tarfile.open(tmp_path / "x.tar", "w") as archive:
        for name, kind in (
            ("a.pdb", tarfile.SYMTYPE),
            ("b.pdb", tarfile.LNKTYPE),
            ("c.pdb", tarfile.DIRTYPE),
        ):
            info = tarfile.TarInfo(name)
            info.type, info.linkname = kind, "/etc/passwd"
            archive.addfile(info)
    assert archives.members(str(tmp_path / "x.tar")) == {}


def test_a_damaged_member_and_a_large_one_are_refused(tmp_path, monkeypatch):
    path = pack(tmp_path / "x.zip", [("a.pdb", TEXT)])
    content = bytearray((tmp_path / "x.zip").read_bytes())
    content[60:80] = bytes(20)
    (tmp_path / "x.zip").write_bytes(content)
    with pytest.raises(InputError, match=r"x.zip/a.pdb is damaged inside its archive"):
        sparsurf.read_molecule(f"{path}/a.pdb")
    path = pack(tmp_path / "y.tar", [("a.pdb", TEXT), ("b.pdb.gz", gzip.compress(bytes(2_000_000)))])
    monkeypatch.setattr(files, "MAX_BYTES", 100)
    for name in ("a.pdb", "b.pdb.gz"):
        with pytest.raises(InputError, match=r"holds more than 0 MB"):
            sparsurf.read_molecule(f"{path}/{name}")


def test_a_name_that_an_archive_lacks_and_a_password_are_said(archive, tmp_path):
    with pytest.raises(InputError, match=r"holds no c\.pdb: check the name\.$"):
        archives.read_member(archive, "c.pdb", 100)
    path = pack(tmp_path / "locked.zip", [("a.pdb", TEXT)])
    content = bytearray((tmp_path / "locked.zip").read_bytes())
    content[content.index(b"PK\x01\x02") + 8] |= 1  # the flag of encryption in the list of the members
    (tmp_path / "locked.zip").write_bytes(content)
    with pytest.raises(InputError, match=r"locked\.zip is encrypted: give an archive without a password\.$"):
        archives.members(path)
