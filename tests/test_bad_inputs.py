"""Inputs that an earlier release took without a word or answered with a traceback: each ends in one short sentence."""

import logging
import os
import signal

import pytest

from conftest import ROOT
from sparsurf import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.workflow.config import check
from sparsurf.workflow.yaml_file import read_config

# Words of the sentence: what is wrong and what to do. The name of the file or of the key is checked for all.
REFUSED = {
    "001_path_5000.yaml": ["proteins.tdp43.structure", "no file", "(5002 characters)"],
    "011_swap_norm.csv": ["normals of length 55", "exchange", "x,y,z and nx,ny,nz"],
    "014_url_broken_ipv6.yaml": ["proteins.tdp43.url", "complete https://"],
    "022_huge_point.csv": ["line 7", "1e+30", "repair"],
    "028_huge.pdb": ["GLU 209", "frame 0", "atom N"],
    "028_random_normals.csv": ["neighbouring dots", "outward normals"],
    "030_far_one.pdb": ["GLU 209", "frame 0", "atom N"],
    "030_nm.csv": ["0.036 Å apart", "nm", "give Å"],
    "034_tenfold.pdb": ["GLU 209", "Å"],
    "049_cut_in_number.csv": ["cut short", "line"],
    "116_badcrc.pdb.gz": ["damaged inside its gzip", "copy it again"],
    "121_trailgarbage.pdb.gz": ["damaged inside its gzip", "copy it again"],
    "122_nan_area.npz": ["area", "NaN"],
    "133_area_neg.npz": ["area", "negative"],
    "134_laugh10.yaml": ["aliases", "write them out"],
    "135_kind_9.npz": ["kind", "0, 1 or 2"],
    "135_laughmap.yaml": ["aliases", "write them out"],
    "141_cut.dms": ["cut short", "line", "copy it again"],
    "143_tagbool.yaml": ["line 9", "bool", "remove"],
    "144_tagtime.yaml": ["line 9", "timestamp", "remove"],
    "172_nobox.gro": ["box", "line 122"],
    "176_angstrom.gro": ["Å", "nm"],
    "240_comp_centres.yaml": ["complementarity.centres", "'some'", "sampler: farthest"],
    "258_pairs_name_pairs.yaml": ["pairs", "'pairs.md'", "choose another name"],
    "259_pairs_twins.yaml": ["pairs", "'x' and 'X'", "rename"],
    "260_pairs_long.yaml": ["pairs.x", "no file", "(302 characters)"],
    "302_tab_longname.yaml": ["proteins", "no such table", "(5006 characters)"],
    "303_folder_long.yaml": ["proteins.folder", "no such folder", "(5002 characters)"],
    "perm.xtc": ["GLU 209", "frame 0", "in the order of", "top.pdb"],
}
WARNED = {"048_cut.csv": ["do not close", "cut short"], "twice.dcd": ["12 frames", "twice"]}
OWN_TRAJECTORY = ("perm.xtc", "twice.dcd")
SECONDS = 20  # an answer that takes longer is none


@pytest.fixture
def bad(shared, monkeypatch):
    monkeypatch.chdir(ROOT)
    signal.signal(signal.SIGALRM, lambda *_: pytest.fail(f"no answer in {SECONDS} s"))
    signal.alarm(SECONDS)
    yield shared / "data" / "bad" / "second"
    signal.alarm(0)


def read(path):
    """What a study does first with a file of this kind."""
    if path.suffix == ".yaml":
        return check(read_config(path), [path])
    if path.name in OWN_TRAJECTORY:
        return read_molecule(path.with_name("top.pdb"), path)
    return read_molecule(path) if {".pdb", ".gro"} & set(path.suffixes) else read_surface(path)


@pytest.mark.parametrize("name", REFUSED)
def test_a_bad_file_is_refused_in_one_short_sentence(bad, name):
    with pytest.raises(InputError) as caught:
        read(bad / name)
    message = str(caught.value)
    for word in [*REFUSED[name], *([] if name.endswith(".yaml") else [name])]:
        assert word in message
    for sentence in message.replace(os.fspath(bad), "").splitlines():
        assert len(sentence.split()) <= 40 and sentence.endswith(".")


@pytest.mark.parametrize("name", WARNED)
def test_a_doubtful_file_is_read_with_a_warning(bad, name, caplog):
    with caplog.at_level(logging.WARNING, "sparsurf"):
        read(bad / name)
    assert all(word in caplog.text for word in [name, *WARNED[name]])


def test_every_bad_file_has_its_answer(bad):
    of_results = {"cc.yaml", "grid_full.csv"}  # test_half_of_a_real_grid_is_refused
    assert {path.name for path in bad.iterdir()} == {*REFUSED, *WARNED, *of_results, "top.pdb"}
