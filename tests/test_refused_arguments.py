"""A wrong value is refused by its name at every door, before anything is read: of functions, of commands and of configs."""

import copy
import inspect
import math

import pytest
import yaml

import sparsurf
from conftest import ROOT
from sparsurf.arguments import ARGUMENTS, Limits
from sparsurf.cli import command
from sparsurf.errors import InputError
from sparsurf_study.config.check import check_config

NAN = math.nan
PEPTIDE = ROOT / "data" / "tdp43" / "topology.pdb"
FUNCTIONS = [name for name in sparsurf.FUNCTIONS if inspect.isfunction(getattr(sparsurf, name))]
KEYS = """seed patches.r_patch patches.r_zernike patches.d_link surface.probe_radius surface.cavities surface.reentrant
surface.density minimal.n_dots minimal.percent minimal.error minimal.max_z minimal.density evaluation.test_dots frames.stride"""
# What no limits describe: the function, the key of a config, a wrong value, and what the sentence names besides
OTHERS = [
    (lambda d, v: sparsurf.descriptors(d, [0], descriptor=v), "patches.descriptor", "rotation", "rotation_robust"),
    (lambda d, v: sparsurf.surface(PEPTIDE, radii=v), "surface.radii", "vdw", "bondi"),
    (lambda d, v: sparsurf.minimal(d, n_dots=9, d_link=0.8, sampler=v), "minimal.sampler", "farhest", "farthest"),
    (lambda d, v: sparsurf.sample(sparsurf.prepare(d, d_link=0.8), combination=v), "minimal.combination", [2, 0, 6, 0], ""),
    (lambda d, v: sparsurf.sample(sparsurf.prepare(d, d_link=0.8), combination=v), "minimal.combination", [0, 1, 1, 1], ""),
    (lambda d, v: sparsurf.sample(sparsurf.prepare(d, d_link=0.8), combination=v), "minimal.combination", [1, 0, NAN, 0], ""),
    (lambda d, v: sparsurf.sample(sparsurf.prepare(d, d_link=0.8), combination=v), "minimal.combination", [1, 0, 6], ""),
    (lambda d, v: sparsurf.compare(sparsurf.prepare(d, d_link=0.8), [0], reading=v), "evaluation.readings", "both", "kept"),
    (lambda d, v: sparsurf.fields(sparsurf.surface(PEPTIDE), names=v), "fields", ["hydropaty"], "hydropathy"),
    *((lambda d, v: sparsurf.read_molecule(PEPTIDE, plddt=v), "plddt", value, "") for value in (101, "high", 0.7)),
    (lambda d, v: sparsurf.read_molecule(PEPTIDE, hydrogens=v), "proteins.tdp43.hydrogens", "x", "keep"),
    (lambda d, v: sparsurf.read_molecule(PEPTIDE, residues=v), "proteins.tdp43.residues", "209-", "A:10-52A"),
]  # fmt: skip


def wrong(name):
    """Values of an argument beside those that are allowed."""
    allowed = ARGUMENTS[name].allowed
    if not isinstance(allowed, Limits):
        return ["x!", NAN]
    values = ["x!", NAN, -math.inf, allowed.low - 1, *([allowed.low] if allowed.open_low else [])]
    values += [] if allowed.or_infinite else [math.inf]
    values += [allowed.high * 1.01 + 1] if allowed.high < math.inf else []
    return values + [allowed.low + 1.5] * allowed.whole


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_refuses_a_wrong_value(name):
    function = getattr(sparsurf, name)
    parameters = inspect.signature(function).parameters
    numbers = {"error": 0.02, "density": 0.6}
    needed = [each for each, one in parameters.items() if one.default is one.empty]
    base = {each: numbers.get(each, object()) for each in needed}  # a file that cannot be read
    for argument in parameters.keys() & ARGUMENTS.keys():
        for value in [*wrong(argument), b"x", [], object(), 1j]:
            with pytest.raises(InputError) as told:
                function(**base | {argument: value})
            assert str(told.value).startswith(f"{argument} is ") and "\n" not in str(told.value)


@pytest.mark.parametrize("name", command.COMMANDS)
def test_a_command_refuses_a_wrong_value(tmp_path, monkeypatch, capsys, name):
    monkeypatch.chdir(tmp_path)
    base = [name, "no.pdb", "-o", "x.csv", *(["--field", "hydropathy"] if name == "regions" else [])]
    for action in command.build_parser(name)[1]._actions:
        if action.dest not in ARGUMENTS or action.nargs == 0:
            continue
        for value in wrong(action.dest):
            option = action.option_strings[-1]
            try:
                code = command.main([*base, f"{option}={value}"])
            except SystemExit as end:
                code = end.code
            shown = capsys.readouterr()
            told = shown.err.splitlines()[-1]
            assert code in (1, 2) and option in told and "no.pdb" not in told, (option, value, told)
            assert shown.out == "" and not [*tmp_path.iterdir()]


def refuse(key, value):
    """Give a config with another value of a key, and return the sentence by which it is refused."""
    section = config = copy.deepcopy(yaml.safe_load((ROOT / "config.yaml").read_text()))
    *sections, last = key.split(".")
    for name in sections:
        section = section.setdefault(name, {})
    if sections == ["minimal"]:  # which takes only one size
        section.clear()
    section[last] = [value] if last == "readings" else value
    with pytest.raises(InputError) as told:
        check_config(config)
    assert f"config: {key}" in str(told.value) and "\n" not in str(told.value)
    return str(told.value)


@pytest.mark.parametrize("key", KEYS.split())
def test_a_config_refuses_a_wrong_value(monkeypatch, key):
    monkeypatch.chdir(ROOT)
    for value in wrong(key.split(".")[-1]):
        refuse(key, value)


@pytest.mark.parametrize(("call", "key", "value", "word"), OTHERS)
def test_what_no_limits_describe_is_refused_as_well(monkeypatch, blob, call, key, value, word):
    monkeypatch.chdir(ROOT)
    with pytest.raises(InputError) as told:
        call(sparsurf.Surface(*blob), value)
    assert word in str(told.value) and "\n" not in str(told.value)
    assert word in refuse(key, value)
