"""Every option of a command reaches its result: what is written is what the function of the library gives with that argument."""

import argparse
import inspect
from dataclasses import replace

import mdtraj
import numpy as np
import pandas as pd
import pytest

import sparsurf
from conftest import ROOT, sphere
from peptides import atom_line, peptide, two_models, write
from small_study import unpacked
from sparsurf.cli import command, msms
from sparsurf.cli.options import read_atoms
from sparsurf.surfaces.spheres import write_spheres

CALLS = {  # with which options are combined
    "surface": ("two.pdb", "", {}),
    "residues": ("two.pdb", "", {}),
    "roughness": ("two.pdb", "", {}),
    "descriptors": ("two.pdb", "--every 40", {"every": 40}),
    "minimal": ("two.pdb", "--percent 10", {"percent": 10}),
    "recover": ("few.csv", "", {}),
    "points": ("two.pdb", "--n-dots 40", {"n_dots": 40}),
    "show": ("two.pdb", "--no-open", {}),
    "frames": ("two.pdb", "", {}),
    "atoms": ("two.pdb", "", {}),
    "areas": ("two.pdb", "", {}),
    "regions": ("two.pdb", "--field mean_curvature --below 0", {"field": "mean_curvature", "below": 0}),
}
DECLARED = "".join(  # a monomer, and a dimer whose copies lie 6 Å apart
    f"REMARK 350 BIOMOLECULE: {name}\nREMARK 350 APPLY THE FOLLOWING TO CHAINS: A\n"
    + "".join(
        f"REMARK 350   BIOMT{row}   {copy}  {row == 1:.6f}  {row == 2:.6f}  {row == 3:.6f}     {shift * (row == 3):10.5f}\n"
        for copy, shift in ((1, 0), (2, 6))[:name]
        for row in (1, 2, 3)
    )
    for name in (1, 2)
)
OF_ATOMS = {
    "--chains A": {"chains": "A"},
    "--selection backbone": {"selection": "backbone"},
    "--ligands LIG": {"ligands": ["LIG"]},
    "--frame 1": {"frame": 1},
    "--model 2": {"model": 2},
    "--assembly": {"assembly": True},
    "--assembly-name 2": {"assembly": "2"},
    "--trajectory run.xtc": {"trajectory": "run.xtc"},
    "--trajectory run.xtc --frame 1": {"trajectory": "run.xtc", "frame": 1},
}
REENTRANT = {"--reentrant dms": {"reentrant": "dms"}}
CAGED = {"--selection all --cavities remove": {"selection": "all", "cavities": "remove"}}
PLACED = {"--probe-radius 1.6": {"probe_radius": 1.6}, "--radii bondi": {"radii": "bondi"}}
OF_SURFACE = PLACED | CAGED | REENTRANT
OF_DOTS = OF_ATOMS | OF_SURFACE | {"--d-link 0.7": {"d_link": 0.7}}
RESIDUES = {"--residues 2-4": {"residues": ["2", "3", "4"]}}
HYDROPATHY = {"--fields hydropathy": {"fields": "hydropathy"}}
WITHIN_A = {"--groups A:1-2+A:3-5,B": {"groups": "A:1-2+A:3-5,B"}}  # by default, A and B are partners
OPTIONS = {
    "surface": {"": {}, **OF_ATOMS, **RESIDUES, **HYDROPATHY, **OF_SURFACE, "--d-link 0.3": {"d_link": 0.3},
     "--density 9": {"density": 9}, "--boundary accessible": {"boundary": "accessible"}, "--groups A+B": {"groups": "A+B"},
     "--fields potential --charges two.pqr": {"fields": "potential", "charges": "two.pqr"},
     "--fields potential": {"fields": "potential"}, "--mesh --fields potential": {"mesh": True, "fields": "potential"},
     "--mesh --fields potential --charges two.pqr": {"mesh": True, "fields": "potential", "charges": "two.pqr"},
     "--mesh": {"mesh": True}, "--mesh --density 5": {"mesh": True, "density": 5},
     "--mesh --step 0.6": {"mesh": True, "step": 0.6},
     "--mesh --n-vertices 400": {"mesh": True, "n_vertices": 400},
     "--mesh --selection all --cavities keep": {"mesh": True, "selection": "all", "cavities": "keep"},
     "--mesh --frame 1": {"mesh": True, "frame": 1}, "--mesh --chains A": {"mesh": True, "chains": "A"},
     "--mesh --probe-radius 1.6": {"mesh": True, "probe_radius": 1.6},
     "--mesh --radii bondi": {"mesh": True, "radii": "bondi"},
     "--mesh --colours": {"mesh": True, "colours": True},
     "--mesh --fields hydropathy": {"mesh": True, "fields": "hydropathy"}},
    "residues": {"": {}, **OF_ATOMS, **OF_SURFACE, **RESIDUES, **HYDROPATHY},
    "roughness": {"": {}, **OF_DOTS, **RESIDUES, "--r-patch 3": {"r_patch": 3}},
    "descriptors": {"": {}, **OF_DOTS, **RESIDUES, "--at 5,0": {"at": [5, 0]}, "--every 30": {"every": 30},
     "--r-zernike 5": {"r_zernike": 5}, "--down": {"up": False},
     "--descriptor rotation_robust": {"descriptor": "rotation_robust"}},
    "minimal": {"": {}, **OF_DOTS, **HYDROPATHY, "--percent 12": {"percent": 12}, "--n-dots 50": {"n_dots": 50},
     "--density 0.6": {"density": 0.6}, "--error 0.1": {"error": 0.1}, "--max-z 1.5": {"max_z": 1.5},
     "--sampler uniform": {"sampler": "uniform"}, "--seed 2": {"seed": 2},
     "--error 0.1 --error-99 0.12": {"error": 0.1, "error_99": 0.12},
     "--error 0.1 --sampler cover --reconstruction interpolant":
     {"error": 0.1, "sampler": "cover", "reconstruction": "interpolant"}},
    "points": {"": {}, **OF_ATOMS, **PLACED, "--n-dots 50": {"n_dots": 50}, "--density 0.5": {"density": 0.5},
     "--seed 3": {"seed": 3}, "--fields roughness": {"fields": "roughness"}, "--groups A+B": {"groups": "A+B"},
     "--selection all --cavities keep": {"selection": "all", "cavities": "keep"}},
    "recover": {"": {}, "--density 9": {"density": 9}, "--at few.csv": {"at": "few.csv"},
     "--reconstruction interpolant": {"reconstruction": "interpolant"},
     "--reconstruction interpolant --reach 1.2": {"reconstruction": "interpolant", "reach": 1.2},
     "--reconstruction interpolant --steps 1": {"reconstruction": "interpolant", "steps": 1}, "--mesh": {"mesh": True},
     "--mesh --density 3": {"mesh": True, "density": 3}, "--mesh --step 0.4": {"mesh": True, "step": 0.4},
     "--mesh --n-vertices 400": {"mesh": True, "n_vertices": 400},
     "--mesh --reconstruction interpolant --reach 2.5": {"mesh": True, "reconstruction": "interpolant", "reach": 2.5},
     "--mesh --colours": {"mesh": True, "colours": True}},
    "show": {"": {}, **OF_ATOMS, **OF_SURFACE, "--trajectory run.xtc --rank area": {"trajectory": "run.xtc",
     "rank": "area"}},
    "frames": {"": {}, **{words: keys for words, keys in OF_ATOMS.items() if "frame" not in keys}, **HYDROPATHY, **PLACED,
     **CAGED, "--stride 2": {"stride": 2}, "--start 1 --stop 2": {"start": 1, "stop": 2}, **WITHIN_A,
     "--rank hydropathy": {"rank": "hydropathy"}, "--only-areas": {"only_areas": True}},
    "atoms": {"": {}, **OF_ATOMS, **PLACED, **CAGED},
    "areas": {"": {}, **OF_ATOMS, **PLACED, **RESIDUES, "--of chains": {"of": "chains"}, **WITHIN_A},
    "regions": {"": {}, **OF_ATOMS, **PLACED, **REENTRANT, "--field hydropathy": {"field": "hydropathy"},
     "--field potential --above 0": {"field": "potential", "above": 0},
     "--field potential --above 0 --charges two.pqr": {"field": "potential", "above": 0, "charges": "two.pqr"},
     "--above 0": {"above": 0}, "--below 0.1": {"below": 0.1}, "--min-area 0": {"min_area": 0},
     "--selection all --cavities keep": {"selection": "all", "cavities": "keep"}},
}  # fmt: skip
FILES = {  # in which an option has an effect
    "--assembly-name": "declared.pdb",
    "--assembly": "apart.pdb",
    "--trajectory": "one.pdb",
    "--cavities": "cage.pdb",
    "--reconstruction interpolant": "touched.csv",
}
# test_command.py, test_frames.py, test_fields.py, test_writing.py and test_colours.py
ELSEWHERE = {"--limits", "--help", "--output", "--jobs", "--rank-by", "--table", "--smooth", "--column"}
# in tests below
ELSEWHERE |= {"--altloc", "--hydrogens", "--plddt", "--no-whole", "--no-plugs"}
ALWAYS = {"--no-open"}  # no browser in a test
INSTEAD = {
    "--n-dots": ("--density",),
    "--percent": ("--n-dots", "--density", "--error", "--error-99", "--max-z"),
    "--every": ("--at",),
    "--field": ("--field",),
    "--below": ("--above", "--below"),
}  # options that exclude one another
BASES = {  # what an option is compared with, where that is not the command without options
    "--selection all --": "--selection all",
    "--mesh --selection all": "--mesh --selection all",
    "--mesh --reconstruction interpolant --": "--mesh --reconstruction interpolant",
    "--mesh --fields potential --": "--mesh --fields potential",
    "--mesh ": "--mesh",
    "--reconstruction interpolant --": "--reconstruction interpolant",
    "--trajectory run.xtc --frame": "--trajectory run.xtc",
    "--trajectory run.xtc --rank": "--trajectory run.xtc",
    "--error 0.1 --sampler cover --": "--error 0.1 --sampler cover",
    "--error 0.1 --": "--error 0.1",
    "--fields potential --": "--fields potential",
    "--field potential --above 0 --": "--field potential --above 0",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a file of two models, a trajectory, a molecule with a cavity, and minimal subsets."""
    place = tmp_path_factory.mktemp("options")
    write(place / "two.pdb", two_models())
    write(place / "apart.pdb", two_models(shift=40))
    write(place / "declared.pdb", DECLARED + peptide(("ALA", "SER", "LYS")) + "END\n")
    charges = (
        f"ATOM {k} X ALA 1 {x} {y} {z} {k % 3 - 1} 1.5\n"
        for k, (x, y, z) in enumerate(sparsurf.read_molecule(place / "two.pdb").xyz[0])
    )
    write(place / "two.pqr", "".join(charges))
    write(place / "one.pdb", peptide(("ALA", "SER", "LYS")) + "END\n")
    frame = mdtraj.load(str(place / "one.pdb"))
    moved = [frame.xyz[0] * scale for scale in ([1.02, 1, 1], [1, 1.04, 1])]
    mdtraj.Trajectory(np.array(moved), frame.topology).save_xtc(str(place / "run.xtc"))
    cage = [
        atom_line("C1", "UNL", "A", str(k + 1), 6.5 * at, record="HETATM")
        for k, at in enumerate(sphere(80)[0])
    ]
    write(place / "cage.pdb", "".join(cage) + "END\n")
    for name, size in (("few.csv", {"percent": 10}), ("touched.csv", {})):
        few = sparsurf.minimal(place / "two.pdb", **size)
        height = {"height": few.points[:, 2].round(1)}  # a field, which is interpolated
        sparsurf.write(replace(few, surface=replace(few.surface, fields=height)), place / name)
    return place


def read(path):
    """What a command has written: a table, the columns of a page, or bytes."""
    if path.suffix == ".html":
        return unpacked(path.read_text(encoding="utf-8"))[1]
    if path.suffix != ".csv":
        return path.read_bytes()
    ranking = path.with_name("x_ranking.csv")  # of `frames`
    tables = [pd.read_csv(each) for each in (path, ranking) if each.exists()]
    return pd.concat(tables, ignore_index=True)


def result(out, name, file, call, options):
    """Return what a command writes with some options."""
    words = call.split()
    for option, others in INSTEAD.items():
        if {option, *others} & {*options.split()} and option in words:
            del words[words.index(option) : words.index(option) + 2]
    suffix = {"points": "ply", "show": "html", "atoms": "pdb"}.get(
        name, "ply" if "--mesh" in options else "csv"
    )
    path = out / f"x.{suffix}"
    assert command.main([name, file, *words, *options.split(), "--quiet", "-o", str(path)]) == 0
    return read(path)


READING = ("chains", "selection", "ligands", "model", "assembly")
RULES = ("probe_radius", "radii", "cavities", "reentrant", "boundary")
PLACING = ("density", *RULES, "d_link", "groups")


def some(keys, *names):
    """The arguments among some names."""
    return {name: keys[name] for name in names if name in keys}


def molecule_of(file, keys):
    return sparsurf.read_molecule(file, keys.get("trajectory"), **some(keys, *READING))


def dots_of(file, keys, *placing):
    """The dots on which a command works."""
    dots = sparsurf.surface(molecule_of(file, keys), **some(keys, "frame", *placing))
    if "fields" in keys:
        values = sparsurf.fields(dots, names=keys["fields"], **some(keys, "charges"))
        dots = replace(dots, fields=values.to_dict("series"))
    return dots


def of_residues(frame, keys):
    """The rows of the residues asked for."""
    rows = np.arange(len(frame))
    return rows[frame["residue"].isin(keys["residues"])] if "residues" in keys else rows


def mesh_of(dots, keys, out):
    made = sparsurf.mesh(
        dots, **some(keys, "density", "step", "n_vertices", "fields", "charges", "reconstruction", "reach")
    )
    sparsurf.write(made, out / "own.ply", colours=keys.get("colours"))
    return read(out / "own.ply")


def surface(file, keys, out):
    if "mesh" in keys:
        rules = {"cavities": "remove"} | some(keys, "cavities", "frame", "probe_radius", "radii")
        return mesh_of(sparsurf.surface(molecule_of(file, keys), **rules), keys, out)
    dots = dots_of(file, keys, *PLACING, "boundary")
    frame = dots.to_frame()
    return frame.iloc[of_residues(frame, keys)]


def residues(file, keys, out):
    table = sparsurf.residues(dots_of(file, keys, *RULES))
    return table.iloc[of_residues(table, keys)]


def roughness(file, keys, out):
    dots = dots_of(file, keys, "d_link", *RULES)
    values = sparsurf.roughness(dots, **some(keys, "r_patch", "d_link"))
    frame = dots.to_frame().assign(roughness=values)
    columns = ["x", "y", "z", "nx", "ny", "nz", "atom", "roughness"]
    return frame.iloc[of_residues(frame, keys)][columns]


def descriptors(file, keys, out):
    dots = dots_of(file, keys, "d_link", *RULES)
    at = np.array(keys.get("at", of_residues(dots.to_frame(), keys)))[:: 1 if "at" in keys else keys["every"]]
    z = sparsurf.descriptors(dots, at, **some(keys, "r_zernike", "up", "d_link", "descriptor"))
    names = [f"z_{n}_{m}" for n in range(21) for m in range(n % 2, n + 1, 2)]
    return pd.DataFrame(z, columns=names).assign(dot=at, x=dots.points[at, 0])


def minimal(file, keys, out):
    sizes = some(keys, "n_dots", "density", "error", "error_99", "max_z")
    sizes = sizes or some(keys, "percent")
    ways = some(keys, "sampler", "seed", "d_link", "reconstruction")
    few = sparsurf.minimal(dots_of(file, keys, "d_link", *RULES), **sizes, **ways)
    sparsurf.write(few, out / "own.csv")
    return read(out / "own.csv")


def recover(file, keys, out):
    if "mesh" in keys:
        return mesh_of(file, keys, out)
    dense = sparsurf.recover(file, **some(keys, "density", "reach", "reconstruction", "steps"))
    if "at" not in keys:
        return dense.to_frame()[["x", "y", "z", "nx", "ny", "nz", "height"]]
    points = pd.read_csv(keys["at"])[["x", "y", "z"]].to_numpy()
    return pd.DataFrame(sparsurf.descriptors(dense, points)).set_axis(
        [f"z_{n}_{m}" for n in range(21) for m in range(n % 2, n + 1, 2)], axis=1
    )


def atoms(file, keys, out):
    rules = some(keys, "frame", "probe_radius", "radii", "cavities")
    sparsurf.surface_atoms(molecule_of(file, keys), **rules).write(out / "own.pdb")
    return read(out / "own.pdb")


def areas(file, keys, out):
    settings = some(keys, "frame", "probe_radius", "radii", "groups")
    table = getattr(sparsurf.areas(molecule_of(file, keys), **settings), keys.get("of", "residues"))
    return table.iloc[of_residues(table, keys)] if "residues" in keys else table


def regions(file, keys, out):
    rules = {"cavities": "remove"} | some(keys, "frame", *RULES)
    end = some(keys, "above") or some(keys, "below")
    dots = sparsurf.surface(molecule_of(file, keys), **rules)
    return sparsurf.regions(dots, keys["field"], **end, **some(keys, "min_area", "charges"))


def points(file, keys, out):
    sizes = some(keys, "density") or some(keys, "n_dots")
    settings = some(keys, "fields", "seed", "frame", "probe_radius", "radii", "cavities", "groups")
    sparsurf.write(sparsurf.points(molecule_of(file, keys), **sizes, **settings), out / "own.ply")
    return read(out / "own.ply")


def show(file, keys, out):
    if "trajectory" in keys and "frame" not in keys:
        page = sparsurf.show(file, open_browser=False, **some(keys, "trajectory", "rank"))
        return unpacked(page.html)[1]
    page = sparsurf.show(dots_of(file, keys, *RULES), open_browser=False)
    return unpacked(page.html)[1]


def frames(file, keys, out):
    settings = some(
        keys,
        "stride",
        "start",
        "stop",
        "fields",
        "probe_radius",
        "radii",
        "cavities",
        "rank",
        "groups",
        "only_areas",
    )
    tables = sparsurf.frames(molecule_of(file, keys), **settings)
    return pd.concat([tables.residues, tables.ranking], ignore_index=True)


WANTED = {
    wanted.__name__: wanted
    for wanted in (
        surface,
        residues,
        roughness,
        descriptors,
        minimal,
        recover,
        points,
        show,
        frames,
        atoms,
        areas,
        regions,
    )
}


def agree(found, wanted):
    """Whether a file holds what is wanted: the columns of a table with the digits of a CSV, pages and bytes exactly."""
    if type(found) is not type(wanted):
        return False
    if isinstance(found, bytes):
        return found == wanted
    if isinstance(found, dict):
        return found.keys() == wanted.keys() and all(
            np.array_equal(found[name], wanted[name]) for name in found
        )
    numbers = wanted.select_dtypes("number")
    return (
        len(found) == len(wanted)
        and {*numbers} <= {*found}
        and all(
            np.allclose(found[name], wanted[name], rtol=1e-4, atol=6e-5, equal_nan=True) for name in numbers
        )
    )


@pytest.mark.parametrize("name", [name for name in command.COMMANDS])
def test_every_option_is_in_the_table(name):
    listed = {word for words in OPTIONS[name] for word in words.split() if word.startswith("--")}
    actions = [
        action.option_strings[-1]
        for action in command.build_parser(name)[1]._actions
        # an option of earlier versions, which the help does not show, is tested in test_old_forms.py
        if action.option_strings and action.help != argparse.SUPPRESS
    ]
    in_python = {"--fields"} if name == "show" else set()  # where dots that carry fields are shown
    of_fields = (
        set() if name in ("surface", "regions") else {"--charges"}
    )  # which have the same meaning everywhere
    assert {*actions} - ELSEWHERE - ALWAYS - in_python - of_fields == listed


FUNCTIONS = {  # that a command calls, and the arguments that have no meaning on a command line, or another option
    ("frames", "read_molecule"): {"residues", "times"},
    ("surface", "surface"): set(),
    ("surface", "mesh"): {"reconstruction", "reach"},
    ("surface", "fields"): {"dots", "names"},
    ("recover", "mesh"):
    {"boundary", "cavities", "charges", "fields", "frame", "probe_radius", "radii", "smooth", "table"},
    **{(name, name): set() for name in ("recover", "minimal", "regions", "points", "areas")},
    ("residues", "residues"): {"dots", "kept", "roughness_values", "weight"},
    ("atoms", "surface_atoms"): set(),
    ("frames", "frames"): {"path"},
    ("roughness", "roughness"): {"roughness"},
    ("descriptors", "descriptors"): {"up"},
    ("show", "show"): {"path", "open_browser"},
}  # fmt: skip


@pytest.mark.parametrize("name, function", FUNCTIONS)
def test_every_argument_of_a_function_is_an_option_of_its_command(name, function):
    parameters = inspect.signature(getattr(sparsurf, function)).parameters.values()
    options = command.build_parser(name)[1]._option_string_actions
    without = {each.name for each in parameters if f"--{each.name.replace('_', '-')}" not in options}
    first = next(iter(inspect.signature(getattr(sparsurf, function)).parameters))
    assert without - {first} == FUNCTIONS[name, function]


@pytest.mark.parametrize(
    ("words", "keys"),
    [
        ("--altloc B", {"altloc": "B"}),
        ("--hydrogens remove", {"hydrogens": "remove"}),
        ("--plddt 50", {"plddt": 50}),
        ("--no-whole", {"whole": False}),
    ],
)
def test_how_a_structure_is_read_can_be_said(folder, monkeypatch, words, keys):
    monkeypatch.chdir(folder)
    given = ["surface", "two.pdb", "-o", "x.csv", *words.split()]
    args, molecule, read = (
        command.build_parser("surface")[0].parse_args(given),
        molecule_of("two.pdb", {}),
        {},
    )
    monkeypatch.setattr(
        sparsurf, "read_molecule", lambda *_, **keys: read.update(keys) or molecule, raising=False
    )
    read_atoms(args)
    assert keys.items() <= read.items()


def test_atoms_can_be_written_without_plugs(tmp_path):
    structure, path = ROOT / "data" / "tdp43" / "topology.pdb", tmp_path / "x.pdb"
    assert command.main(["atoms", str(structure), "--no-plugs", "-q", "-o", str(path)]) == 0
    assert path.read_text().count("\nATOM") == len(sparsurf.surface_atoms(structure, plugs=False))


@pytest.fixture(scope="module")
def results():
    """Results of calls with which those of others are compared."""
    return {}


@pytest.mark.parametrize(
    ("name", "options"), [(name, words) for name, rows in OPTIONS.items() for words in rows]
)
def test_a_result_is_that_of_the_function_and_differs_from_that_without_the_option(
    folder, tmp_path, monkeypatch, results, name, options
):
    monkeypatch.chdir(folder)
    file, call, keys = CALLS[name]
    file = next(
        (other for option, other in FILES.items() if option in options and other.endswith(file[-4:])), file
    )
    found = results[name, file, options] = result(tmp_path, name, file, call, options)
    assert agree(found, WANTED[name](file, keys | OPTIONS[name][options], tmp_path))
    if options:
        base = next((words for begin, words in BASES.items() if options.startswith(begin)), "")
        if (name, file, base) not in results:
            results[name, file, base] = result(tmp_path, name, file, call, base)
        assert not agree(results[name, file, base], found)


SPHERES = {  # of which an option makes another surface
    "": {},
    "--density 9": {"density": 9},
    "--probe-radius 1.6": {"probe_radius": 1.6},
    "--cavities remove": {"cavities": "remove"},
    "--mesh": {"mesh": True},
    "--mesh --density 5": {"mesh": True, "density": 5},
    "--mesh --step 0.6": {"mesh": True, "step": 0.6},
    "--mesh --cavities keep": {"mesh": True, "cavities": "keep"},
    "--mesh --probe-radius 1.6": {"mesh": True, "probe_radius": 1.6},
}


@pytest.mark.parametrize("options", SPHERES)
def test_an_option_of_a_surface_of_spheres_is_that_argument_of_the_function(tmp_path, monkeypatch, options):
    """A cage of atoms with a cavity."""
    monkeypatch.chdir(tmp_path)
    write_spheres("in.xyzr", 6.5 * sphere(80)[0], np.full(80, 1.9))
    keys = {"cavities": "remove" if "mesh" in SPHERES[options] else "keep"} | SPHERES[options]
    found = result(tmp_path, "surface", "in.xyzr", "", options)
    rules = some(keys, "probe_radius", "cavities")
    if "mesh" in keys:
        assert found == mesh_of(sparsurf.surface("in.xyzr", **rules), keys, tmp_path)
    else:
        dots = sparsurf.surface("in.xyzr", **rules, **some(keys, "density"))
        columns = ["x", "y", "z", "nx", "ny", "nz", "area", "kind"]
        assert agree(found, dots.to_frame()[columns].assign(atom=dots.atom))
    if options:
        base = "--mesh" if options.startswith("--mesh ") else ""
        assert not agree(result(tmp_path, "surface", "in.xyzr", "", base), found)


MSMS = {  # with spheres of the radii 1.5, 1.2, 1.9 and 1.2 Å
    "": {},
    "-probe_radius 2": {"probe_radius": 2.0},
    "-density 4": {"density": 4.0},
    "-noh": {"kept": [0, 2]},
    "-no_header": {},
    "-af own": {},
    "-af own -no_area": {},
    "-hdensity 9": {},
    "-surface tses": {},
    "-no_rest": {},
    "-no_rest_on_pbr": {},
    "-free_vertices": {},
    "-all_components": {},
    "-one_cavity 1 0": {},
}


def test_every_option_of_msms_is_in_the_table_or_refused():
    listed = {word[1:] for words in MSMS for word in words.split() if word.startswith("-")}
    assert {name for name, option in msms.OPTIONS.items() if not option.refusal} == listed | {"if", "of"}


@pytest.mark.parametrize("options", MSMS)
def test_an_option_of_msms_is_that_argument_of_the_mesh(tmp_path, monkeypatch, capsys, options):
    monkeypatch.chdir(tmp_path)
    keys = {"probe_radius": 1.5, "density": 1.0, "kept": [0, 1, 2, 3]} | MSMS[options]
    xyz, radii = np.array([[0, 0, 0], [2, 0, 0], [0, 2.5, 0], [0, 0, 3.0]]), np.array([1.5, 1.2, 1.9, 1.2])
    write_spheres("in.xyzr", xyz, radii)
    assert msms.main(["-if", "in.xyzr", "-of", "out", *options.split()]) == 0
    pair, skipped = (xyz[keys["kept"]], radii[keys["kept"]]), 0 if "-no_header" in options else 3
    dots = sparsurf.surface(pair, probe_radius=keys["probe_radius"], cavities="remove", density=20.0)
    sparsurf.write(sparsurf.mesh(dots, density=keys["density"]), "own.vert")
    for suffix in ("vert", "face"):
        lines = [(tmp_path / f"{name}.{suffix}").read_text().splitlines() for name in ("out", "own")]
        assert lines[0][skipped:] == lines[1][3:] and (skipped == 0) == ("#" not in lines[0][0])
    assert ("ANALYTICAL SURFACE AREA" in capsys.readouterr().out) == ("-no_area" not in options)
    assert (tmp_path / "own.area").exists() == (options == "-af own")
    if options == "-af own":
        table = np.loadtxt("own.area", skiprows=1)
        assert table[:, 1] == pytest.approx(np.bincount(dots.atom, dots.area), abs=2e-3)


def test_areas_of_spheres_apart_are_those_of_spheres(tmp_path, monkeypatch):
    """4 pi r^2, and with the probe 4 pi (r + p)^2."""
    monkeypatch.chdir(tmp_path)
    radii = np.array([1.5, 2.0, 1.0])
    write_spheres("in.xyzr", np.array([[0.0, 0, 0], [20, 0, 0], [0, 30, 0]]), radii)
    assert msms.main(["-if", "in.xyzr", "-af", "own", "-probe_radius", "1.7"]) == 0
    table = np.loadtxt("own.area", skiprows=1)
    assert table[:, 1] == pytest.approx(4 * np.pi * radii**2, rel=1e-3)
    assert table[:, 2] == pytest.approx(4 * np.pi * (radii + 1.7) ** 2, rel=1e-3)


@pytest.mark.parametrize("name", ["residues", "minimal --percent 10", "show"])
def test_options_of_a_surface_are_refused_for_dots(folder, monkeypatch, capsys, name):
    monkeypatch.chdir(folder)
    name, *others = name.split()
    output = "x.html" if name == "show" else "x.csv"
    assert command.main([name, "few.csv", *others, "--probe-radius", "1.6", "-o", output]) == 1
    assert "--probe-radius has no meaning for few.csv, which holds dots" in capsys.readouterr().err


ERRORS = {  # of functions that name arguments of Python or keys of a study
    "surface two.pdb --chains Q": "two.pdb has no chain Q",
    "surface two.pdb --residues 9-5": "--residues: '9-5' ends",
    "roughness two.pdb --d-link 0.01": "needs more than 100 dots per Å^2; give a larger --d-link.",
    "surface two.pdb --assembly": "conformations and not parts of one molecule; leave out `--assembly`.",
    "minimal mixed.pdb --percent 10": "choose one by `--model`, or take all models as one molecule by `--assembly`.",
    "points mixed.pdb": "choose one by `--model`, or take all models as one molecule by `--assembly`.",
}


@pytest.mark.parametrize("call", ERRORS)
def test_an_error_names_the_options_of_its_command(folder, monkeypatch, capsys, call):
    monkeypatch.chdir(folder)
    text = (folder / "two.pdb").read_text()
    (folder / "mixed.pdb").write_text(text[: text.rindex("ATOM")] + "ENDMDL\nEND\n")
    name, *words = call.split()
    assert command.main([name, *words, "-o", "x.npz"]) == 1
    message = capsys.readouterr().err.splitlines()[-1]
    assert message.startswith(f"sparsurf {name}: ") and ERRORS[call] in message
