"""One combination over frames: the same rows whatever the threads and interruptions, and the chain's own surface."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import follow_ensemble
from drawn import check_texts, drawn_texts
from peptides import peptide, write
from sparsurf import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.report.figures import over_time
from sparsurf.study import ensemble
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.study.residues import residue_table, roughness_over_frames
from sparsurf.surfaces.molecular_surface import density_for_d_link, molecular_surface
from sparsurf.surfaces.radii import radii

SETTINGS = {
    "surface": {
        "method": "analytic", "probe_radius": 1.4, "density": 6.0, "radii": "dms", "reentrant": "exact",
    },
    "patches": {"R_patch": 4.0, "R_zernike": 6.0, "D_link": 0.6},
    "sampling": {"distance_from_moved_centre": True, "chance_in_every_patch": True},
    "evaluation": {"readings": ["as_coded", "as_written"]},
    "ensemble": {"combination": [1.0, 0.0, 6.0, 0.0], "test_dots": 20, "draws": 2, "stride": 1},
    "seed": 3,
}  # fmt: skip
FRAMES = 7


def followed(*arguments, **keys):
    """The table of all frames, followed in one part."""
    return ensemble.join_parts([ensemble.evaluate_frames(*arguments, **keys)])


@pytest.fixture(scope="module")
def molecule(tmp_path_factory):
    """Seven models of a peptide, the last residue farther out in each."""
    models = ""
    for k in range(FRAMES):
        models += f"MODEL     {k + 1:4d}\n{peptide()}{peptide(['ALA'], 'B', 9, (0, 0, 4 + 0.5 * k))}ENDMDL\n"
    return read_molecule(write(tmp_path_factory.mktemp("models") / "m.pdb", models + "END\n"))


@pytest.fixture(scope="module")
def table(molecule, tmp_path_factory):
    return followed(molecule, SETTINGS, "p", 1, tmp_path_factory.mktemp("one") / "part")


def test_one_row_per_frame_in_order(table):
    assert table["frame"].tolist() == list(range(FRAMES))
    assert table["time_ps"].isna().all()
    first = ["frame", "time_ps", "N", "area", "mean_roughness", "n_S", "n_S_percent", "n_S_expected"]
    assert table.columns[:8].tolist() == first
    for reading in ("as_coded", "as_written"):
        for name in ("Z_tS", "Z_tR", "d"):
            assert np.isfinite(table[f"{name}_{reading}"]).all()
            assert (table[f"{name}_se_{reading}"] > 0).all()
        difference = table[f"Z_tR_{reading}"] - table[f"Z_tS_{reading}"]
        assert np.allclose(table[f"d_{reading}"], difference, atol=1e-9)


def test_the_table_leaves_nothing_of_other_parts(molecule, table, tmp_path):
    """A run with three jobs was killed, one with two has ended."""
    folder = tmp_path / "ensemble"
    folder.mkdir()
    rows = [folder / f"{k}of2.csv" for k in (1, 2)]
    for k, path in enumerate(rows, 1):
        path.write_text(ensemble.evaluate_frames(molecule, SETTINGS, "p", 1, tmp_path / "part", part=(k, 2)))
    for name in ("1of3.csv", "2of3.csv.part", "1of2.csv.part"):
        (folder / name).write_text("")
    molecule.write_pdb(tmp_path / "own.pdb")
    outputs = {name: tmp_path / f"{name}.csv" for name in ("table", "over_time", "residues")}
    structure = tmp_path / "own.pdb"
    follow_ensemble.main(structure=structure, trajectory=None, rows=rows, molecule_options={}, **outputs)
    assert sorted(folder.iterdir()) == rows
    assert len(pd.read_csv(outputs["table"])) == len(table)


def test_a_row_is_what_the_parts_give(molecule, table):
    surface = molecular_surface(molecule.xyz[3], radii(molecule), density=6.0)
    prepared = PreparedSurface(surface, d_link=0.6, seed=3, name="p/f3")
    row = table.iloc[3]
    assert row["N"] == len(surface) and row["area"] == surface.area.sum()
    assert row["mean_roughness"] == prepared.roughness.mean()
    kept = [len(prepared.pair([1, 0, 6, 0], draw)[0]) for draw in range(2)]
    assert row["n_S"] == np.mean(kept)
    assert row["n_S_percent"] == pytest.approx(100 * np.mean(kept) / len(surface))
    timed = replace(molecule, time_ps=10.0 * np.arange(FRAMES))
    assert ensemble.frame_row(timed, 3, radii(molecule), SETTINGS, "p")["time_ps"] == 30


def test_threads_change_no_bit(molecule, table, tmp_path):
    two = followed(molecule, SETTINGS, "p", 2, tmp_path / "part")
    assert two.to_csv() == table.to_csv()


@pytest.mark.parametrize("n", [2, 3, 9])
def test_parts_gathered_are_the_whole_to_the_last_byte(molecule, tmp_path, n):
    """Seven frames; nine parts leave two without any."""
    whole = ensemble.evaluate_frames(molecule, SETTINGS, "p", 1, tmp_path / "whole")
    parts = [
        ensemble.evaluate_frames(molecule, SETTINGS, "p", 1, tmp_path / f"{k}", part=(k, n))
        for k in range(1, n + 1)
    ]
    assert "".join(parts) == whole and whole.count("\n") == FRAMES + 1
    assert sum(bool(part) for part in parts) == min(n, FRAMES)


def test_rows_of_another_part_are_not_taken_up_and_a_part_counts_its_own_frames(molecule, tmp_path):
    told = []
    for part in ((1, 2), (1, 7), (2, 2)):
        text = ensemble.evaluate_frames(
            molecule, SETTINGS, "p", 1, tmp_path / "part", part=part, progress=lambda *done: told.append(done)
        )
        if part == (1, 7):
            assert text.count("\n") == 2  # a header and a frame, not the three that lay there
    assert told == [(3, 3), (1, 1), (4, 4)]


def test_the_density_that_suits_the_first_frame_is_that_of_all(molecule, tmp_path):
    auto = SETTINGS | {"surface": SETTINGS["surface"] | {"density": "auto"}}
    table = followed(molecule, auto, "p", 1, tmp_path / "part", part=(1, 1))
    own = radii(molecule)
    density = density_for_d_link(molecule, 0, own, auto["surface"], 0.6, "p")
    assert table["N"].tolist() == [len(molecular_surface(xyz, own, density=density)) for xyz in molecule.xyz]


@pytest.mark.parametrize("cut", [0, 10, 60, 700, 1500, -1, None])
def test_a_killed_run_is_taken_up_again(molecule, table, tmp_path, monkeypatch, cut):
    # two frames per write; killed after the third write, and the partial file cut anywhere at that
    path, done = tmp_path / "part", []
    monkeypatch.setattr(ensemble, "FRAMES_PER_WRITE", 2)

    def killed(count, of):
        if count >= 6:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        followed(molecule, SETTINGS, "p", 1, path, progress=killed)
    path.write_bytes(path.read_bytes()[:cut])
    again = followed(molecule, SETTINGS, "p", 2, path, progress=lambda count, of: done.append(count))
    assert again.to_csv() == table.to_csv()
    if cut is None:
        assert done == [7]  # only the frame that was missing
    if cut == -1:
        assert done == [7]  # a torn row is made anew
    if cut == 0:
        assert done == [2, 4, 6, 7]


def test_a_finished_part_needs_no_frame(molecule, table, tmp_path, monkeypatch):
    followed(molecule, SETTINGS, "p", 1, tmp_path / "part")
    monkeypatch.setattr(ensemble, "frame_row", None)
    assert followed(molecule, SETTINGS, "p", 1, tmp_path / "part").to_csv() == table.to_csv()


def test_rows_of_other_settings_are_not_taken_up(molecule, tmp_path):
    part = tmp_path / "part"
    followed(molecule.frame(0), SETTINGS, "p", 1, part)
    mark = part.read_text().split("\n")[0] + "\n"
    assert len(ensemble.read_finished_rows(part, mark)[1]) == 1
    one = molecule.frame(0)
    other = SETTINGS | {"seed": 4}
    marks = {
        ensemble.fingerprint(one, SETTINGS, "p", ""), ensemble.fingerprint(one, other, "p", ""),
        ensemble.fingerprint(one, SETTINGS, "q", ""), ensemble.fingerprint(one, SETTINGS, "p", "new"),
        ensemble.fingerprint(molecule.frame(1), SETTINGS, "p", ""),
    }  # fmt: skip
    assert len(marks) == 5 and mark == f"# {ensemble.fingerprint(one, SETTINGS, 'p', '')} 1 of 1\n"
    anew = followed(one, other, "p", 1, part)
    before = followed(one, SETTINGS, "p", 1, tmp_path / "another")
    assert len(anew) == 1 and anew["d_as_coded"][0] != before["d_as_coded"][0]


def test_a_surface_that_is_too_sparse_is_refused(molecule, tmp_path):
    sparse = SETTINGS | {"surface": SETTINGS["surface"] | {"density": 2.0}}
    with pytest.raises(InputError, match="p, frame 0: D_link"):
        followed(molecule, sparse, "p", 1, tmp_path / "part")


def test_the_frame_of_an_error_is_named(molecule, tmp_path):
    without = SETTINGS | {"surface": SETTINGS["surface"] | {"method": "dms"}}
    with pytest.raises(InputError, match=r"p, frame 0: .*program dms"):
        followed(molecule, without, "p", 1, tmp_path / "part")


def invented(n, time=True, readings=("as_coded", "as_written")):
    """A table like ensemble.csv of invented numbers."""
    rng, k = np.random.default_rng(n), np.arange(n)
    out = pd.DataFrame({"frame": k, "time_ps": 50.0 * k if time else np.full(n, np.nan)})
    out["n_S_percent"] = 46 + rng.normal(size=n)
    out["mean_roughness"] = 0.6 + 0.01 * np.sin(k / 50)
    for j, reading in enumerate(readings):
        out[f"d_{reading}"] = (2.1, 0.0)[j] + 0.1 * rng.normal(size=n)
        out[f"d_se_{reading}"] = 0.1
    return out


@pytest.mark.parametrize(
    "table",
    [
        invented(400),
        invented(12),
        invented(1),
        invented(70, time=False),
        invented(40, readings=["as_written"]),
    ],
    ids=["long", "short", "one frame", "no times", "one reading"],
)
@pytest.mark.filterwarnings("error")
def test_figure_draws_with_texts_apart_and_inside(table, monkeypatch):
    check_texts(over_time.ensemble_figure(table, [1, 0, 6, 0]), monkeypatch)


def test_moving_mean_is_the_mean_of_its_window():
    table = invented(100)
    ax = over_time.ensemble_figure(table, [1, 0, 6, 0]).axes[0]
    line = ax.lines[1].get_ydata()
    assert line[50] == pytest.approx(table["n_S_percent"][48:53].mean())  # five frames, centred


def test_residues_of_a_frame_are_those_of_its_surface(molecule, table):
    by_frame, over_time = ensemble.split_residue_columns(table, molecule.residues)
    assert not [name for name in by_frame if name.startswith("residue")]
    assert over_time.columns.tolist() == ["frame", "time_ps", *(f"A:ALA{k}" for k in range(1, 5)), "B:ALA9"]
    surface = molecular_surface(molecule.xyz[3].round(3), radii(molecule, "dms"), density=6.0)
    rough = PreparedSurface(surface, d_link=0.6).roughness
    expected = residue_table(surface, rough, molecule)["mean_roughness"]
    assert np.allclose(over_time.iloc[3, 2:].to_numpy(float), expected, atol=1e-12)


def test_walls_of_cavities_do_not_count_in_the_roughness_of_a_residue(molecule, table, monkeypatch):
    below = []

    def on_cavities(surface, components):
        below.append(surface.points[:, 2] < np.median(surface.points[:, 2]))
        return below[0]

    monkeypatch.setattr(ensemble, "on_cavities", on_cavities)
    row = ensemble.frame_row(molecule, 3, radii(molecule, "dms"), SETTINGS, "p")
    surface = molecular_surface(molecule.xyz[3].round(3), radii(molecule, "dms"), density=6.0)
    rough, residue = PreparedSurface(surface, d_link=0.6).roughness, molecule.residue_index[surface.atom]
    for k in range(molecule.n_residues):
        inside = (residue == k) & ~below[0]
        assert row[f"residue_{k}"] == pytest.approx(rough[inside].mean(), abs=1e-12, nan_ok=True)
    assert row["mean_roughness"] == pytest.approx(table["mean_roughness"][3])  # of all dots


def test_figure_of_the_residues_has_every_text_in_place(molecule, table, monkeypatch):
    rows = ensemble.split_residue_columns(table, molecule.residues)[1]
    rows.iloc[2, 3] = np.nan  # buried for a while
    residues = roughness_over_frames(molecule.residues, rows.iloc[:, 2:].to_numpy(float))
    figure = over_time.residues_figure(rows, residues)
    texts = drawn_texts(figure, monkeypatch)
    words = [text for text, _ in texts]
    assert {"A 1", "A 4", "B 9", "frame", "residue"} <= set(words)
    assert any("grey: buried" in text for text in words)
    check_texts(figure, monkeypatch)


def test_the_mark_of_a_part_follows_all_that_its_rows_depend_on(molecule):
    moved = replace(molecule, xyz=molecule.xyz + 0.001)
    later = replace(molecule, time_ps=np.arange(FRAMES) * 1.0)
    other = replace(molecule, element=np.where(molecule.element == "C", "N", molecule.element))
    calls = [
        (molecule, SETTINGS, "p", "code"),
        (moved, SETTINGS, "p", "code"),
        (later, SETTINGS, "p", "code"),
    ]
    calls += [(other, SETTINGS, "p", "code"), (molecule, SETTINGS | {"seed": 4}, "p", "code")]
    calls += [(molecule, SETTINGS, "q", "code"), (molecule, SETTINGS, "p", "edited")]
    marks = [ensemble.fingerprint(*each) for each in calls]
    assert len(set(marks)) == len(calls)
    assert ensemble.fingerprint(*calls[0]) == marks[0]
