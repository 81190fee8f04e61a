"""Every argument of every public function reaches its result: another value gives another result."""

import inspect
from types import SimpleNamespace

import mdtraj
import numpy as np
import pandas as pd
import pytest

import sparsurf
from conftest import ROOT, sphere
from peptides import two_models, write

PROTEIN = ROOT / "data/tdp43/topology.pdb"  # has a cavity
TRAJECTORY = ROOT / "data/tdp43/trajectory.xtc"
SEED = {"seed": 3}


@pytest.fixture(scope="module")
def given(tmp_path_factory):
    """Files and objects that functions take."""
    place = tmp_path_factory.mktemp("arguments")
    pdb = write(place / "two.pdb", two_models())
    (place / "folder").mkdir()
    write(place / "folder" / "a.pdb", two_models())
    dots = sparsurf.surface(pdb)
    peptide = mdtraj.load(TRAJECTORY, top=PROTEIN, stride=1000).atom_slice(range(60))
    peptide[0].save(place / "peptide.pdb")
    peptide.save(place / "two_frames.xtc")
    return SimpleNamespace(
        place=place, pdb=pdb, folder=place / "folder", dots=dots, ready=sparsurf.prepare(dots),
        frames=sparsurf.read_molecule(PROTEIN, TRAJECTORY, residues="209-212", stride=1000),
        few=sparsurf.minimal(dots, percent=10), peptide=place / "peptide.pdb", two_frames=place / "two_frames.xtc",
    )  # fmt: skip


def written(given, result, *names, **options):
    """Return the bytes that `write` writes."""
    path = given.place / "written.ply"
    sparsurf.write(result, path, *names, **options)
    return path.read_bytes()


def around(molecule):
    """Return dots on a sphere around the first frame of a molecule, and their normals."""
    unit = sphere(90)[0]
    return molecule.xyz[0].mean(axis=0) + 8 * unit, unit


def page(given, **options):
    """Return the page that `show` writes of a peptide, with two frames for the trajectory."""
    if "trajectory" in options:
        options["trajectory"] = given.two_frames
    sparsurf.show(given.peptide, given.place / "page.html", open_browser=False, **options)
    return (given.place / "page.html").read_bytes()


# Of a function: the call, its own arguments, and another value of each argument. A mapping gives those to be used together,
# where arguments exclude one another.
MOVING = {"trajectory": TRAJECTORY}
NOT_N, NOT_PERCENT = {"n_dots": None}, {"percent": None}
CALLS = [
    ("surface", lambda g, **k: sparsurf.surface(g.frames, **k), {}, {
        "frame": 1, "probe_radius": 1.6, "density": 9.0, "radii": "bondi", "d_link": 0.3}),
    ("surface", lambda g, **k: sparsurf.surface(PROTEIN, **k), {}, {
        "cavities": "remove", "reentrant": "dms", "boundary": "accessible"}),
    ("surface_atoms", lambda g, **k: sparsurf.surface_atoms(g.frames, **k).to_frame(), {}, {
        "frame": 1, "probe_radius": 1.6, "radii": "bondi"}),
    ("surface_atoms", lambda g, **k: sparsurf.surface_atoms(PROTEIN, **k).to_frame(), {}, {
        "cavities": "remove", "plugs": False}),
    ("areas", lambda g, **k: sparsurf.areas(g.frames, **k).residues, {}, {
        "frame": 1, "probe_radius": 1.6, "radii": "bondi"}),
    ("areas", lambda g, **k: sparsurf.areas(g.pdb, **k).residues, {}, {"groups": "A:1-2+A:3-5,B"}),
    ("points", lambda g, **k: sparsurf.points(g.frames, **k), {"n_dots": 40}, {
        "n_dots": 41, "density": NOT_N | {"density": 0.5}, "fields": ["hydropathy"], **SEED, "frame": 1, "probe_radius": 1.6,
        "radii": "bondi"}),
    ("points", lambda g, **k: sparsurf.points(PROTEIN, 2000, **k), {}, {"cavities": "keep"}),
    ("points", lambda g, **k: sparsurf.points(g.pdb, 40, **k), {}, {"groups": "A+B"}),
    ("surface", lambda g, **k: sparsurf.surface(g.pdb, **k), {}, {"groups": "A+B"}),
    ("points_of", lambda g, **k: sparsurf.points_of(g.folder, **k), {"n_dots": 40}, {
        "n_dots": 41, "density": NOT_N | {"density": 0.5}, "fields": ["hydropathy"], **SEED, "probe_radius": 1.6,
        "radii": "bondi"}),
    ("points_of", lambda g, **k: sparsurf.points_of(PROTEIN.parent, 2000, **k), {}, {"cavities": "keep"}),
    ("mesh", lambda g, **k: sparsurf.mesh(g.dots, **k), {"n_vertices": 300}, {
        "n_vertices": 302, "density": {"n_vertices": None, "density": 9.0}, "step": {"n_vertices": None, "step": 0.6},
        "fields": ["hydropathy"]}),
    ("mesh", lambda g, **k: sparsurf.mesh(g.frames, 300, **k), {}, {"frame": 1, "probe_radius": 1.6, "radii": "bondi"}),
    ("mesh", lambda g, **k: sparsurf.mesh(g.few, 300, **k), {}, {"reconstruction": "interpolant"}),
    ("mesh", lambda g, **k: sparsurf.mesh(g.few, 300, **k), {"reconstruction": "interpolant"}, {"reach": 1.3}),
    ("mesh", lambda g, **k: sparsurf.mesh(PROTEIN, 300, **k), {}, {"cavities": "keep", "boundary": "accessible"}),
    ("frames", lambda g, **k: sparsurf.frames(g.pdb, **k), {}, {
        "stride": 2, "fields": ["hydropathy"], "probe_radius": 1.6, "radii": "bondi"}),
    ("frames", lambda g, **k: sparsurf.frames(g.pdb, **k).ranking, {}, {"rank": "area"}),
    ("frames", lambda g, **k: sparsurf.frames(g.pdb, **k).residues, {}, {"groups": "A:1-2+A:3-5,B"}),
    ("frames", lambda g, **k: sparsurf.frames(g.pdb, **k).residues, {}, {"only_areas": True}),
    ("frames", lambda g, **k: sparsurf.frames(PROTEIN, **k), {}, {"cavities": "remove"}),
    ("frames", lambda g, **k: sparsurf.frames(PROTEIN, **k), {"stride": 700}, MOVING),
    ("frames", lambda g, **k: sparsurf.frames(PROTEIN, **k), {"stride": 700} | MOVING, {"start": 700, "stop": 700}),
    ("depth", lambda g, **k: sparsurf.depth(g.frames, **k), {}, {"frame": 1, "probe_radius": 1.6, "radii": "bondi"}),
    ("depth", lambda g, **k: sparsurf.depth(PROTEIN, **k), {}, {"cavities": "keep"}),
    ("minimal", lambda g, **k: sparsurf.minimal(g.dots, **k), {"percent": 10}, {
        "percent": 11, "n_dots": NOT_PERCENT | {"n_dots": 90}, "density": NOT_PERCENT | {"density": 0.7},
        "error": NOT_PERCENT | {"error": 0.05}, "max_z": NOT_PERCENT | {"max_z": 1.5}, "sampler": "uniform", **SEED}),
    ("minimal", lambda g, **k: sparsurf.minimal(g.pdb, **k), {"percent": 10}, {"d_link": 0.3}),
    ("minimal", lambda g, **k: sparsurf.minimal(g.dots, **k), {"error": 0.05}, {
        "error_99": 0.06, "reconstruction": "interpolant"}),
    ("prepare", lambda g, **k: sparsurf.prepare(g.dots, **k), {}, {
        "r_patch": 3.0, "r_zernike": 5.0, "d_link": 0.7, "descriptor": "rotation_robust", **SEED}),
    ("sample", lambda g, **k: sparsurf.sample(g.ready, **k), {"percent": 10}, {
        "percent": 11, "n_dots": NOT_PERCENT | {"n_dots": 90}, "sampler": "uniform",
        "combination": NOT_PERCENT | {"combination": (1, 0, 4, 6)}, **SEED}),
    ("compare", lambda g, **k: sparsurf.compare(g.ready, **k), {"subsets": [0, 9, 99], "test_dots": 20}, {
        "subsets": [0, 9], "reading": "kept", "test_dots": 21}),
    ("roughness", lambda g, **k: sparsurf.roughness(g.dots, **k), {}, {"r_patch": 3.0, "d_link": 0.7}),
    ("descriptors", lambda g, **k: sparsurf.descriptors(g.dots, **k), {"at": [0, 90]}, {
        "at": [0, 91], "r_zernike": 5.0, "up": False, "d_link": 0.7, "descriptor": "rotation_robust"}),
    ("recover", lambda g, **k: sparsurf.recover(g.few, **k), {}, {"density": 9.0}),
    ("recover", lambda g, **k: sparsurf.recover(g.few, **k), {"reconstruction": "interpolant"}, {"reach": 1.3, "steps": 1}),
    ("floors", lambda g, **k: sparsurf.floors(g.dots, **k), {}, {"d_link": 0.7, **SEED}),
    ("fields", lambda g, **k: sparsurf.fields(g.dots, **k), {"names": "hydropathy"}, {"names": "potential"}),
    ("fields", lambda g, **k: sparsurf.fields(g.frames, around(g.frames), **k), {"names": "potential"}, {"frame": 1}),
    ("components", lambda g, **k: sparsurf.components(PROTEIN, **k), {}, {
        "dots": sparsurf.surface(PROTEIN, probe_radius=1.0)}),
    ("residues", lambda g, **k: sparsurf.residues(g.dots, **k), {"kept": [3]}, {
        "roughness_values": np.zeros(10), "kept": [3, 4], "weight": [7]}),
    ("regions", lambda g, **k: sparsurf.regions(g.dots, **k), {"field": "hydropathy", "above": 0}, {
        "field": "mean_curvature", "above": 1, "below": {"above": None, "below": 0}, "min_area": 9000}),
    ("regions", lambda g, **k: sparsurf.regions(sparsurf.surface(g.pdb, **k), "hydropathy", above=0), {}, {"d_link": 3.0}),
    ("read_molecule", lambda g, **k: sparsurf.read_molecule(g.pdb, **k), {}, {
        "selection": "backbone", "chains": "B", "residues": "A:1-2", "model": 1, "altloc": "highest", "hydrogens": "remove",
        "ligands": "LIG", "groups": "A+LIG"}),
    ("read_molecule", lambda g, **k: sparsurf.read_molecule(PROTEIN, **k), {}, MOVING),
    ("read_molecule", lambda g, **k: sparsurf.read_molecule(PROTEIN, TRAJECTORY, **k), {"stride": 900}, {
        "stride": 700, "times": [100.0], "start": 900, "stop": 900}),
    ("show", page, {}, MOVING),
    ("show", page, MOVING, {"frame": 1}),
    ("write", lambda g, **k: written(g, sparsurf.points(g.pdb, 40, fields="hydropathy"), **k), {}, {
        "names": {"hydropathy": "hphob"}}),
    ("density_for", lambda g, **k: sparsurf.density_for(**k), {"error": 0.02}, {
        "error": 0.03, "hydrogens": True, "reconstruction": "spheres", "sampler": "cover"}),
    ("error_at", lambda g, **k: sparsurf.error_at(**k), {"density": 0.6}, {
        "density": 0.7, "hydrogens": True, "reconstruction": "spheres"}),
]  # fmt: skip
# Arguments that take the object itself, and those that other tests hold
OBJECTS = {"surface", "molecule", "folder", "few", "dots", "source", "path", "result"}
ELSEWHERE = {
    **{
        (name, argument): "dot_fields/test_fields.py"
        for name in ("fields", "mesh", "regions")
        for argument in ("charges", "table", "smooth")
    },
    ("read_molecule", "whole"): "test_corpus.py",
    ("read_molecule", "plddt"): "molecules/test_plddt.py",
    ("read_molecule", "assembly"): "molecules/test_assemblies.py",
    ("write", "frame"): "api/test_writing.py",
    ("write", "colours"): "api/test_writing.py",
    ("write", "column"): "api/test_writing.py",
    ("points_of", "jobs"): "api/test_points.py",
    ("frames", "jobs"): "api/test_frames.py",
    ("frames", "rank_by"): "api/test_frames.py",
    **{("show", name): "views/test_page.py" for name in ("rank", "rank_by")},
    ("show", "open_browser"): "api/test_show.py",
    **{(name, "limits"): "surfaces/test_colours.py" for name in ("show", "write")},
    ("roughness", "roughness"): "test_registry.py",
    ("error_at", "sampler"): "recovery/test_law.py",
    ("recover", "reconstruction"): "recovery/test_spheres.py",
    **{
        ("infer_atoms", name): "recovery/test_spheres.py"
        for name in ("points", "normals", "probe_radius", "radii")
    },
    ("prepare", "roughness"): "test_registry.py",
    **{("register", name): "test_registry.py" for name in inspect.signature(sparsurf.register).parameters},
}


def seen(result):
    """Return what a user sees of a result, as something that can be compared."""
    if isinstance(result, pd.DataFrame):
        return result.to_csv()
    if isinstance(result, dict):
        return [(name, seen(value)) for name, value in sorted(result.items())]
    if hasattr(result, "write_pdb"):  # a molecule
        return [result.xyz.tolist(), result.chain.tolist(), result.residue.tolist()]
    if hasattr(result, "triangles"):
        return [seen(result.vertices), result.triangles.tobytes()]
    if hasattr(result, "table") and hasattr(result, "dots"):  # a subset
        return [result.dots.tolist(), result.table.to_csv()]
    if hasattr(result, "describe"):  # a prepared surface
        return [seen(result.roughness), seen(result.describe(np.arange(3))), seen(result.draw_tests(5))]
    if hasattr(result, "to_frame"):
        return result.to_frame().to_csv()
    if isinstance(result, np.ndarray):
        return result.tolist()
    if isinstance(result, (str, bytes, float, int)):
        return result
    return [seen(each) for each in result]


@pytest.mark.parametrize(
    ("name", "call", "own", "argument", "value"),
    [
        pytest.param(name, call, own, argument, value, id=f"{name}-{argument}")
        for name, call, own, others in CALLS
        for argument, value in others.items()
    ],
)
def test_another_value_gives_another_result(given, name, call, own, argument, value):
    if argument == "roughness_values":
        value = np.zeros(len(given.dots))
    instead = value if isinstance(value, dict) and argument in value else {argument: value}
    assert seen(call(given, **own | instead)) != seen(call(given, **own))


def test_every_argument_of_every_function_is_in_the_table():
    tried = {(name, argument) for name, _, _, others in CALLS for argument in others}
    public = {
        (name, argument)
        for name in sparsurf.__all__
        if inspect.isfunction(getattr(sparsurf, name))
        for argument in inspect.signature(getattr(sparsurf, name)).parameters
        if argument not in OBJECTS
    }
    assert public - tried == ELSEWHERE.keys()
