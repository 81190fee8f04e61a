"""Every example in the documentation of the functions for users gives what it says."""

import doctest
import re
from ast import literal_eval
from importlib import import_module
from inspect import signature

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


@pytest.mark.parametrize("name", [*sparsurf.FUNCTIONS, *sparsurf.CLASSES])
def test_every_heading_has_a_line_of_its_own(name):
    """Elsewhere, the book and help() would show it as words of the paragraph below."""
    lines = getattr(sparsurf, name).__doc__.splitlines()
    assert not [line for line in lines if re.search(r"\w -{3,}", line)]


def test_what_is_not_there_is_reported():
    with pytest.raises(AttributeError, match="no attribute 'surfce'"):
        sparsurf.surfce  # noqa: B018
    assert set(sparsurf.FUNCTIONS) <= set(dir(sparsurf))


@pytest.mark.parametrize("name", sparsurf.FUNCTIONS)
def test_a_default_that_is_told_is_that_of_the_signature(name):
    """None stands for a default that is told in words; one that is told of several arguments is that of each."""
    function = getattr(sparsurf, name)
    defaults = {key: parameter.default for key, parameter in signature(function).parameters.items()}
    section = re.search(
        r"\n    Parameters\n    -+\n(.*?)\n    [A-Z]\w+\n    -+\n", function.__doc__, re.DOTALL
    )
    documented = re.findall(r"^    (\w[\w, ]*) : .*\n((?:        .*\n)+)", section[1], re.MULTILINE)
    assert documented
    for names, text in documented:
        told = re.findall(r"\(default ('[^']*'|\"[^\"]*\"|-?\d[\d.]*\d|\d|True|False)", text)
        keys = [key for key in names.split(", ") if defaults[key] is not None]
        for key, value in zip(keys, told * len(keys) if len(told) == 1 else told, strict=bool(told)):
            assert literal_eval(value) == defaults[key], key
