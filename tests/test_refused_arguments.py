"""What is refused at every door: a value of an argument, given to a function, to a command, or as a key of a config."""

import copy
import re

import numpy as np
import pandas as pd
import pytest
import yaml

import sparsurf
from conftest import ROOT
from sparsurf.cli import command
from sparsurf.errors import InputError
from sparsurf_study.config.check import check_config

PEPTIDE = ROOT / "data" / "tdp43" / "topology.pdb"
TRAJECTORY = ROOT / "data" / "tdp43" / "trajectory.xtc"
D_LINK = 0.8  # Å, for the few dots of the blob
INF, NAN = float("inf"), float("nan")

# Of an argument: the functions that take it, by name; the command with its option; and the key of a config.
# An empty one: that door has no such argument.
DOORS = {
    "r_patch": (["roughness", "prepare"], "roughness dots.csv --r-patch", "patches.r_patch"),
    "r_zernike": (["descriptors", "prepare"], "descriptors dots.csv --r-zernike", "patches.r_zernike"),
    "d_link": (["roughness", "surface", "prepare", "minimal"], "roughness dots.csv --d-link", "patches.d_link"),
    "descriptor": (["descriptors"], "descriptors dots.csv --descriptor", "patches.descriptor"),
    "probe_radius": (["surface"], "surface protein.pdb --probe-radius", "surface.probe_radius"),
    "radii": (["surface"], "surface protein.pdb --radii", "surface.radii"),
    "cavities": (["surface"], "surface protein.pdb --cavities", "surface.cavities"),
    "reentrant": (["surface"], "", "surface.reentrant"),
    "seed": (["prepare", "sample", "minimal"], "minimal dots.csv --seed", "seed"),
    "n_dots": (["minimal", "sample"], "minimal dots.csv --n-dots", "minimal.n_dots"),
    "percent": (["minimal", "sample"], "minimal dots.csv --percent", "minimal.percent"),
    "error": (["minimal"], "minimal dots.csv --error", "minimal.error"),
    "max_z": (["minimal"], "minimal dots.csv --max-z", "minimal.max_z"),
    "sampler": (["minimal", "sample"], "minimal dots.csv --n-dots 9 --sampler", "minimal.sampler"),
    "combination": (["sample"], "", "minimal.combination"),
    "test_dots": (["compare"], "", "evaluation.test_dots"),
    "reading": (["compare"], "", "evaluation.readings"),
    "fields": (["fields"], "surface protein.pdb --fields", "fields"),
    "plddt": (["read_molecule"], "", "plddt"),
    "hydrogens": (["read_molecule"], "", "proteins.tdp43.hydrogens"),
    "residues": (["read_molecule"], "surface protein.pdb --residues", "proteins.tdp43.residues"),
    "stride": (["read_molecule"], "", "frames.stride"),
    "reach": (["recover"], "recover dots.csv --reach", ""),
    "density of minimal": (["minimal"], "minimal dots.csv --density", "minimal.density"),
    "density of surface": (["surface"], "surface protein.pdb --density", "surface.density"),
    "density of recover": (["recover"], "recover dots.csv --density", ""),
}  # fmt: skip
FUNCTIONS = {
    "roughness": lambda dots, **given: sparsurf.roughness(dots, **given),
    "descriptors": lambda dots, **given: sparsurf.descriptors(dots, [0], **given),
    "prepare": lambda dots, **given: sparsurf.prepare(dots, **given),
    "surface": lambda dots, **given: sparsurf.surface(PEPTIDE, **given),
    "minimal": lambda dots, **given: sparsurf.minimal(dots, **{"d_link": D_LINK} | given),
    "recover": lambda dots, **given: sparsurf.recover(dots, **given),
    "sample": lambda dots, **given: sparsurf.sample(
        sparsurf.prepare(dots, d_link=D_LINK), **({"n_dots": 9} if {*given} <= {"sampler", "seed"} else {}) | given
    ),
    "compare": lambda dots, **given: sparsurf.compare(sparsurf.prepare(dots, d_link=D_LINK), [0], **given),
    "fields": lambda dots, fields: sparsurf.fields(sparsurf.surface(PEPTIDE), names=[fields]),
    "read_molecule": lambda dots, **given: sparsurf.read_molecule(
        PEPTIDE, TRAJECTORY if "stride" in given else None, **given
    ),
}  # fmt: skip

POSITIVE, LESS = r"more than (0|1e-06)\b|1 or more", "{0:g} or less|at most {0:g}\\b|to {0:g}\\b"
NUMBER, WHOLE = "(a|auto or a) number", "a whole number"
HUGE = LESS.format(100)
REFUSED = [  # argument, value, reason: a regular expression
    *((name, value, reason) for name in ("r_patch", "r_zernike", "d_link")
      for value, reason in (
        (0, POSITIVE), (-1, POSITIVE), (101, HUGE), (True, NUMBER), ("four", NUMBER), (NAN, NUMBER), (INF, NUMBER))),
    ("descriptor", "rotation", "published'?(,| or) '?rotation_robust"),
    *(("probe_radius", value, reason) for value, reason in (
      (0, POSITIVE), (5e-324, POSITIVE), (11, LESS.format(10)), ("x", NUMBER))),
    ("radii", "vdw", "dms'?(,| or) '?bondi"),
    ("cavities", "x", "keep'?(,| or) '?remove"),
    ("reentrant", "x", "exact'?(,| or) '?dms"),
    *(("seed", value, reason) for value, reason in (
      (-1, "0 or more|, 0 to"), (2**64, "18446744073709551615"), (1.5, WHOLE), ("seven", WHOLE), (True, WHOLE))),
    *(("n_dots", value, reason) for value, reason in (
      (0, f"{POSITIVE}|1 to 3000"), (2.5, WHOLE), (True, WHOLE), (NAN, WHOLE))),
    ("percent", 0, POSITIVE), ("percent", 101, HUGE), ("percent", NAN, NUMBER),
    ("error", 0, POSITIVE), ("error", 10.1, LESS.format(10)),
    ("max_z", -0.1, "0 or more"),
    ("sampler", "farhest", "paper'?, '?paper_corrected'?, '?uniform'?, '?poisson'?,( or)? '?farthest"),
    ("combination", (2, 0, 6, 0), "alpha,? (is 2|must be more than 0 and 1 or less)"),
    ("combination", (0, 1, 1, 1), "alpha,? (is 0|must be more than 0 and 1 or less)"),
    ("combination", (1, 0, NAN, 0), "gamma|combination.2 is nan"),
    ("combination", (1, 0, 6), "four numbers|4 or more"),
    ("test_dots", 2.5, WHOLE), ("test_dots", 1, "2 (to|or more)"),
    ("reading", "both", "kept, .*full.*recovered"),
    ("fields", "hydropaty", "hydropathy, potential, bfactor"),
    ("plddt", 101, HUGE), ("plddt", "high", NUMBER), ("plddt", 0.7, "looks like a share; .* so give 70"),
    ("hydrogens", "x", "neither keep nor remove|one of keep, remove"),
    ("residues", "209-", "of the form .*A:10-52A"),
    ("stride", 0, POSITIVE), ("stride", 1.5, WHOLE),
    ("reach", 0, POSITIVE), ("reach", 10.1, LESS.format(10)),
    *((f"density of {name}", value, reason) for name in ("minimal", "surface", "recover")
      for value, reason in ((0, POSITIVE), (101, HUGE), ("high", NUMBER))),
]  # fmt: skip


def at(number):
    """Return the cases of a door: 0 for functions, 1 for commands, 2 for configs."""
    cases = []
    for argument, value, reason in REFUSED:
        door = DOORS[argument][number]
        for place in [door] if isinstance(door, str) else door:
            name = argument.split()[0]
            cases += [pytest.param(place, name, value, reason, id=f"{place}-{name}-{value}")] if place else []
    return cases


@pytest.fixture(scope="module")
def folder(tmp_path_factory, blob):
    """A folder with the files that the commands name."""
    place = tmp_path_factory.mktemp("refused")
    pd.DataFrame(np.hstack(blob), columns=["x", "y", "z", "nx", "ny", "nz"]).to_csv(
        place / "dots.csv", index=False
    )
    (place / "protein.pdb").symlink_to(PEPTIDE)
    return place


@pytest.mark.parametrize(("function", "argument", "value", "reason"), at(0))
def test_a_function_refuses_an_argument_in_one_sentence(blob, function, argument, value, reason):
    with pytest.raises(InputError, match=reason) as told:
        FUNCTIONS[function](blob, **{argument: value})
    assert argument in str(told.value) and "\n" not in str(told.value)


@pytest.mark.parametrize(("line", "argument", "value", "reason"), at(1))
def test_a_command_refuses_an_option_in_one_sentence(
    folder, monkeypatch, capsys, line, argument, value, reason
):
    monkeypatch.chdir(folder)
    try:
        code = command.main([*line.split(), str(value), "-o", "x.csv"])
    except SystemExit as end:
        code = end.code
    shown = capsys.readouterr()
    assert code in (1, 2) and shown.out == "" and "Traceback" not in shown.err
    told = shown.err.splitlines()[-1]
    assert line.split()[-1] in told and re.search(reason, told)
    assert sorted(path.name for path in folder.iterdir()) == ["dots.csv", "protein.pdb"]


@pytest.mark.parametrize(("key", "argument", "value", "reason"), at(2))
def test_a_config_refuses_a_key_in_one_sentence(monkeypatch, key, argument, value, reason):
    monkeypatch.chdir(ROOT)
    section = config = copy.deepcopy(yaml.safe_load((ROOT / "config.yaml").read_text()))
    *sections, last = key.split(".")
    for name in sections:
        section = section.setdefault(name, {})
    if sections == ["minimal"]:  # which takes only one size
        section.clear()
    section[last] = (
        [value] if argument in ("fields", "reading") else list(value) if isinstance(value, tuple) else value
    )
    with pytest.raises(InputError, match=reason) as told:
        check_config(config)
    assert f"config: {key}" in str(told.value) and "\n" not in str(told.value)
