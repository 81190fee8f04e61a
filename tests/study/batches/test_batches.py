"""A study of many structures in batches: values as the functions give them, one row for each failure."""

import html
import re
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree

import export_structure as export
import small_study
import sparsurf
from peptides import peptide, write
from sparsurf.errors import InputError
from sparsurf.settings import Settings
from sparsurf_study.batches import assignment, summary, tables
from sparsurf_study.batches.analysis import Structure, analyse_batch
from sparsurf_study.config.check import check_config
from sparsurf_study.report.closing import close_batches
from sparsurf_study.report.front import write_front
from sparsurf_study.workflow.ends import failed_places

pytest.importorskip("pyarrow", reason="pyarrow is installed by the extra `many`")
RESIDUES = ("ALA", "SER", "ALA", "VAL", "GLY", "ALA")
CONFIG = {"run": "many", "sampling": False, "proteins": {"folder": "structures"}}
FILES_OF_RUN = {
    "page": "index.html",
    "failures": "failures.csv",
    "warnings": "warnings.csv",
    "checks": "checks.csv",
    "png": "distributions.png",
    "crate": "ro-crate-metadata.json",
    "sums": "SHA256SUMS",
}
GOOD = [f"p{k:02d}" for k in range(1, 11)]


def write_structures(folder):
    """Write ten peptides of different lengths and two broken files into a folder."""
    folder.mkdir(parents=True)
    remarks = f"{'REMARK':80s}\n" * 21_600  # 1.75 MB, so that there are several batches
    for k, name in enumerate(GOOD):
        write(
            folder / f"{name}.pdb", remarks + peptide(RESIDUES[: 3 + k % 4], origin=(0.1 * k, 0, 0)) + "END\n"
        )
    write(folder / "empty.pdb", "END\n")
    write(folder / "text.cif", "no structure\n")
    return folder


@pytest.fixture(scope="module")
def many(tmp_path_factory):
    """Folder of a finished study of twelve structures, two of them broken."""
    folder = tmp_path_factory.mktemp("many") / "study"
    write_structures(folder / "structures")
    process = small_study.snakemake(folder, CONFIG)
    assert process.returncode == 0, small_study.output(process)
    return folder


def read(many, table):
    """Read a table of the run."""
    return tables.read_parquet(many / "results/many", table)


def test_every_structure_is_a_surface_or_a_failure_with_its_reason(many):
    surfaces, failures = read(many, "surfaces"), read(many, "failures")
    assert sorted(surfaces["protein"]) == GOOD and sorted(failures["protein"]) == ["empty", "text"]
    assert failures["reason"].str.contains("structures/").all()
    assert not failures["reason"].str.contains("defect").any()
    assert len(list((many / "results/many/surfaces").glob("*.parquet"))) == 4
    listed = pd.read_csv(many / "results/many/failures.csv")
    assert listed["place"].tolist() == ["empty", "text"] and list(listed) == ["place", "reason"]


@pytest.mark.parametrize("name", GOOD[:4])
def test_values_are_those_of_the_functions(many, name):
    dots = sparsurf.surface(many / f"structures/{name}.pdb")
    few = sparsurf.minimal(dots, percent=10)
    row = read(many, "surfaces").set_index("protein").loc[name]
    assert row["N"] == len(dots) and row["minimal_n_S"] == len(few)
    assert row["area"] == pytest.approx(dots.total_area, rel=1e-12)
    assert row["mean_roughness"] == pytest.approx(sparsurf.roughness(dots).mean(), rel=1e-12)
    molecule = sparsurf.read_molecule(many / f"structures/{name}.pdb")
    assert (row["atoms"], row["residues"]) == (molecule.n_atoms, molecule.n_residues)
    assert row["minimal_n_S_percent"] == pytest.approx(100 * len(few) / len(dots))
    nearest = cKDTree(dots.points).query(dots.points, 2)[0][:, 1]
    assert 0.5 * np.median(nearest) < row["spacing"] < 2 * np.median(nearest)
    table = sparsurf.components(dots)[1]
    assert row["volume"] == pytest.approx(table["volume"][~table["cavity"]].sum())
    kept = read(many, "dots").query("protein == @name").set_index("dot")
    assert kept.index.tolist() == sorted(few.dots)
    kept = kept.loc[few.dots]
    points, normals = tables.unpack_dots(kept)
    assert np.allclose(points, few.points, rtol=0, atol=1 / 64)
    assert (normals * few.normals).sum(axis=1).min() > np.cos(np.radians(2**0.5))  # half of 2° in both angles
    assert kept["weight"].tolist() == few.weight.tolist()
    assert kept["atom"].tolist() == few.surface.atom.tolist()
    residues = read(many, "residues").query("protein == @name").drop(columns="protein")
    expected = sparsurf.residues(dots, kept=few).drop(columns="depth")  # which a study has as a field only
    pd.testing.assert_frame_equal(
        residues.reset_index(drop=True),
        expected,
        check_dtype=False,
        rtol=0,
        atol=tables.RESIDUE_STEP / 2,
        check_column_type=False,
    )


@pytest.mark.parametrize("name", assignment.BATCH_FOLDERS)
def test_every_column_is_listed_in_order(many, name):
    listed = small_study.table_of(f"{name}/0001.parquet").columns
    described = {column.name: column.type for column in listed if "<" not in column.name}
    read = tables.read_parquet(many / "results/many", name)
    letters = {"i": "int", "f": "float"}
    kinds = {key: letters.get(column.dtype.kind, "text") for key, column in read.items()}
    kinds |= {"masked_residues": "int"} if name == "surfaces" else {}  # NaN where there is none
    assert kinds == described and list(kinds) == list(described)


def test_export_writes_the_files_of_one_structure(many, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert export.main(str(many / "results/many"), "p03", "out") == 0
    few = sparsurf.minimal(many / "structures/p03.pdb", percent=10)
    expected = few.table.sort_values("dot", ignore_index=True)
    kept = pd.read_csv("out/minimal.csv")
    expected = expected.drop(
        columns=["area", "probe_radius", "radii", "reconstruction"]
    )  # the tables of a batch have no room for them
    assert (
        list(kept) == list(expected) and kept["residue"].tolist() == expected["residue"].astype(int).tolist()
    )
    assert np.allclose(kept[["x", "y", "z"]], expected[["x", "y", "z"]], atol=1 / 64)
    assert kept["dot"].tolist() == expected["dot"].tolist()
    assert np.allclose(kept["spacing"], expected["spacing"], atol=0.06)
    residues = pd.read_csv("out/residues.csv")
    assert residues["kept"].sum() == len(kept) and "protein" not in residues
    molecule = sparsurf.read_molecule("out/structure_roughness.pdb")
    roughness = residues["mean_roughness"].to_numpy()[molecule.residue_index]
    assert np.allclose(molecule.b_factor, roughness, atol=0.006)
    assert len(sparsurf.read_surface("out/minimal.ply")) == len(kept)
    assert "structure_roughness.pdb" in (tmp_path / "out/open.pml").read_text()
    assert export.main(str(many / "results/many"), "p03") == 0
    assert Path("p03/minimal.csv").read_bytes() == Path("out/minimal.csv").read_bytes()
    assert capsys.readouterr().out.splitlines()[1].startswith("p03/: ")
    assert [export.main(*words) for words in (["-h"], ["--help"], ["results"], list("abcd"))] == [
        0,
        0,
        2,
        2,
    ]
    for folder in ("out", "new/folder"):  # one that is there, and one in another that is not
        assert export.main(str(many / "results/many"), "p03", folder) == 0
    assert Path("new/folder/minimal.csv").read_bytes() == Path("out/minimal.csv").read_bytes()
    residues.loc[0, "mean_roughness"] = np.nan  # as of a buried residue, which is no rough one
    stored = {"residues": residues.assign(protein="p03")}
    monkeypatch.setattr(
        "sparsurf_study.report.export.read_parquet",
        lambda run, table, name: stored.get(table, tables.read_parquet(run, table, name)),
    )
    assert export.main(str(many / "results/many"), "p03", "out") == 0
    molecule = sparsurf.read_molecule("out/structure_roughness.pdb")
    assert ((molecule.b_factor == -1) == (molecule.residue_index == 0)).all()


@pytest.mark.parametrize(
    ("run", "name", "words"),
    [
        ("results/many", "nobody", "structure 'nobody'"),
        ("results/many", "empty", "empty failed: structures/empty.pdb"),
        ("structures", "p03", "holds no surfaces/*.parquet"),
    ],
)
def test_what_cannot_be_exported_is_said_in_one_sentence(many, capsys, run, name, words):
    assert export.main(str(many / run), name) == 1
    told = capsys.readouterr().err
    assert words in told and told.count("\n") == 1


def test_a_structure_that_has_lost_an_atom_is_not_exported(many, tmp_path, capsys):
    shutil.copytree(many, tmp_path / "own")
    path = tmp_path / "own/structures/p03.pdb"
    lines = path.read_text().splitlines(True)
    lines.remove([line for line in lines if line.startswith("ATOM")][-1])
    write(path, "".join(lines))
    assert export.main(str(tmp_path / "own/results/many"), "p03", str(tmp_path / "out")) == 1
    assert "p03.pdb has changed" in capsys.readouterr().err


def test_the_bytes_depend_neither_on_cores_nor_on_the_order_of_batches(many, tmp_path):
    folder = tmp_path / "again"
    shutil.copytree(many / "structures", folder / "structures")
    process = small_study.snakemake(
        folder, CONFIG, "--cores", "1", "--prioritize", "results/many/surfaces/0003.parquet"
    )
    assert process.returncode == 0, small_study.output(process)
    for path in sorted((many / "results/many").rglob("*.parquet")):
        assert (folder / path.relative_to(many)).read_bytes() == path.read_bytes(), path
    for name in ("index.html", "failures.csv", "warnings.csv", "distributions.png"):
        assert (folder / "results/many" / name).read_bytes() == (many / "results/many" / name).read_bytes()


def test_a_structure_that_is_repaired_changes_its_own_batch_only(many, tmp_path):
    folder = tmp_path / "mended"
    shutil.copytree(many, folder)
    write(folder / "structures/empty.pdb", peptide(RESIDUES) + "END\n")
    before = {path: path.stat().st_mtime_ns for path in (folder / "results").rglob("surfaces/*.parquet")}
    (folder / "results/many/surfaces/0009.parquet").write_bytes(b"left from an earlier study")
    process = small_study.snakemake(folder, CONFIG)
    assert process.returncode == 0, small_study.output(process)
    assert sum(path.stat().st_mtime_ns != time for path, time in before.items()) == 1
    assert sorted(read(folder, "surfaces")["protein"]) == sorted([*GOOD, "empty"])
    assert pd.read_csv(folder / "results/many/failures.csv")["place"].tolist() == ["text"]


def test_normals_along_the_axes_come_back():
    axes = np.vstack([np.eye(3), -np.eye(3)])
    packed = tables.pack_dots(axes / 32, axes)
    assert packed["polar"].tolist() == [90, 90, 0, 90, 90, 180]
    assert packed["azimuth"].tolist()[:2] == [0, 90] and packed["azimuth"].max() < 360
    points, normals = tables.unpack_dots(packed)
    assert np.allclose(points, axes / 32) and np.allclose(normals, axes, atol=1e-12)


def test_the_page_counts_and_groups(many):
    page = (many / "results/many/index.html").read_text(encoding="utf-8")
    assert "10 surfaces of 12 structures were computed in 4 batches" in page and "2 structures failed" in page
    assert page.count("<td data-key=") == 7 * len(GOOD)
    assert "defect" not in page and page.count('src="data:image/webp;base64,') == 1


def test_a_structure_with_a_page_gets_the_files_of_a_study(many, tmp_path):
    folder = tmp_path / "pages"
    shutil.copytree(many, folder)
    models = [f"MODEL {k:8d}\n{peptide(RESIDUES[:4], origin=(0, 0, k))}ENDMDL\n" for k in (1, 2)]
    write(folder / "structures/p02.pdb", "".join(models) + "END\n")
    process = small_study.snakemake(folder, CONFIG | {"pages": ["p02", "p03"]})
    assert process.returncode == 0, small_study.output(process)
    run = folder / "results/many"
    for name in ("p02", "p03"):
        minimal = pd.read_csv(run / name / "c1/minimal.csv")
        kept = read(folder, "dots").query("protein == @name").set_index("dot")
        assert minimal.set_index("dot")["weight"].sort_index().to_dict() == kept["weight"].to_dict()
    assert pd.read_csv(run / "surfaces.csv")["protein"].tolist() == ["p02", "p03"]
    page = (run / "index.html").read_text(encoding="utf-8")
    assert 'href="p02/c1/view.html"' in page and 'aria-label="Enlarge: p03"' in page
    assert (
        page.count("data:image/webp") == 6
    )  # distributions, Z over n_S, and the view and the roughness of two surfaces
    assert pd.read_csv(run / "warnings.csv")["sentence"].is_unique
    with (run / "logs/p02/c1/draw_view.log").open("a") as log:
        log.write("WARNING told by a page\n")
    assert sorted(read(folder, "surfaces")["protein"]) == GOOD
    config = config_of(tmp_path, pages=["a"])
    config["proteins"]["b"] = config["proteins"]["a"]
    for job in ("a/c1/draw_view", "a/choose_frames"):
        (run / "logs" / job).parent.mkdir(parents=True, exist_ok=True)
        (run / "logs" / f"{job}.log").write_text("")
    excluded = failed_places(check_config(config), run, 0.0)
    assert sorted(excluded) == ["a/*", "a/c1"]  # its batch keeps it
    process = small_study.snakemake(folder, CONFIG | {"pages": ["p02", "p03"], "exclude": ["p03/*"]})
    assert process.returncode == 0, small_study.output(process)
    assert sorted(read(folder, "surfaces")["protein"]) == GOOD
    assert pd.read_csv(run / "surfaces.csv")["protein"].tolist() == ["p02"]
    assert pd.read_csv(run / "warnings.csv").iloc[-1].tolist() == ["p02", "c1", "draw_view", "told by a page"]


def test_batches_are_stable():
    sizes = {f"s{k}": 100_000.0 for k in range(1000)}
    batches = assignment.assign_batches(sizes)
    assert len(batches) == 16 and sorted(name for names in batches.values() for name in names) == sorted(
        sizes
    )
    assert assignment.assign_batches(dict(reversed(sizes.items()))) == batches
    more = assignment.assign_batches(sizes | {"new": 1.0})
    assert [name for name in batches if batches[name] != more[name]] == [
        name for name in more if "new" in more[name]
    ]
    assert assignment.assign_batches({"one": 0.0}) == {"0001": ["one"]}


def test_sizes_are_those_of_uncompressed_files(tmp_path):
    wanted = {"a.pdb": 1000, "a.pdb.gz": 4000, "a.cif": 700, "a.cif.gz": 2800}
    for name in wanted:
        (tmp_path / name).write_bytes(bytes(1000))
    assert {name: assignment.size_as_pdb(tmp_path / name) for name in wanted} == wanted
    assert assignment.size_as_pdb(tmp_path / "none.pdb") == 0


def config_of(tmp_path, **changes):
    """Return a config of batches over one peptide."""
    write(tmp_path / "a.pdb", peptide() + "END\n")
    config = {"sampling": False, "pages": [], "proteins": {"a": {"structure": str(tmp_path / "a.pdb")}}}
    return config | changes


def test_a_study_of_few_structures_or_of_more_than_structures_gives_each_its_pages(tmp_path):
    many = {f"a{k}": {"structure": str(tmp_path / "a.pdb")} for k in range(11)}
    few = dict(list(many.items())[:10])
    pair = {"p": {"proteins": ["a0", "a1"]}}
    for changes, n in (
        ({"proteins": many}, 11),
        ({"proteins": few}, 0),
        ({"proteins": few, "pages": ["a3"]}, 10),
        ({"proteins": many, "pages": [*many]}, 0),
        ({"proteins": many, "sampling": True}, 0),
        ({"proteins": many, "pairs": pair}, 0),
        ({"proteins": many | {"a0": many["a0"] | {"sampling": True}}}, 0),
        ({"proteins": many, "exclude": ["a0"]}, 0),
    ):
        config = {key: value for key, value in config_of(tmp_path).items() if key != "pages"} | changes
        checked = check_config(config)
        assert len(assignment.batched_structures(checked)) == n, changes
        assert ("percent" in checked["minimal"]) == bool(n)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"sampling": True}, "`sampling: false`"),
        ({"proteins": {"a": {"pdb": "1ubi"}}}, "every protein"),
        ({"pages": ["a", "a"]}, "pages holds"),
        ({"proteins": {}}, "proteins is empty"),
        (
            {"pages": ["b1"], "proteins": {"b10": {"structure": "a.pdb"}}},
            "'b1' is none of the proteins; did you mean 'b10'?",
        ),
        (
            {"pages": ["Dots"], "proteins": {name: {"structure": f"{name}.pdb"} for name in ("Dots", "b")}},
            "pages: 'Dots'",
        ),
    ],
)
def test_a_config_that_batches_cannot_take_is_refused_in_one_sentence(tmp_path, changes, words):
    with pytest.raises(InputError, match="config: ") as error:
        check_config(config_of(tmp_path, **changes))
    assert words in str(error.value)


def test_two_structures_of_one_name_are_refused(tmp_path):
    folder = tmp_path / "structures"
    folder.mkdir()
    for name in ("a.pdb", "a.cif", "b.pdb"):
        write(folder / name, peptide() + "END\n")
    with pytest.raises(InputError) as error:
        check_config(config_of(tmp_path, proteins={"folder": str(folder)}))
    assert str(error.value).count("have one name; rename or remove one of the two files.") == 1
    (tmp_path / "other").mkdir()
    (folder / "a.cif").rename(tmp_path / "other" / "a.cif")  # of another folder
    proteins = {
        k: {"structure": str(path)}
        for k, path in (("x", folder / "a.pdb"), ("y", tmp_path / "other" / "a.cif"))
    }
    for keys, subset in (({}, "auto"), ({"minimal": {"sampler": "uniform"}}, "uniform")):
        checked = check_config(config_of(tmp_path, proteins=proteins, **keys))
        assert checked["minimal"] == {"sampler": subset, "reconstruction": "auto", "percent": 10}


def test_a_defect_becomes_a_row_and_models_and_warnings_are_reported(tmp_path, monkeypatch, caplog):
    config = check_config(config_of(tmp_path))
    lines = peptide(RESIDUES)
    two = write(tmp_path / "two.pdb", f"MODEL        1\n{lines}ENDMDL\nMODEL        2\n{lines}ENDMDL\nEND\n")
    both, told = [Structure("two", str(two)), Structure("gone", str(tmp_path / "gone.pdb"))], []
    out = analyse_batch(both, Settings.of(config), config["seed"], lambda *steps: told.append(steps))
    assert told == [(1, 2), (2, 2)] and out["failures"]["protein"].tolist() == ["gone"]
    sparse = Settings.of(config | {"surface": config["surface"] | {"density": 1.0}})
    assert "patches.d_link" in analyse_batch(both[:1], sparse, config["seed"])["failures"]["reason"][0]
    assert out["surfaces"]["protein"].tolist() == ["two"]
    assert "two: 2 models; the first is taken" in out["warnings"]["sentence"].tolist()
    assert "does not exist" in out["failures"]["reason"][0]
    assert not caplog.records  # a line for each on the terminal would bury the rest
    monkeypatch.setattr("sparsurf_study.batches.analysis.read_molecule", lambda *_, **__: 1 / 0)
    reason = analyse_batch([Structure("two", str(two))], Settings.of(config), config["seed"])["failures"][
        "reason"
    ][0]
    assert reason.startswith("A defect of")


def made_up(n):
    """A table of n ordinary surfaces."""
    rng = np.random.default_rng(1)
    atoms = rng.integers(900, 1100, n)
    return pd.DataFrame(
        {
            "protein": [f"s{k:03d}" for k in range(n)],
            "atoms": atoms,
            "area": 5.0 * atoms + rng.normal(0, 50, n),
            "volume": 11.0 * atoms + rng.normal(0, 50, n),
            "mean_roughness": rng.normal(0.6, 0.01, n),
            "cavity_dots": rng.integers(0, 100, n),
            "N": 40 * atoms,
        }
    )


def test_the_deviation_is_in_robust_standard_deviations():
    """Roughness .1 to .5 and 1.3: median .35, median absolute deviation .15, so 1.3 lies .95 / (1.4826 * .15) away."""
    table = made_up(6).assign(atoms=1000, area=5000.0, volume=11000.0, cavity_dots=0, N=40000)
    table["mean_roughness"] = [0.1, 0.2, 0.3, 0.4, 0.5, 1.3]
    found = summary.most_unusual(table, 2)
    assert found["protein"].tolist() == ["s005", "s000"]
    np.testing.assert_allclose(found["deviation"], np.array([0.95, 0.25]) / (1.4826 * 0.15), rtol=1e-12)
    assert found["unusual"].tolist() == ["mean roughness"] * 2 and found.index.tolist() == [0, 1]


@pytest.mark.parametrize("word", ["atoms", "area per atom", "volume per atom", "dots in cavities"])
def test_a_surface_is_unusual_by_each_measure(word):
    """The same six values as above, of the logarithm of the number of atoms; the sizes of molecules and surfaces differ."""
    values, atoms, n = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 1.3]), np.full(6, 1000.0), np.array([1e4, 2e4] * 3)
    atoms = 1000 * np.exp(values) if word == "atoms" else atoms
    one = {"area per atom": 5.0, "volume per atom": 11.0, "dots in cavities": 0.25} | {word: values}
    table = made_up(6).assign(atoms=atoms, N=n, mean_roughness=0.5, cavity_dots=one["dots in cavities"] * n)
    table = table.assign(area=one["area per atom"] * atoms, volume=one["volume per atom"] * atoms)
    assert summary.measures(table)["cavity_percent"].to_numpy() == pytest.approx(
        100 * one["dots in cavities"]
    )
    found = summary.most_unusual(table, 6)
    assert found["unusual"][0] == word and found["protein"][0] == "s005"
    assert found["deviation"][0] == pytest.approx(0.95 / (1.4826 * 0.15))
    for n_surfaces, unusual in ((5, word), (4, "")):
        some = summary.most_unusual(table.tail(n_surfaces).reset_index(drop=True), 1)
        assert some["unusual"][0] == unusual and (some["deviation"][0] > 0) == bool(unusual)


def page_of(tmp_path, surfaces, failures=()):
    """The page of a run in batches, without a figure, and its answers."""
    batches = {"surfaces": surfaces, "unusual": surfaces, "failures": list(failures), "n_batches": 2}
    answers = write_front(tmp_path / "index.html", [], {}, batches, minimal={"percent": 10})
    return (tmp_path / "index.html").read_text(), answers


COLUMNS = {
    "deviation": [0.5, 10.0, 9.0],
    "unusual": ["atoms", "", "atoms"],
    "components": 1,
    "cavities": [2, 10, 1],
}


def test_the_page_says_the_share_of_all_dots_and_the_residues_left_out(tmp_path):
    columns = COLUMNS | {
        "atoms": [100, 1200, 2500],
        "residues": [10, 150, 310],
        "mean_roughness": [0.5, 0.62, 0.7],
    }
    surfaces = made_up(3).assign(minimal_n_S=[400, 480, 1000], masked_residues=[None, 0, 12], **columns)
    surfaces["N"] = 40 * surfaces["atoms"]
    page, answers = page_of(tmp_path, surfaces, [("holds no atoms.", ["x", "y"])])
    assert answers == [
        "3 surfaces of molecules of 100 to 2,500 atoms: the minimal subsets keep 1.2 % of 152,000 dots, and the"
        " median of the mean roughness is 0.62 (0.50 to 0.70)."  # 1.9 % is the mean of the shares
    ]
    assert "12 of 472 residues of 2 predicted models are left out" in page
    assert "<b>x, y</b>: holds" in page and "3 surfaces of 5 structures" in page
    text = html.unescape(re.sub("<[^>]+>", "", page)).replace("\xa0", " ")
    assert (
        "A surface was computed for 3 of 5 structures, and a subset of its dots was selected: 10 % of the dots."
        in text
    )
    assert (
        "of 152,000 dots (1.2 %) are in the minimal subsets, which keep 10 % of the dots of each surface."
        in text
    )
    assert "sufficient" not in text


def test_the_table_is_sorted_by_its_numbers_and_searched(tmp_path, browser):
    known = {"atoms": [999, 12000, 1500], "minimal_n_S": 5, "masked_residues": None, "residues": 9}
    page_of(tmp_path, made_up(3).assign(**known, **COLUMNS))
    (tmp_path / "distributions.png").touch()  # which the page shows

    def shown():
        return browser.run(
            "const rows = [...document.querySelectorAll('table.sortable tbody tr')];"
            "return rows.filter(r => !r.hidden).map(r => r.cells[0].textContent)"
        )

    def click(column):
        browser.run("document.querySelectorAll('table.sortable th button')[arguments[0]].click()", column)
        return shown()

    browser.open(tmp_path / "index.html")
    assert shown() == ["s000", "s001", "s002"]
    assert click(1) == ["s001", "s002", "s000"]
    assert click(1) == ["s000", "s002", "s001"]  # and the other way round
    assert click(3) == ["s001", "s002", "s000"]  # 12,000 and 1,500 and 999
    assert click(0) == ["s000", "s001", "s002"]
    assert click(8) == ["s001", "s000", "s002"]
    browser.run(
        "const s = document.querySelector('input[type=search]'); s.value = 'ATOMS'; s.dispatchEvent(new Event('input'))"
    )
    assert shown() == ["s000", "s002"]


def test_reasons_that_differ_in_names_and_numbers_are_one():
    failures = pd.DataFrame(
        {
            "protein": ["c", "a", "b", "d", "e"],
            "reason": [
                "x/c.cif line 3 is short.",
                "x/a.pdb holds no atoms.",
                "x/b.pdb holds no atoms.",
                "x/d.cif line 12 is short.",
                "x/D.cif line 1 is short.",
            ],
        }
    )
    groups = summary.grouped_reasons(failures)
    assert [names for _, names in groups] == [["c", "d", "e"], ["a", "b"]]


def test_a_predicted_model_loses_its_doubtful_residues(tmp_path):
    lines = ["TITLE     ALPHAFOLD MONOMER V2.0 PREDICTION FOR X", *peptide(RESIDUES).splitlines()]
    lines = [
        f"{line[:60]}{10.0 * int(line[22:26]) + 40:6.2f}{line[66:]}" if line.startswith("ATOM") else line
        for line in lines
    ]
    write(tmp_path / "m.pdb", "\n".join(lines) + "\nEND\n")
    config = check_config(config_of(tmp_path))
    batch = [Structure("m", str(tmp_path / "m.pdb"), None, {"plddt": 70.0})]
    batch += [Structure("a", str(tmp_path / "a.pdb"), None, {"plddt": 70.0})]
    out = analyse_batch(batch, Settings.of(config), config["seed"])
    assert out["surfaces"]["masked_residues"].tolist()[0] == 2 and out["surfaces"]["residues"][0] == 4
    assert pd.isna(out["surfaces"]["masked_residues"][1])
    assert out["residues"].query("protein == 'm'")["residue"].astype(int).tolist() == [3, 4, 5, 6]
    assert "left out 2 of 6 residues, whose pLDDT is below 70" in " ".join(out["warnings"]["sentence"])


def test_the_same_warning_of_two_structures_is_listed_twice(tmp_path):
    """And beside those of a batch the ones of the pages, as what is excluded stands beside what failed."""
    run = tmp_path / "run"
    config = check_config(config_of(tmp_path))
    surfaces = analyse_batch([Structure("a", str(tmp_path / "a.pdb"))], Settings.of(config), config["seed"])[
        "surfaces"
    ]
    rows = {
        "surfaces": surfaces,
        "warnings": pd.DataFrame(
            {"protein": ["b", "a", "a", "a"], "sentence": ["it lacks atoms"] * 3 + ["it has two models"]}
        ),
        "failures": pd.DataFrame({"protein": [f"x{k:02d}" for k in range(23)], "reason": "holds no atoms."}),
    }
    for name, table in rows.items():
        (run / name).mkdir(parents=True)
        tables.write_parquet(run / name / "0001.parquet", name, table)
    files = {name: str(run / path) for name, path in FILES_OF_RUN.items()}
    paths = [str(run / name / "0001.parquet") for name in rows]
    of_page = [("a", "c1", "draw_view", sentence) for sentence in ("it lacks atoms", "told by a page")]
    close_batches(run, paths, [], of_page, {"left": "by hand"}, files)
    listed = pd.read_csv(files["warnings"])
    sentences = ["it lacks atoms", "it has two models", "it lacks atoms", "told by a page"]
    assert listed["sentence"].tolist() == sentences and listed["protein"].tolist() == ["a", "a", "b", "a"]
    assert listed["job"].tolist() == [*3 * ["analyse_batch"], "draw_view"]
    page = " ".join(Path(files["page"]).read_text().split())
    assert "x19 and 3" in page and " x20" not in page  # 23 failed, and 20 are named
    assert "1 batch." in page and pd.read_csv(files["checks"])["file"].tolist() == [
        "residues/0001.parquet"  # which is missing here
    ]
    failures = pd.read_csv(files["failures"])
    assert len(failures) == 24 and failures.iloc[0].tolist() == ["left", "by hand"]
