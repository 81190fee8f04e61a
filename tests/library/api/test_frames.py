"""The tables of all frames: the numbers of each frame alone, the same bytes whatever stops and jobs, and bad trajectories."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import sparsurf
from conftest import ROOT
from peptides import peptide, write
from sparsurf.api import frames as api
from sparsurf.cli import command
from sparsurf.errors import InputError
from sparsurf.evaluation.ranking import rank_residues, why_none_is_ranked

TDP43 = ROOT / "data" / "tdp43"
FIELDS = ["hydropathy", "mean_curvature"]


def models(n):
    """Models of a peptide whose last residue lies farther out in each; one residue in the middle of the others is buried."""
    text = ""
    for k in range(n):
        text += f"MODEL     {k + 1:4d}\n{peptide()}{peptide(['ALA'], 'B', 9, (0, 0, 4 + 0.5 * k))}ENDMDL\n"
    return text + "END\n"


@pytest.fixture
def seven(tmp_path, monkeypatch):
    """A file of seven models; three frames are stored together."""
    monkeypatch.setattr(api, "FRAMES_PER_PART", 3)
    return write(tmp_path / "m.pdb", models(7))


def test_the_numbers_of_a_frame_are_those_of_its_surface(seven):
    molecule, tables = sparsurf.read_molecule(seven), sparsurf.frames(seven, fields=FIELDS)
    assert tables.frames["frame"].tolist() == list(range(7)) and tables.frames["time_ps"].isna().all()
    for k in (0, 6):
        dots = sparsurf.surface(molecule, frame=k)
        values = sparsurf.fields(dots, FIELDS)
        with_fields = replace(dots, fields={name: values[name].to_numpy() for name in FIELDS})
        alone = sparsurf.residues(with_fields)
        row, table = tables.frames.loc[k], tables.residues[tables.residues["frame"] == k]
        parts = sparsurf.components(dots)[1]
        signs = np.where(parts["cavity"], -1, 1)
        assert row["area"] == dots.total_area and row["dots"] == len(dots)
        assert row["volume"] == pytest.approx(signs @ parts["volume"]) and row["components"] == len(parts)
        assert row["mean_roughness"] == pytest.approx(sparsurf.roughness(dots).mean())
        labels = ["chain", "residue", "residue_name"]
        assert table[labels].to_numpy().tolist() == alone[labels].to_numpy().tolist()
        for name in ("area", "mean_roughness", "depth", "mean_hydropathy", "mean_mean_curvature"):
            np.testing.assert_allclose(table[name], alone[name], rtol=1e-12)


def test_the_areas_of_a_frame_are_exact(seven):
    """Of two chains, whose contact is not the same in all models."""
    tables = sparsurf.frames(seven)
    for k in (0, 6):
        exact, table = sparsurf.areas(seven, frame=k), tables.residues[tables.residues["frame"] == k]
        for name in ("accessible", "relative", "buried"):
            np.testing.assert_allclose(table[name], exact.residues[name], atol=1e-9)
        for name in ("accessible", "buried"):
            assert tables.frames[name][k] == pytest.approx(exact.chains[name].sum())
    assert tables.frames["buried"].nunique() == 7 and (tables.frames["buried"] > 1).all()


def test_areas_alone_are_those_beside_dots(seven, tmp_path):
    tables, alone = sparsurf.frames(seven), sparsurf.frames(seven, only_areas=True)
    columns = [*alone.residues]
    assert columns[-3:] == ["accessible", "relative", "buried"] and [*alone.frames][2:] == [
        "accessible",
        "buried",
    ]
    pd.testing.assert_frame_equal(alone.residues, tables.residues[columns])
    pd.testing.assert_frame_equal(alone.frames, tables.frames[[*alone.frames]])
    pd.testing.assert_frame_equal(alone.contacts, tables.contacts)
    by_area = sparsurf.frames(seven, rank="accessible").ranking
    changing = ["residue", "mean", "sd", "range"]  # which of them is ranked depends on the area that is known
    pd.testing.assert_frame_equal(
        alone.ranking[changing].sort_values(changing, ignore_index=True),
        by_area[changing].sort_values(changing, ignore_index=True),
    )
    assert command.main(["frames", str(seven), "--only-areas", "-q", "-o", str(tmp_path / "x.csv")]) == 0
    written = pd.read_csv(tmp_path / "x.csv")
    assert [*written] == columns
    np.testing.assert_allclose(written["buried"], alone.residues["buried"], rtol=1e-8)
    for wrong in ({"fields": "hydropathy"}, {"rank": "depth"}):
        with pytest.raises(InputError, match="only_areas"):
            sparsurf.frames(seven, only_areas=True, **wrong)


def test_accessible_areas_follow_the_rule_of_cavities():
    """Against the area of dots at the centres of the probe, which fits into four cavities of the peptide."""
    molecule, exact, of_dots = sparsurf.read_molecule(TDP43 / "topology.pdb"), [], []
    for rule in ("keep", "remove"):
        exact.append(sparsurf.frames(molecule, cavities=rule).frames["accessible"][0])
        dots = sparsurf.surface(molecule, boundary="accessible", cavities=rule, density=40)
        of_dots.append(dots.area.sum())
    assert exact[0] - exact[1] == pytest.approx(of_dots[0] - of_dots[1], rel=0.2) and exact[0] > exact[1] + 1


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_stopped_run_continues_to_the_same_bytes(seven, tmp_path, monkeypatch, suffix):
    """Stopped in the second part; the first is not measured again."""
    if suffix == ".parquet":
        pytest.importorskip("pyarrow")
    sparsurf.frames(seven, path=tmp_path / f"whole{suffix}")
    sparsurf.frames(seven, path=tmp_path / f"jobs{suffix}", jobs=2)
    measured, part_of_frames = [], api.part_of_frames

    def stopping(molecule, request, first, last):
        measured.append(first)
        if len(measured) == 2:
            raise KeyboardInterrupt
        return part_of_frames(molecule, request, first, last)

    monkeypatch.setattr(api, "part_of_frames", stopping)
    with pytest.raises(KeyboardInterrupt):
        sparsurf.frames(seven, path=tmp_path / f"run{suffix}")
    assert not (tmp_path / f"run{suffix}").exists()
    written = sparsurf.frames(seven, path=tmp_path / f"run{suffix}")
    assert (written.n_frames, written.n_before) == (7, 3)
    assert measured == [0, 3, 3, 6]
    for name in ("run", "jobs"):
        for end in ("", "_frames", "_ranking", "_contacts"):
            whole = (tmp_path / f"whole{end}{suffix}").read_bytes()
            assert (tmp_path / f"{name}{end}{suffix}").read_bytes() == whole
    assert not list(tmp_path.glob(".*"))
    read = pd.read_csv if suffix == ".csv" else pd.read_parquet
    in_memory = sparsurf.frames(seven)
    pd.testing.assert_frame_equal(
        read(tmp_path / f"run{suffix}").astype({"residue": str}),
        in_memory.residues,
        check_dtype=False,
        rtol=1e-8,
    )


@pytest.mark.parametrize(
    ("rank", "column"), [("roughness", "mean_roughness"), ("area", "area"), ("hydropathy", "mean_hydropathy")]
)
@pytest.mark.parametrize("by", ["sd", "range"])
def test_residues_are_ranked_by_how_much_they_change(seven, rank, column, by):
    """The moving residue has most area to gain, and buried residues have no roughness in some frames."""
    tables = sparsurf.frames(seven, rank=rank, rank_by=by)
    wide = tables.residues.pivot_table(column, "frame", ["chain", "residue"], sort=False, dropna=False)
    ranking = tables.ranking.set_index(["chain", "residue"])
    ranked = ranking["rank"].notna()
    assert (ranking["quantity"] == column).all() and ranking.loc[ranked, by].is_monotonic_decreasing
    assert [*ranking["rank"][ranked]] == [*range(1, ranked.sum() + 1)] and ranked.iloc[: ranked.sum()].all()
    areas = tables.residues.pivot_table("area", "frame", ["chain", "residue"], sort=False)
    area = areas.mean()[ranking.index]
    np.testing.assert_allclose(ranking["mean_area"], area)
    is_mean = column.startswith("mean_")
    wide = wide.where(areas >= 20) if is_mean else wide  # a mean over dots needs some in its frame
    enough = (
        (is_mean | (area >= 20)) & (wide.count()[ranking.index] >= wide.shape[0] / 2) & (ranking["range"] > 0)
    )
    assert ranked.tolist() == enough.tolist()
    wanted = {
        "frames": wide.count(), "mean": wide.mean(), "sd": wide.std(), "lowest": wide.min(), "highest": wide.max(),
        "range": wide.max() - wide.min(),
    }  # fmt: skip
    for name, values in wanted.items():
        np.testing.assert_allclose(ranking[name], values[ranking.index], rtol=1e-9, atol=1e-12)


def in_blocks(values, area):
    """Numbers and areas of consecutive frames."""
    return lambda: zip(np.split(values, [3, 10]), np.split(area, [3, 10]), strict=True)


def test_ranking_by_standard_deviation_and_by_range_differ():
    """One jump has the larger range, and a steady swing the larger standard deviation."""
    residues = pd.DataFrame({"residue": ["buried", "jump", "swing", "once"]})
    values = np.array([[np.nan, 0, 6.0 * (k % 2), np.nan] for k in range(20)] + [[np.nan, 9.0, 0, 5.0]])
    for by, first in (("sd", "swing"), ("range", "jump")):
        ranking = rank_residues(residues, "q", by, in_blocks(values, np.full(values.shape, 50.0)))
        assert ranking["residue"].iloc[0] == first
    assert ranking["frames"].tolist() == [21, 21, 0, 1] and np.isnan(ranking["sd"].iloc[2:]).all()


def test_residues_of_little_area_or_of_few_frames_are_listed_below_the_ranked_ones():
    """At least 20 Å^2 in the mean over all frames, and a value in at least half of them; a constant is not ranked either."""
    names = ["too small", "steady", "seldom", "half", "constant", "small at times"]
    residues, frames = pd.DataFrame({"residue": names}), 12
    values, area = np.zeros((frames, 6)), np.full((frames, 6), 50.0)
    swing = np.arange(frames) % 2
    values[:] = swing[:, None] * [9, 1, 8, 7, 0, 6]
    values[: frames // 2 + 1, 2] = values[: frames // 2, 3] = np.nan
    area[:, 0] = 19.9
    area[:, 5] = np.where(swing, 0.0, 40.0)
    ranking = rank_residues(residues, "q", "sd", in_blocks(values, area)).set_index("residue")
    assert [*ranking.index] == ["half", "small at times", "steady", "too small", "seldom", "constant"]
    assert ranking["rank"].tolist()[:3] == [1, 2, 3] and ranking["rank"].isna().tolist()[3:] == [True] * 3
    assert ranking["frames"].tolist() == [6, 12, 12, 12, 5, 12]
    assert ranking["mean_area"].tolist() == pytest.approx([50, 20, 50, 19.9, 50, 50])


@pytest.mark.parametrize(
    ("values", "area", "said"),
    [
        ([[0.5, 0.6]], 50, "one frame shows no change; give a trajectory"),
        ([[0.5, 0.6], [0.5, 0.6]], 50, "no residue changes from frame to frame"),
        ([[0.5, 0.6], [0.7, 0.5]], 19, "no residue has at least 20 Å^2"),
        ([[0.5, 0.6], [0.7, 0.6]], 50, ""),
    ],
)
def test_a_ranking_without_a_residue_says_why(values, area, said):
    values = np.array(values)
    ranking = rank_residues(
        pd.DataFrame({"residue": ["1", "2"]}), "q", "range", lambda: [(values, np.full(values.shape, area))]
    )
    assert ranking["rank"].notna().sum() == (not said)
    assert (why_none_is_ranked(ranking, len(values)) or "nothing").startswith(said or "nothing")


def test_a_mean_over_dots_counts_in_frames_with_enough_area():
    """A residue whose roughness jumps where it is nearly buried does not change; its area does."""
    area, values = np.tile([[25.0], [5.0]], (6, 2)), np.tile([[0.5, 0.6], [0.1, 0.6]], (6, 1))
    values[::4, 1] = 0.62
    residues = pd.DataFrame({"residue": ["flickering", "changing"]})
    ranking = rank_residues(residues, "mean_q", "sd", lambda: [(values, area)]).set_index("residue")
    assert [*ranking.index] == ["changing", "flickering"] and ranking["frames"].tolist() == [6, 6]
    assert (
        rank_residues(residues, "area", "sd", lambda: [(area, area)])["rank"].isna().all()
    )  # 15 Å^2 in the mean
    assert rank_residues(residues, "area", "sd", lambda: [(area + 10, area + 10)])["rank"].notna().all()


@pytest.mark.parametrize("given", [{"start": 2}, {"start": 1, "stop": 6, "stride": 2}, {"stop": 3}])
def test_the_first_and_the_last_frame_are_chosen_by_position(seven, given):
    found = sparsurf.frames(seven, **given).residues
    whole = sparsurf.frames(seven).residues
    chosen = [*range(7)][given.get("start", 0) : given.get("stop") : given.get("stride", 1)]
    pd.testing.assert_frame_equal(found, whole[whole["frame"].isin(chosen)].reset_index(drop=True))


def test_a_last_frame_beyond_the_end_is_told(seven, caplog):
    for stop, start, stride in ((8, 0, 1), (9, 1, 2), (99, 2, 3)):
        assert not caplog.messages[1:]
        caplog.clear()
        sparsurf.frames(seven, start=start, stop=stop, stride=stride)
        last = [*range(7)][start::stride][-1]
        assert f"ends before position {stop}" in caplog.text and f"is at position {last}" in caplog.text
    caplog.clear()
    sparsurf.frames(seven, stop=9, stride=3)  # none would follow the last one
    assert "ends before" not in caplog.text


def test_a_first_frame_beyond_the_end_is_refused(seven):
    with pytest.raises(InputError, match=r"start: .* has 7 frames, the first at position 0, and none at 7"):
        sparsurf.frames(seven, start=7)
    with pytest.raises(InputError, match="stop is 2; it must be a whole number, more than 2"):
        sparsurf.frames(seven, start=2, stop=2)


def test_one_frame_is_not_ranked_and_says_so(tmp_path, capsys):
    """By the range, of which every residue had 0."""
    out = tmp_path / "run.csv"
    (tmp_path / "one.pdb").write_text(peptide())
    assert command.main(["frames", str(tmp_path / "one.pdb"), "--rank-by", "range", "-o", str(out)]) == 0
    said = capsys.readouterr().err
    assert said.count("no residue is ranked by its roughness: one frame shows no change") == 1
    assert "changes most" not in said
    assert pd.read_csv(tmp_path / "run_ranking.csv")["rank"].isna().all()


def stop_before_writing(monkeypatch, molecule, path, **options):
    """Stop a call after all of its parts are stored."""
    with monkeypatch.context() as patched:
        patched.setattr(api, "table_writers", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            sparsurf.frames(molecule, path=path, **options)


@pytest.mark.parametrize("changed", ["xyz", "residue_name", "frame_number", "probe_radius"])
def test_parts_of_another_trajectory_or_surface_are_not_taken(seven, tmp_path, monkeypatch, changed):
    """Neither those of other positions, residues or frames of the file, nor of another probe, of a stopped run."""
    molecule, arguments = sparsurf.read_molecule(seven), {}
    other = {
        "xyz": molecule.xyz[::-1],
        "residue_name": np.where(molecule.chain == "B", "GLY", molecule.residue_name),
        "frame_number": molecule.frame_number + 3,
    }
    stop_before_writing(monkeypatch, molecule, tmp_path / "run.csv")
    if changed == "probe_radius":
        arguments = {changed: 1.6}
    else:
        molecule = replace(molecule, **{changed: other[changed]})
    sparsurf.frames(molecule, path=tmp_path / "run.csv", **arguments)
    sparsurf.frames(molecule, path=tmp_path / "alone.csv", **arguments)
    for end in ("", "_frames"):
        assert (tmp_path / f"run{end}.csv").read_bytes() == (tmp_path / f"alone{end}.csv").read_bytes()


@pytest.mark.parametrize("other", ["columns", "numbers"])
def test_parts_of_another_version_are_not_taken(seven, tmp_path, monkeypatch, other):
    """What a stopped run of an older version left behind has other columns, or was measured in another way."""
    part_of_frames = api.part_of_frames

    def measure(*given):
        part = part_of_frames(*given)
        return part._replace(residues=2 * part.residues)

    with monkeypatch.context() as older:
        if other == "columns":
            older.setattr(api, "RESIDUE_COLUMNS", api.RESIDUE_COLUMNS[::-1])
        else:
            older.setattr(api, "part_of_frames", measure)
            older.setattr("sparsurf.api.checkpoints.__version__", "4.0.0")
        stop_before_writing(older, seven, tmp_path / "run.csv")
    sparsurf.frames(seven, path=tmp_path / "run.csv")
    found = pd.read_csv(tmp_path / "run.csv")
    np.testing.assert_allclose(found["area"], sparsurf.frames(seven).residues["area"], rtol=1e-8)


def lowest(molecule, points):
    """A field of the user's own."""
    return points.min(axis=1)


def highest(molecule, points):
    """A field of the user's own."""
    return points.max(axis=1)


highest.__name__ = "lowest"


@pytest.mark.parametrize("changed", ["function", "b_factor"])
def test_parts_of_another_field_are_not_taken(seven, tmp_path, monkeypatch, changed):
    """What a stopped run left behind follows from another function, or from other B factors."""
    molecule = sparsurf.read_molecule(seven)
    molecule = replace(molecule, b_factor=np.arange(molecule.n_atoms, dtype=float))
    field, other = (lowest, highest) if changed == "function" else ("bfactor", "bfactor")
    other_molecule = (
        molecule if changed == "function" else replace(molecule, b_factor=molecule.b_factor[::-1])
    )
    stop_before_writing(monkeypatch, molecule, tmp_path / "run.csv", fields=field)
    sparsurf.frames(other_molecule, path=tmp_path / "run.csv", fields=other)
    expected = sparsurf.frames(other_molecule, fields=other).residues[f"mean_{names_of(other)}"]
    found = pd.read_csv(tmp_path / "run.csv")[f"mean_{names_of(other)}"]
    np.testing.assert_allclose(found, expected, rtol=1e-8)


def names_of(field):
    """The name of a field, given by name or as a function."""
    return field if isinstance(field, str) else field.__name__


def test_one_frame_a_stride_and_a_trajectory(tmp_path, capsys, caplog):
    topology, trajectory = str(TDP43 / "topology.pdb"), str(TDP43 / "trajectory.xtc")
    out = tmp_path / "run.csv"
    assert (
        command.main(["frames", topology, "--trajectory", trajectory, "--stride", "700", "-o", str(out)]) == 0
    )
    assert "61 residues in 2 frames" in capsys.readouterr().err
    frames = pd.read_csv(tmp_path / "run_frames.csv")
    assert frames["frame"].tolist() == [0, 700] and (np.diff(frames["time_ps"]) > 0).all()
    assert frames["area"][0] == pytest.approx(4557.998, abs=1e-3)
    assert "stride" not in caplog.text
    peptide = sparsurf.read_molecule(topology, trajectory, residues="209-214", stride=700)
    assert sparsurf.frames(peptide, stride=2).frames["frame"].tolist() == [0]
    assert "2 frames" in caplog.text
    one = sparsurf.frames(topology)
    assert len(one.frames) == 1 and len(one.residues) == 61
    buried = one.residues[one.residues["area"] == 0]
    assert buried["mean_roughness"].isna().all()


def test_bad_input_is_refused_in_one_sentence(seven, tmp_path):
    trajectory = TDP43 / "trajectory.xtc"
    with pytest.raises(InputError, match="atoms"):
        sparsurf.frames(seven, trajectory)
    with pytest.raises(InputError, match="belongs to the path of a structure"):
        sparsurf.frames(sparsurf.read_molecule(seven), trajectory)
    with pytest.raises(InputError, match=r"\.parquet, \.csv"):
        sparsurf.frames(seven, path=tmp_path / "run.npz")
    with pytest.raises(InputError, match="hydropaty"):
        sparsurf.frames(seven, fields="hydropaty")
    for rank, said in (
        ("roughnes", "did you mean 'roughness'"),
        ("x", "give one of area, roughness"),
        (3, "is 3, which"),
    ):
        with pytest.raises(InputError, match=said):
            sparsurf.frames(seven, rank=rank)
    with pytest.raises(InputError, match="sd or range"):
        sparsurf.frames(seven, rank_by="median")
    with pytest.raises(InputError, match="trajectory without"):
        sparsurf.show(seven, rank="area")
