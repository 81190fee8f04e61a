"""Every rule, run for real in the small study: values in its outputs, and pages that lead to them."""

import hashlib
import html
import io
import itertools
import json
import re
from dataclasses import replace
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pandas as pd
import pytest
import yaml
from matplotlib.image import imread
from matplotlib.text import Text
from scipy.spatial import cKDTree
from scipy.spatial.distance import pdist

import sparsurf
from parsed_pages import origin_of
from peptides import peptide, write
from small_study import output, run_script, snakemake, unpacked, write_study
from sparsurf.evaluation.statistics import mean_interval
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.version import __version__
from sparsurf.views import layout
from sparsurf.views.numbers import interval
from sparsurf_study.analysis.comparison import select_methods
from sparsurf_study.analysis.ensemble import evaluate_frames
from sparsurf_study.analysis.grid import add_scaled_link
from sparsurf_study.analysis.islands import add_islands
from sparsurf_study.analysis.tables import read_prepared, read_table
from sparsurf_study.config.check import check_config
from sparsurf_study.pairs import changes
from sparsurf_study.pairs.changes import read_forms
from sparsurf_study.pairs.ranking import auc
from sparsurf_study.pairs.residue_moments import MOMENT_CHANNELS, MOMENT_FIELDS, describe_residues, distances
from sparsurf_study.report.figures import subsets
from sparsurf_study.settings import StudySettings as StudySettings
from sparsurf_study.structures import read_study_structure

pytestmark = pytest.mark.slow

CONFORMATIONS = ("moving/f0000", "moving/f0700", "still/f0", "loaded/f0", "ready/c1")
MOLECULES = CONFORMATIONS[:4]
KINDS = ("surface", "npz"), ("structure", "pdb")  # of files of a partner
SAMPLED = [place for place in CONFORMATIONS if place != "loaded/f0"]


@pytest.fixture(scope="module")
def run(study):
    """Folder of the results."""
    return study / "results" / "small"


@pytest.fixture(scope="module")
def ready(study, run):
    """Sections of the checked config, and the ready surface as the study prepares it."""
    config = yaml.safe_load((study / "config.yaml").read_text())
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(study)
        checked = check_config(config)
    files = (str(run / "ready/c1" / name) for name in ("surface.npz", "roughness.csv"))
    return checked, read_prepared(*files, Settings.of(checked), Streams(checked["seed"], "ready/c1"))


def structure_of(run, place):
    """Return the dots of a conformation and the residue of each, 0 for the first."""
    surface = read_npz(run / place / "surface.npz")
    return surface, read_study_structure(run / place / "structure.pdb").residue_index[surface.atom]


def columns_of_ply(path):
    """Return the columns of a PLY file, those included that mean something in the study alone."""
    head, rows = path.read_text().split("end_header\n")
    return pd.read_csv(io.StringIO(rows), sep=" ", names=re.findall(r"^property \w+ (\w+)$", head, re.M))


def test_conformations_are_the_frames_that_the_config_names(study, run):
    trajectory = read_molecule(
        study / "topology.pdb", trajectory=study / "trajectory.xtc", residues="209-216"
    )
    frames = pd.read_csv(run / "moving/frames.csv")
    assert frames["conformation"].tolist() == ["f0000", "f0700"] and frames["frame"].tolist() == [0, 700]
    for name, frame in zip(frames["conformation"], frames["frame"], strict=True):
        atoms = read_study_structure(run / f"moving/{name}/structure.pdb").xyz[0]
        assert np.allclose(atoms, trajectory.xyz[frame], atol=2e-3)
    assert len(pd.read_csv(run / "moving/projection.csv")) == trajectory.n_frames


def test_a_download_gives_the_results_of_the_local_file(study, run):
    for name in ("surface.npz", "roughness.csv"):
        assert (run / "loaded/f0" / name).read_bytes() == (run / "still/f0" / name).read_bytes()
    record = json.loads((run / "loaded/download/loaded.pdb.json").read_text())
    asked = yaml.safe_load((study / "config.yaml").read_text())["proteins"]["loaded"]
    assert (record["url"], record["sha256"]) == (asked["url"], asked["sha256"])
    assert record["bytes"] == (study / "loaded.pdb").stat().st_size


def test_a_ready_surface_is_taken_as_it_is(study, run):
    ready, surface = read_npz(study / "ready.npz"), read_npz(run / "ready/c1/surface.npz")
    assert np.array_equal(ready.points, surface.points) and np.array_equal(ready.normals, surface.normals)
    assert not (run / "ready/c1/structure.pdb").exists()


def surface_area(folder):
    """Area of a surface, Å^2."""
    return read_npz(folder / "surface.npz").area.sum()


@pytest.mark.parametrize("place", CONFORMATIONS)
def test_tables_of_a_conformation_agree(run, place):
    folder, n = run / place, len(read_npz(run / place / "surface.npz"))
    protein, conformation = place.split("/")
    row = (
        pd.read_csv(run / "surfaces.csv").set_index(["protein", "conformation"]).loc[(protein, conformation)]
    )
    roughness, minimal = pd.read_csv(folder / "roughness.csv"), pd.read_csv(folder / "minimal.csv")
    assert len(roughness) == row["N"] == n and roughness["roughness"].between(0, 1).all()
    assert row["mean_roughness"] == pytest.approx(roughness["roughness"].mean())
    assert len(minimal) == row["minimal_n_S"] and minimal["weight"].sum() == n
    recovered = pd.read_csv(folder / "recovered.csv").iloc[0]
    assert row["recovered_mean"] == recovered["mean"]
    if place in MOLECULES:  # independent dots, 8 per Å^2 of the whole surface
        assert recovered["dots"] == pytest.approx(8 * surface_area(folder), rel=0.05)
    else:
        assert recovered["dots"] == n - len(minimal)
    assert (recovered["measured_on"] == "independent dots") == (place in MOLECULES)
    assert row["recovered_Z_published"] == recovered["Z_published"] > 0
    assert pd.notna(row["best_kept"]) == (place in SAMPLED)
    surface = read_npz(folder / "surface.npz")
    np.testing.assert_allclose(roughness["roughness"], sparsurf.roughness(surface), atol=1e-9)
    few, whole = (columns_of_ply(folder / f"{name}.ply") for name in ("minimal", "surface"))
    names = ["x", "y", "z", "nx", "ny", "nz", "weight", "area", "spacing", "reach"]
    np.testing.assert_allclose(few[names], minimal[names], atol=1e-3)
    np.testing.assert_allclose(whole["roughness"], roughness["roughness"], atol=1e-3)
    np.testing.assert_allclose(whole[names[:6]], np.hstack([surface.points, surface.normals]), atol=1e-3)
    assert ("component" in whole) == (place in MOLECULES)


@pytest.mark.parametrize("place", SAMPLED)
def test_tables_of_the_papers_sampling_agree(run, place):
    folder, n = run / place, len(read_npz(run / place / "surface.npz"))
    grid, best = pd.read_csv(folder / "grid.csv"), json.loads((folder / "best.json").read_text())
    assert len(grid) == best["combinations"] == 8 and best["N"] == n
    floors = pd.read_csv(folder / "floors.csv").set_index("floor")["Z"]
    assert best["references"]["floors"] == pytest.approx(floors.to_dict())
    chosen = best["kept"]["unrestricted"]
    chosen = grid.query(
        " and ".join(f"{key} == {chosen[key]}" for key in ("alpha", "beta", "gamma", "delta"))
    )
    assert chosen["n_S"].tolist() == [best["kept"]["unrestricted"]["n_S"]]
    ranges = pd.read_csv(folder / "ranges.csv").query("reading == 'kept'")
    assert len(ranges) == 10 and ranges["n_combinations"].sum() == len(grid) - 1  # the largest is in none
    winners = np.load(folder / "winners.npz")
    assert winners.files == ["kept", "full"] and winners["full"].any(axis=1).sum() > 3
    for row, kept in zip(ranges.to_dict("records"), winners["kept"], strict=True):
        assert len(kept) == n and kept.sum() == pytest.approx(
            row["n_S"] if row["n_combinations"] else 0, rel=0.1
        )
    page = html.unescape((run / "index.html").read_text())
    for row in ranges.dropna(subset="d_cv").to_dict("records"):
        assert interval(row["d_cv"], row["d_cv_low"], row["d_cv_high"]) in page  # rounded as the table is
    distances = np.load(folder / "distances.npz")
    assert distances["z_ts"].shape == (2, 8, 2, 20)  # readings, combinations, draws, test dots
    bins = pd.read_csv(folder / "rough_and_flat.csv")
    drawn = bins[~bins["bin"].str.endswith("half")].groupby("around")["n"].sum()
    assert drawn.to_list() == pytest.approx([10 * 20] * 2, abs=1e-3)  # ten means of six digits


def test_the_dots_of_a_winner_are_those_of_its_first_draw(run, ready):
    _, prepared = ready
    ranges, winners = pd.read_csv(run / "ready/c1/ranges.csv"), np.load(run / "ready/c1/winners.npz")
    for reading, rows in ranges.groupby("reading"):
        for row, kept in zip(rows.to_dict("records"), winners[reading], strict=True):
            if row["n_combinations"]:
                sampled = prepared.pair([row[key] for key in ("alpha", "beta", "gamma", "delta")], 0)[0]
                assert np.array_equal(np.flatnonzero(kept), sampled)


@pytest.mark.parametrize("place", MOLECULES)
def test_residues_and_fields_are_those_of_the_dots(run, place):
    folder = run / place
    surface, residue = structure_of(run, place)
    fields, minimal = np.load(folder / "fields.npz"), pd.read_csv(folder / "minimal.csv")
    residues, roughness = pd.read_csv(folder / "residues.csv"), pd.read_csv(folder / "roughness.csv")
    coloured = read_study_structure(folder / "structure_roughness.pdb")
    of_atoms = residues["mean_roughness"].to_numpy()[coloured.residue_index]
    assert np.allclose(coloured.b_factor, of_atoms, atol=6e-3)
    balls = re.findall(
        r"^\.(?:sphere|dot)(?:at)? (\S+) (\S+) (\S+)", (folder / "minimal.bild").read_text(), re.M
    )
    assert np.allclose(np.array(balls, float), minimal[["x", "y", "z"]], atol=1e-3)
    assert residues["dots"].tolist() == np.bincount(residue, minlength=len(residues)).tolist()
    assert residues["kept"].sum() == len(minimal) and residues["weight"].sum() == len(surface)
    own = [roughness["roughness"][residue == k].mean() for k in range(len(residues))]
    assert np.allclose(residues["mean_roughness"], own)
    names = ["hydropathy", "mean_curvature", "hbond"]
    placed = sparsurf.surface(run / place / "structure.pdb")
    own = sparsurf.fields(placed, names)
    assert np.array_equal(surface.points, placed.points) and own["hbond"].abs().max() == 1
    for name in names:
        np.testing.assert_allclose(fields[name], own[name], atol=1e-9)
        of_residues = [fields[name][residue == k].mean() for k in range(len(residues))]
        assert np.allclose(residues[f"mean_{name}"], of_residues)
        np.testing.assert_allclose(minimal[name], fields[name][minimal["dot"]], atol=1e-4)
    assert np.array_equal(surface.points[minimal["dot"]].round(4), minimal[["x", "y", "z"]].to_numpy())
    table = pd.read_csv(folder / "fields.csv")
    assert {*table["field"]} == {*names} | ({"score"} if "loaded" not in place else set())
    if "loaded" not in place:  # which has no table of scores
        scored = 210 if "moving" in place else 2
        assert residues.set_index("residue")["mean_score"][scored] > 0.8
    for name, values in (("surface.ply", fields["hydropathy"]), ("minimal.ply", minimal["hydropathy"])):
        written = read_surface(folder / name).fields["hydropathy"]
        np.testing.assert_allclose(written, values, rtol=1e-3, atol=1e-3)


@pytest.mark.parametrize("place", ["moving/f0000", "ready/c1"])
def test_the_first_page_of_a_surface_shows_its_roughness_and_residues(run, place):
    """And leads to the page on which its dots are sampled, which has those of minimal.csv.

    These are the first of farthest-point sampling where the surface has no atoms, and cannot be reconstructed from spheres.
    """
    folder = run / place
    text = (folder / "surface.html").read_text(encoding="utf-8")
    header, columns = unpacked(text)
    surface, roughness = read_npz(folder / "surface.npz"), pd.read_csv(folder / "roughness.csv")["roughness"]
    if "moving" in place:  # a mesh and its residues
        scale, residues = header["numbers"][0], pd.read_csv(folder / "residues.csv")
        of_residues = scale["low"] + columns["number 0"] * scale["step"]
        assert scale["name"] == "mean roughness"
        assert header["residues"] == [f"{row.residue_name} {row.residue}" for row in residues.itertuples()]
        assert np.allclose(of_residues, residues["mean_roughness"], rtol=0, atol=scale["step"])
    else:
        scale = header["values"][0]
        of_dots = scale["low"] + columns["value 0"] / 254 * (scale["high"] - scale["low"])
        assert np.abs(of_dots - roughness).max() <= (scale["high"] - scale["low"]) / 254 / 2 + 1e-6
        assert (
            scale["symbol"] == "R_i"
            and header["dots"]["radius"] == 4.0
            and header["dots"]["total"] == len(surface)
        )
    title = place if "moving" in place else "ready"
    assert f"<title>{title}" in text
    assert 'href="view.html"' in text and 'href="../../index.html"' in text
    drawn = (folder / "figures/roughness.svg").read_text(encoding="utf-8")
    assert f"mean {roughness.mean():.2f}" in drawn and place in drawn
    page = (folder / "view.html").read_text(encoding="utf-8")
    assert f"<title>{title}</title>" in page and 'href="surface.html"' in page
    columns, minimal = unpacked(page)[1], pd.read_csv(folder / "minimal.csv")["dot"]
    assert sorted(np.flatnonzero(columns["minimal"])) == sorted(minimal)
    farthest = sorted(np.flatnonzero(columns["rank farthest"] < len(minimal)))
    assert (farthest == sorted(minimal)) == ("ready" in place)


def test_figures_over_frames_show_their_tables(run, tmp_path, monkeypatch):
    saved = {}
    monkeypatch.setattr(layout, "save", lambda figure, path: saved.update({Path(path).name: figure}))
    tables = {
        name: run / f"moving/{name}.csv" for name in ("frames", "silhouette", "projection", "explained")
    }
    run_script("draw_frames", tmp_path, tables, {"png": "frames"}, protein="moving")
    all_frames, chosen = saved["frames"].axes[0].collections[:2]
    for points, name in ((all_frames, "projection"), (chosen, "frames")):
        assert np.allclose(points.get_offsets(), pd.read_csv(tables[name])[["pc1", "pc2"]])
    files = {"table": "ensemble", "over_time": "residues_over_time", "residues": "residues"}
    files = {key: run / f"moving/{name}.csv" for key, name in files.items()}
    params = {"combination": [0.5, 0, 6, 2]}
    outputs = {"png": "ensemble", "residues_png": "residues"}
    run_script("draw_ensemble", tmp_path, files, outputs, params, protein="moving")
    table, over_time, residues = (pd.read_csv(path) for path in files.values())
    lines = [ax.lines[0].get_xydata() for ax in saved["ensemble"].axes[::2]]
    for line, name in zip(lines, ("n_S_percent", "mean_roughness", "d_kept", "d_full"), strict=True):
        assert np.allclose(line, table[["time_ps", name]])
    image, profile = saved["residues"].axes[:2]
    assert np.allclose(image.images[0].get_array().T, over_time.iloc[:, 2:])
    assert np.allclose(profile.lines[0].get_xdata(), residues["mean_roughness"])
    words = {name: [text.get_text() for text in figure.findobj(Text)] for name, figure in saved.items()}
    assert all(any(text.startswith("moving") for text in texts) for texts in words.values())
    assert "α = 0.5, β = 0, γ = 6, δ = 2" in words["ensemble"]


def test_an_ensemble_has_the_frames_of_all_its_jobs(run, study, ready):
    """With the random numbers that they have in one job."""
    table = pd.read_csv(run / "moving/ensemble.csv")
    files = study / "topology.pdb", study / "trajectory.xtc"
    molecule, streams = (
        read_molecule(*files, stride=500, residues="209-216"),
        Streams(ready[0]["seed"], "moving"),
    )
    last = evaluate_frames(molecule, StudySettings.of(ready[0]), streams, 1, part=(3, 3))
    assert last["frame"].tolist() == [1000] and last["d_kept"][0] == pytest.approx(
        table["d_kept"][2], abs=0.006
    )
    assert table["frame"].to_list() == [0, 500, 1000]
    first = pd.read_csv(run / "surfaces.csv").query("conformation == 'f0000'").iloc[0]
    assert table["N"][0] == first["N"] and table["mean_roughness"][0] == pytest.approx(
        first["mean_roughness"]
    )
    over_time = pd.read_csv(run / "moving/residues_over_time.csv").set_index("frame").drop(columns="time_ps")
    residues = pd.read_csv(run / "moving/residues.csv")
    assert np.allclose(residues["mean_roughness"], over_time.mean()) and residues["frames"].eq(3).all()
    of_first = pd.read_csv(run / "moving/f0000/residues.csv")["mean_roughness"]
    assert np.allclose(over_time.loc[0], of_first)
    assert not (run / "moving/ensemble").exists() or not list((run / "moving/ensemble").iterdir())


def test_samplers_are_compared_on_every_surface_and_over_all(run):
    tables = {place: pd.read_csv(run / place / "compare.csv") for place in SAMPLED}
    summary = pd.read_csv(run / "compare.csv")
    assert {"paper", "uniform", "farthest"} <= {*summary["sampler"]}
    key = {"sampler": "farthest", "percent": 20, "use": "surface", "measure": "Z full"}
    text = " and ".join(f"{name} == {value!r}" for name, value in key.items())
    values = pd.Series({place: table.query(text)["value"].item() for place, table in tables.items()})
    own = values.groupby(values.index.str.split("/").str[0]).mean()  # of each protein
    row = summary.query(text).iloc[0]
    assert row["n"] == len(own) == 3 and row["value"] == pytest.approx(own.mean())
    floors = pd.read_csv(run / "ready/c1/floors.csv").set_index("floor")["Z"]
    of_z = tables["ready/c1"].dropna(subset="Z_mean_descriptor")
    assert np.allclose(of_z["Z_resampled"], floors["fresh dots"], rtol=1e-4)


def test_the_papers_sampler_is_compared_with_the_winners_of_its_surface(run, ready):
    _, prepared = ready
    table = pd.read_csv(run / "ready/c1/compare.csv").query("sampler == 'paper'").groupby("percent")["n_S"]
    method = select_methods(prepared, ["paper"], read_table(run / "ready/c1/ranges.csv"))["paper"]
    for percent in (20, 40):
        n = round(percent / 100 * len(prepared))
        drawn = [len(method(n, prepared.stream("compare", "paper", n, k))) for k in range(2)]
        assert table.first()[percent] == pytest.approx(np.mean(drawn), rel=1e-3)


def test_the_grid_has_every_combination_with_the_numbers_of_its_subsets(run, ready):
    """In the order of the config; gamma and delta are no other way round, as their values differ."""
    config, prepared = ready
    grid = pd.read_csv(run / "ready/c1/grid.csv")
    wanted = [*itertools.product(*(config["sampling"][name] for name in PARAMETERS))]
    assert [tuple(row) for row in grid[[*PARAMETERS]].to_numpy()] == wanted
    for row in grid.to_dict("records"):
        drawn = [prepared.pair([row[name] for name in PARAMETERS], draw) for draw in range(2)]
        assert row["n_S"] == np.mean([len(sampled) for sampled, _ in drawn])


def test_the_scaled_link_takes_the_test_dots_and_draws_of_the_grid(run, ready, tmp_path):
    config, prepared = ready
    names = {"surface": "surface.npz"} | {name: f"{name}.csv" for name in ("roughness", "grid", "floors")}
    names |= {"distances": "distances.npz"}
    params = {name: config[name] for name in ("patches", "sampling", "seed")} | {
        "ranges": 10,
        "max_n_s_percent": 20,
    }
    params["evaluation"] = config["evaluation"] | {"readings": ["kept", "full", "kept_scaled"]}
    inputs = {name: str(run / "ready/c1" / file) for name, file in names.items()}
    files = {"ranges": "ranges.csv", "best": "best.json", "winners": "winners.npz"}
    outputs = {name: str(tmp_path / file) for name, file in files.items()}
    run_script("tabulate_best", tmp_path, inputs, outputs, params, protein="ready", conformation="c1")
    ranges = read_table(tmp_path / "ranges.csv")
    own = add_scaled_link(ranges, prepared, 20, 2)["d_kept_scaled"]
    assert np.allclose(ranges["d_kept_scaled"], own, atol=0.006, equal_nan=True) and own.notna().any()
    islands = ["link_over_spacing", "share_in_island"]
    own = add_islands(ranges.drop(columns=islands), {}, prepared, 20, 2)[islands]
    assert np.allclose(ranges[islands], own, rtol=1e-4, equal_nan=True)
    known = ranges.dropna(subset="d_cv")
    assert np.allclose(
        known["Z_resampled"], pd.read_csv(run / "ready/c1/floors.csv").set_index("floor")["Z"]["fresh dots"]
    )
    best = json.loads((tmp_path / "best.json").read_text())["kept"]["unrestricted"]
    grid = pd.read_csv(run / "ready/c1/grid.csv")
    assert best["d"] == pytest.approx(grid[grid["n_S_percent"] <= 100]["d_kept"].max(), abs=0.01)


def test_the_subsets_of_a_figure_are_those_of_its_words(run, ready, tmp_path, monkeypatch):
    config, prepared = ready
    drawn = []
    monkeypatch.setattr(subsets, "draw", drawn.append)
    monkeypatch.setattr(layout, "save", lambda *_: None)
    names = (
        "roughness.csv",
        "grid.csv",
        "best.json",
        "minimal.csv",
        "recovered.csv",
        "surface.npz",
        "reconstructed.npz",
    )
    inputs = {name.partition(".")[0]: str(run / "ready/c1" / name) for name in names}
    outputs = {"subsets": "figures/subsets.png", "bins": str(tmp_path / "bins.csv")}
    outputs |= {f"picture_{name}": str(tmp_path / f"{name}.png") for name in ("sampled", "minimal")}
    params = {name: config[name] for name in ("patches", "sampling", "evaluation", "minimal", "seed")}
    run_script("draw_figures", tmp_path, inputs, outputs, params, protein="ready", conformation="c1")
    best = json.loads((run / "ready/c1/best.json").read_text())["kept"]["unrestricted"]
    sampled, random = prepared.pair([best[name] for name in PARAMETERS], 0)
    minimal = pd.read_csv(run / "ready/c1/minimal.csv")["dot"]
    for (_, dots, _), kept in zip(drawn[0].subsets, (sampled, random, minimal), strict=True):
        assert np.allclose(dots.points, prepared.points[kept], atol=1e-4)
    words = [words.split()[0] for words, *_ in drawn[0].subsets]
    assert words == ["the", "random", "minimal"] and not np.array_equal(sampled, random)


def surfaces_of_pair(run, pair):
    """Surfaces of both partners."""
    places = {"both": ("moving/f0000", "still/f0"), "half": ("still/f0", "ready/c1")}.get(pair)
    files = [f"{place}/surface.npz" for place in places or ()]
    return [read_npz(run / file) for file in files or [f"pairs/{pair}/surface_{side}.npz" for side in (1, 2)]]


@pytest.mark.parametrize("pair", ["both", "half", "files"])
def test_a_pair_has_maps_of_both_partners(run, pair):
    folder, surfaces = run / "pairs" / pair, surfaces_of_pair(run, pair)
    dots = pd.read_csv(folder / "propensity.csv")
    assert dots.groupby("partner").size().tolist() == [len(surface) for surface in surfaces]
    assert np.allclose(
        dots[["x", "y", "z"]], np.concatenate([surface.points for surface in surfaces]), atol=1e-3
    )
    assert np.array_equal(dots["interface"] == 1, dots["gap"] < 3.0)
    assert dots["propensity_smoothed"].notna().all()
    names = {"propensity": "propensity_smoothed", "similarity_smoothed": "similarity_smoothed"}
    for side, of_side in dots.groupby("partner"):
        coloured = columns_of_ply(folder / f"partner_{side}.ply")
        for name, column in (names | {"interface": "interface"}).items():
            np.testing.assert_allclose(coloured[name], of_side[column], rtol=1e-4, atol=1e-9)
    touching = dots.query("partner == 1")["interface"].sum()
    contacts = pd.read_csv(folder / "contacts.csv")
    assert contacts["pairs"].tolist() == [min(touching, 500)] * (2 if touching > 1 else 0)
    areas = pd.read_csv(folder / "agreement.csv")
    for row in areas[~areas["score"].str.contains("protrusion")].to_dict("records"):
        of_side = dots[(dots["partner"] == row["partner"]) & dots["propensity"].notna()]
        inside = of_side["interface"] == 1
        assert (row["dots"], row["interface"]) == (len(of_side), inside.sum())
        assert row["auc"] == pytest.approx(
            auc(-of_side[row["score"]].to_numpy(), inside.to_numpy()), abs=6e-3
        )
    page = (run / "index.html").read_text(encoding="utf-8")
    link = f'href="pairs/{pair}/residues.csv"'
    assert (link in page) == (folder / "residues.csv").exists() == (pair != "half")


@pytest.mark.parametrize("pair", ["both", "files"])
def test_residues_of_partners_have_the_mean_of_their_dots(run, pair):
    folder = run / "pairs" / pair
    dots, residues = pd.read_csv(folder / "propensity.csv"), pd.read_csv(folder / "residues.csv")
    mean = dots.groupby(["partner", "residue"])["propensity_smoothed"].mean()
    assert np.allclose(residues["propensity_smoothed"], mean, rtol=1e-4)
    ends = ", ".join(f"{end:.3f}" for end in residues["propensity_smoothed"].quantile([0.05, 0.95]))
    assert f"partner_1 or partner_2, {ends}\n" in (folder / "open.pml").read_text()
    for side in (1, 2):
        written = read_study_structure(folder / f"partner_{side}.pdb")
        of_side = residues[residues["partner"] == side]["propensity_smoothed"].to_numpy()
        assert np.allclose(written.b_factor, of_side[written.residue_index], atol=6e-3)


def test_chains_of_a_complex_give_what_two_files_give(study, run):
    for name in ("propensity.csv", "best_pairs.csv", "residues.csv"):
        chains, files = (run / "pairs" / pair / name for pair in ("chains", "files"))
        assert chains.read_bytes() == files.read_bytes(), name
    atoms = [read_study_structure(run / f"pairs/files/structure_{side}.pdb").xyz for side in (1, 2)]
    assert np.allclose(atoms[0], read_molecule(study / "one.pdb").xyz)
    assert np.allclose(atoms[1], read_molecule(study / "two.pdb").xyz)
    for surface, xyz in zip(surfaces_of_pair(run, "files"), atoms, strict=True):
        assert np.linalg.norm(surface.points - xyz[0][surface.atom], axis=1).max() < 4  # of its own structure


def test_the_table_of_pairs_is_of_those_that_touch(run):
    table = pd.read_csv(run / "pairs/pairs.csv")
    assert table["complex"].unique().tolist() == ["half", "files", "chains"]
    of_pairs = table.groupby(["score", "complex"])["auc"].mean()
    mean, low, high = mean_interval(of_pairs["propensity_smoothed"])
    page = (run / "index.html").read_text(encoding="utf-8")
    assert f"AUC of {mean:.2f} ({max(low, 0):.2f} to {min(high, 1):.2f}) over 3 pairs" in re.sub(
        "<[^>]+>", "", page
    )
    assert "over 3 pairs" in page


@pytest.mark.parametrize("pair", ["half", "files"])
def test_the_page_of_a_pair_shows_each_partner_by_its_own_ranks(run, pair):
    """Dots of both partners, the second after the first, each with its rank among its own, its gap and its residue."""
    header, columns = unpacked((run / "pairs" / pair / "view.html").read_text(encoding="utf-8"))
    dots = pd.read_csv(run / "pairs" / pair / "propensity.csv", low_memory=False)
    assert header["dots"]["total"] == len(dots)
    ranks = dots.groupby("partner")["propensity_smoothed"].rank(pct=True) * 100
    for name, wanted in (("rank", ranks), ("gap", dots["gap"])):
        (k,) = (k for k, scale in enumerate(header["values"]) if scale["symbol"] == name)
        scale = header["values"][k]
        shown = scale["low"] + columns[f"value {k}"] / 254 * (scale["high"] - scale["low"])
        inside = np.clip(wanted, scale["low"], scale["high"])
        assert np.abs(shown - inside).max() < 0.02 * (scale["high"] - scale["low"]), name
    labels = np.array([*header["residues"], ""])[columns["residue"]]
    for side in (1, 2) if pair == "files" else (1,):  # the second of `half` has no residues
        of_side = (dots["partner"] == side).to_numpy()
        assert all(label.endswith(f", partner {side}") for label in labels[of_side])
        numbers = [re.search(r"\d+", label)[0] for label in labels[of_side]]
        assert numbers == dots["residue"][of_side].astype(float).astype(int).astype(str).tolist()


def test_a_partner_of_a_complex_has_all_of_its_chains(tmp_path):
    parts = [("C", ("ALA",)), ("A", ("ALA", "LYS")), ("B", ("ALA", "LYS", "SER"))]
    texts = [peptide(names, chain, origin=(0, 9.0 * k, 0)) for k, (chain, names) in enumerate(parts)]
    path = write(tmp_path / "three.pdb", "TER\n".join(texts) + "END\n")
    outputs = {
        f"{kind}_{side}": str(tmp_path / f"{kind}{side}.{end}") for kind, end in KINDS for side in (1, 2)
    }
    params = {"pair": {"complex": "three.pdb", "chains": [["B", "C"], ["A"]]}}
    params |= {"surface": Settings(surface={"density": 6.0}).surface.model_dump(), "d_link": 0.5}
    run_script("compute_partner_surfaces", tmp_path, {"files": str(path)}, outputs, params, pair="p")
    for side, chains in ((1, {"B", "C"}), (2, {"A"})):
        structure = read_study_structure(outputs[f"structure_{side}"])
        dots = read_npz(outputs[f"surface_{side}"])
        assert {*structure.chain} == chains == {*structure.chain[dots.atom]}
        assert len(dots) / dots.area.sum() == pytest.approx(6.0, rel=0.15)


def test_the_interface_is_drawn_in_vermillion(run):
    """Where there is one: the partners of `both` do not touch."""

    def share(pair):
        red, green, blue = np.moveaxis(imread(run / "pairs" / pair / "book.png")[..., :3], -1, 0)
        return ((red > 0.55) & (green < 0.5) & (blue < 0.15)).mean()

    assert share("files") > 0.003 and share("both") == 0


def test_two_forms_are_compared_residue_by_residue(run):
    folder = run / "changes" / "bend"
    changes = pd.read_csv(folder / "changes.csv")
    assert changes["residue"].tolist() == list(range(209, 217))
    forms = [read_study_structure(folder / f"changed_{side}.pdb") for side in (1, 2)]
    for form in forms:
        over_floor = (changes["total"] / changes[["total_floor", "total_moved"]].max(axis=1)).to_numpy()
        assert np.allclose(form.b_factor, over_floor[form.residue_index], atol=6e-3)
    first, before = (
        read_study_structure(run / f"moving/{name}/structure.pdb").xyz[0] for name in ("f0700", "f0000")
    )
    assert np.allclose(forms[0].xyz[0], first, atol=2e-3)
    away = [np.sqrt(np.mean((atoms - first) ** 2)) for atoms in (forms[1].xyz[0], before)]
    assert away[0] < away[1] and np.allclose(pdist(forms[1].xyz[0]), pdist(before), atol=6e-3)
    files = [
        (run / f"moving/{name}/surface.npz", run / f"moving/{name}/structure.pdb")
        for name in ("f0700", "f0000")
    ]
    both = read_forms(
        "bend", dict(zip(("moving/f700", "moving/f0"), files, strict=True)), Settings().surface, 0.5
    )
    described = [describe_residues(form.surface, form.molecule, form.name) for form in both]
    own = distances(*(residues.moments for residues in described))
    assert np.allclose(changes[[*MOMENT_CHANNELS, "total"]], own, rtol=1e-4)
    difference = described[1].fields - described[0].fields
    assert np.allclose(
        changes[[f"{name}_difference" for name in MOMENT_FIELDS]], difference, rtol=1e-3, atol=1e-6
    )


def test_a_residue_without_a_change_has_the_b_factor_of_buried_ones(run, ready, tmp_path, monkeypatch):
    compare = changes.changes

    def with_one_unknown(*given):
        table = compare(*given)
        table.loc[table["residue"] == "210", ["total", "total_floor", "total_moved"]] = np.nan
        return table

    monkeypatch.setattr(changes, "changes", with_one_unknown)
    names = {"surface": "surface.npz", "structure": "structure.pdb"}
    places = {1: run / "moving/f0700", 2: run / "moving/f0000"}
    inputs = {f"{key}_{side}": place / names[key] for side, place in places.items() for key in names}
    outputs = {"changes": "changes.csv", "pdb_1": "1.pdb", "pdb_2": "2.pdb"}
    outputs = {key: str(tmp_path / name) for key, name in outputs.items()}
    params = {"forms": ["moving/f700", "moving/f0"], "seed": 0, "d_link": ready[0]["patches"]["d_link"]}
    params |= {"surface": ready[0]["surface"]}
    run_script("compare_forms", tmp_path, inputs, outputs, params, comparison="bend")
    for side in (1, 2):
        written = read_molecule(outputs[f"pdb_{side}"])
        assert {*written.residue[written.b_factor == -1]} == {"210"}


def test_pages_of_two_forms_show_them_superposed_with_what_changes_in_front(run):
    """Seen from the viewer, around their middle, the dots of the two forms lie nearer to each other than in their files."""
    shown, as_given = [], []
    for side, form in ((1, "f0700"), (2, "f0000")):
        text = (run / f"changes/bend/view_{side}.html").read_text(encoding="utf-8")
        assert f"<title>bend, moving/f{int(form[1:])}</title>" in text
        header, columns = unpacked(text)
        dots = np.column_stack([columns[axis] for axis in "xyz"]) * header["dots"]["step"]
        shown.append((dots - dots.mean(axis=0)) @ np.reshape(header["turn"], (3, 3)).T)
        points = read_npz(run / f"moving/{form}/surface.npz").points
        as_given.append(points - points.mean(axis=0))
        assert np.allclose(np.ptp(pdist(shown[-1][::40])), np.ptp(pdist(as_given[-1][::40])), atol=0.02)
        change = np.where(columns["value 1"] == 255, 0, columns["value 1"])
        most = change >= np.quantile(change, 0.9)
        if side == 1:
            assert shown[0][most, 2].mean() > shown[0][:, 2].mean()
    apart = [np.median(cKDTree(one).query(other)[0]) for one, other in (shown, as_given)]
    assert apart[0] < 0.9 * apart[1]


def checksum_of(path):
    """The words by which a page names a file."""
    return f"{path.name}, SHA-256 {hashlib.sha256(path.read_bytes()).hexdigest()}"


def test_each_page_of_a_surface_says_which_file_and_atoms_it_is_from(run):
    for place in CONFORMATIONS:
        structure = run / place / "structure.pdb"
        file = structure if structure.is_file() else run / place / "surface.npz"
        for page in ("surface.html", "view.html"):
            rows = origin_of(run / place / page)
            assert rows["file"] == checksum_of(file) and rows["version"] == f"sparsurf {__version__}"
            assert structure.is_file() == ("atoms" in rows) == ("surface" in rows) and "date" not in rows
    for side, form in ((1, "f0700"), (2, "f0000")):
        rows = origin_of(run / f"changes/bend/view_{side}.html")
        assert rows["file"] == checksum_of(run / f"moving/{form}/structure.pdb")
        assert (
            int(rows["atoms"].split()[0])
            == read_study_structure(run / f"moving/{form}/structure.pdb").n_atoms
        )


def test_the_page_of_a_pair_says_from_which_files_its_partners_are(run):
    pairs = sorted((run / "pairs").glob("*/view.html"))
    assert pairs
    for pair in pairs:
        rows = origin_of(pair)
        files = {rows[f"file of partner {side}"] for side in (1, 2)}
        paths = [path for path in run.glob("*/*/s*") if path.name.startswith(("structure", "surface"))]
        checksums = {checksum_of(path) for path in paths if path.suffix in (".pdb", ".npz")}
        assert files <= checksums and len(files) == 2 and rows["version"] == f"sparsurf {__version__}"


def test_a_form_with_another_chain_is_drawn_in_the_colours_of_its_change(run, tmp_path, monkeypatch, ready):
    """As in the table, whose residues have the chain of the first form."""
    monkeypatch.setattr(layout, "save", lambda *_: None)
    inputs = {"changes": run / "changes/bend/changes.csv"}
    for side, form in ((1, "f0700"), (2, "f0000")):
        structure = read_study_structure(run / f"moving/{form}/structure.pdb")
        chain = np.full_like(structure.chain, "Y") if side == 2 else structure.chain
        replace(structure, chain=chain).write_pdb(tmp_path / f"{side}.pdb")
        inputs |= {
            f"surface_{side}": run / f"moving/{form}/surface.npz",
            f"structure_{side}": tmp_path / f"{side}.pdb",
        }
    outputs = {"png": "x.png"} | {f"view_{side}": tmp_path / f"{side}.html" for side in (1, 2)}
    params = {name: ready[0][name] for name in ("surface", "patches", "sampling", "seed")}
    params["forms"] = ["moving/f700", "moving/f0"]
    run_script("draw_changes", tmp_path, inputs, outputs, params, comparison="bend")
    for side in (1, 2):
        paths = (tmp_path / f"{side}.html", run / f"changes/bend/view_{side}.html")
        ours, of_study = (unpacked(path.read_text(encoding="utf-8"))[1]["value 1"] for path in paths)
        assert np.array_equal(ours, of_study) and len(np.unique(ours)) > 2


def test_a_comparison_of_samplers_names_its_surface(run, tmp_path, monkeypatch, ready):
    """And compares those samplers alone, at those sizes, that it is asked for."""
    config, saved = ready[0], []
    monkeypatch.setattr(layout, "save", lambda figure, path: saved.append(figure))
    inputs = {name: str(run / f"ready/c1/{name}.csv") for name in ("roughness", "ranges", "floors")}
    inputs |= {"surface": str(run / "ready/c1/surface.npz"), "structure": []}
    params = {name: config[name] for name in ("patches", "sampling", "seed")}
    params |= {
        "evaluation": {"test_dots": 5, "draws": 1, "readings": ["kept", "full"]},
        "title": "mine",
        "percents": [30],
    }
    params["samplers"] = ["uniform", "farthest"]
    outputs = {"table": str(tmp_path / "compare.csv"), "png": "compare.png"}
    run_script("compare_samplers", tmp_path, inputs, outputs, params, protein="ready", conformation="c1")
    table = pd.read_csv(tmp_path / "compare.csv")
    assert {*table["sampler"]} == {"uniform", "farthest"} and {*table["percent"]} == {30}
    assert any(text.get_text().startswith("mine") for text in saved[0].findobj(Text))


def test_tables_over_all_surfaces_have_a_row_for_each(run):
    for name, places in (("surfaces", CONFORMATIONS), ("summary", SAMPLED)):
        table = pd.read_csv(run / f"{name}.csv")
        assert {*(table["protein"] + "/" + table["conformation"])} == {*places}
    assert len(pd.read_csv(run / "summary.csv")) == 4 * 2 * 10  # surfaces, readings, ranges


def test_the_tables_of_the_paper_stand_beside_ours(run):
    rows = pd.read_csv(run / "paper_rows.csv")
    assert len(rows) == 10 and {"d_published", "d_kept"} <= {*rows.columns}
    floor = pd.read_csv(run / "ready/c1/floors.csv").set_index("floor")["Z"]["fresh dots"]
    assert np.allclose(rows["Z_resampled"], floor, rtol=1e-4)
    assert re.search(r"\b8 combinations", (run / "verdict.html").read_text())


def test_warnings_of_all_jobs_are_in_one_table(run):
    table = pd.read_csv(run / "warnings.csv")
    assert table.columns.to_list() == ["protein", "conformation", "job", "sentence"]
    frames = table[table["job"] == "choose_frames"]
    assert {"loaded", "still"} <= {*frames["protein"]} and frames["sentence"].str.contains("lack heavy").all()
    assert not table.duplicated(["protein", "conformation", "sentence"]).any()


def test_the_glossary_has_the_lengths_of_the_config(run):
    page = html.unescape((run / "index.html").read_text(encoding="utf-8"))
    assert "within 4 Å for roughness and sampling, within 6 Å for descriptors" in page
    assert "dots within 3 Å of the partner's surface" in page


def test_the_first_page_leads_to_every_page_and_figure(run):
    text = (run / "index.html").read_text()
    links = {unquote(path) for path in re.findall(r'href="([^"]+)"', text)}
    found = {str(path.relative_to(run)) for end in ("html", "png") for path in run.rglob(f"[!.]*.{end}")}
    found = {path for path in found if not path.endswith("view.png")}  # on the page of the viewer
    found -= {"index.html"}
    pictures = {path for path in found if "/pictures/" in path}  # shown on it
    shown = re.findall(
        r'alt="(The surface of \S+ in the|The dots that the best|The [\d,]+ dots of the minimal)', text
    )
    assert len(shown) == len(pictures) > 10
    found -= pictures
    assert found <= links and len(found) > 45
    assert not [path for path in links if not path.startswith("#") and not (run / path).exists()]


def test_the_crate_describes_every_file(run):
    graph = json.loads((run / "ro-crate-metadata.json").read_text())["@graph"]
    files = {unquote(part["@id"]): part["contentSize"] for part in graph if part["@type"] == "File"}
    assert files == {path: str((run / path).stat().st_size) for path in files}
    written = {str(path.relative_to(run)) for path in run.rglob("[!.]*") if path.is_file()}
    # not listed: what only other rules read
    unlisted = ("logs/", "loaded/download/", "ro-crate-", "SHA256SUMS")
    unlisted += tuple(
        f"pairs/{pair}/{kind}_" for pair in ("files", "chains") for kind in ("structure", "surface")
    )
    listed = {path for path in written if not path.startswith(unlisted)}
    assert {*files} == {path for path in listed if not path.endswith("/reconstructed.npz")}


def test_every_figure_is_a_picture(run):
    pictures = [*run.rglob("*.png")]
    assert len(pictures) > 30 and all(path.read_bytes()[:4] == b"\x89PNG" for path in pictures)
    assert {path.with_suffix(".png") for path in run.rglob("*.svg")} <= {*pictures}


@pytest.mark.parametrize("is_batch", [False, True], ids=["pages", "batches"])
def test_snakemake_has_no_advice_on_any_rule(tmp_path, is_batch):
    """`snakemake --lint` of the default study, as `make test` runs it, sees only the rules that this study includes."""
    config = write_study(tmp_path)
    if is_batch:
        proteins = {f"p{k}": {"structure": "still.pdb"} for k in range(12)}
        config = {"run": "many", "sampling": False, "proteins": proteins}
    else:
        config["proteins"]["simulated"] = {"structure": "still.pdb", "simulate": {}}
    done = snakemake(tmp_path, config, "--lint")
    assert done.returncode == 0 and "Lints for" not in output(done), output(done)
