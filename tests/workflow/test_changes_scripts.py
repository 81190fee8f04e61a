"""The script that compares two forms: mistakes in one sentence, residues that a form lacks."""

import pytest

import compare_forms
from conftest import ROOT
from small_study import EMBEDDED
from sparsurf.errors import InputError
from sparsurf.workflow.config import check_config

CONFIG = check_config({"proteins": {"tdp43": EMBEDDED}}, home=ROOT)


def test_forms_that_are_one_or_not_there_are_a_sentence():
    rest = ("", "", "", "", ["p/f0", "q/f0"], CONFIG["surface"], 0.5, 1, "bend")
    with pytest.raises(InputError, match=r"^changes\.bend: both names mean one conformation"):
        compare_forms.main("a.npz", "a.npz", "a.pdb", "a.pdb", *rest)
    with pytest.raises(
        InputError, match=r"^changes\.bend names a conformation that this study does not have"
    ):
        compare_forms.main(None, None, None, None, *rest)


def test_the_form_that_lacks_residues_is_named(monkeypatch, caplog):
    """The first form has residues 5 and 6, and the second lacks them."""
    for name, instead in (
        ("read_npz", lambda path: path),
        ("read_study_structure", lambda path: path),
        ("numbered_alike", lambda molecule, _: molecule),
        ("radii", lambda *_: None),
        ("surface_generator", lambda *_: (None, None)),
        ("unmatched_residues", lambda *_: ("A:5, A:6", "")),
    ):
        monkeypatch.setattr(compare_forms, name, instead)
    monkeypatch.setattr(compare_forms, "Form", lambda name, *_: name)
    monkeypatch.setattr(compare_forms, "changes_between", lambda *_: 1 / 0)
    rest = ("", "", "", "", ["p/f0", "q/f0"], CONFIG["surface"], 0.5, 1, "bend")
    with pytest.raises(ZeroDivisionError):
        compare_forms.main("a.npz", "b.npz", "a.pdb", "b.pdb", *rest)
    (told,) = [record.getMessage() for record in caplog.records]
    assert told.startswith("q/f0 lacks residues A:5, A:6 of p/f0, so changes next to them may come from that")
