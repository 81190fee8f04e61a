"""Every example in the documentation of the functions for users gives what it says."""

import doctest
from importlib import import_module

import pytest

import sparsurf
from conftest import ROOT

MODULES = sorted({f"sparsurf.{module}" for module in sparsurf.FUNCTIONS.values()})


@pytest.mark.parametrize("module", MODULES)
def test_examples_give_what_they_say(module, monkeypatch):
    monkeypatch.chdir(ROOT)
    result = doctest.testmod(import_module(module), optionflags=doctest.NORMALIZE_WHITESPACE)
    assert result.failed == 0


@pytest.mark.parametrize("name", sparsurf.FUNCTIONS)
def test_every_function_for_users_has_an_example(name):
    assert f"sparsurf.{name}(" in getattr(sparsurf, name).__doc__


def test_what_is_not_there_is_reported():
    with pytest.raises(AttributeError, match="no attribute 'surfce'"):
        sparsurf.surfce  # noqa: B018
    assert set(sparsurf.FUNCTIONS) <= set(dir(sparsurf))
