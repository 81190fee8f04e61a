"""The files of a run, by the kinds of its proteins."""

import gzip
from types import SimpleNamespace

import pytest
from snakemake.exceptions import IncompleteCheckpointException
from snakemake.iocontainers import Wildcards

from sparsurf.workflow import files_of_a_run
from sparsurf.workflow.files_of_a_run import FilesOfARun, has_one_model

CONFIG = {
    "run": "r",
    "proteins": {
        "moving": {"structure": "a.pdb", "trajectory": "a.xtc"},
        "still": {"structure": "b.pdb"},
        "ready": {"surface": "c.dms"},
        "water": {"structure": "d.pdb", "simulate": {"npt_ns": 0.3}},
        "got": {"pdb": "1ubi"},
    },
    "without": {},
    "frames": {"stride": 1},
    "sampling": {"alpha": [1.0], "beta": [0.0], "gamma": [0.0], "delta": [0.0, 6.0]},
    "evaluation": {"test_dots": "published", "draws": 500, "readings": ["as_coded", "as_written"]},
}
FRAMES = {"moving": ["f0", "f7"], "still": ["c1"], "water": ["f3"], "got": ["c1"]}
MOLECULES = ["moving", "still", "water", "got"]


@pytest.fixture
def checkpoints(tmp_path):
    """As Snakemake's, where the frames of every molecule are chosen."""
    for name, conformations in FRAMES.items():
        (tmp_path / f"{name}.csv").write_text(
            "conformation,frame\n" + "".join(f"{c},0\n" for c in conformations)
        )

        frames = 9 if name == "moving" else 1
        (tmp_path / f"{name}_projection.csv").write_text("frame,pc1\n" + "0,0.0\n" * frames)

    def get(protein):
        paths = {"frames": tmp_path / f"{protein}.csv", "projection": tmp_path / f"{protein}_projection.csv"}
        return SimpleNamespace(output=SimpleNamespace(**paths))

    return SimpleNamespace(choose_frames=SimpleNamespace(get=get))


@pytest.fixture
def files(checkpoints):
    return FilesOfARun(CONFIG, checkpoints)


def of(protein, **more):
    return Wildcards(fromdict={"protein": protein, **more})


def test_proteins_are_told_apart_by_their_kind(files):
    assert files.run == "results/r"
    assert (files.surfaces, files.molecules, files.simulated) == (["ready"], MOLECULES, ["water"])
    assert files.fetched == {"got": "1UBI.cif.gz"}


@pytest.mark.parametrize(
    ("protein", "found"),
    [
        ("moving", {"structure": "a.pdb", "trajectory": "a.xtc"}),
        ("still", {"structure": "b.pdb"}),
        ("ready", {}),
        ("got", {"structure": "results/r/got/download/1UBI.cif.gz"}),
    ],
)
def test_a_molecule_is_what_was_given_or_fetched(files, protein, found):
    assert files.given(of(protein)) == files.molecule(of(protein)) == found


def test_the_files_that_the_config_names_are_known_by_what_they_hold(files, monkeypatch):
    monkeypatch.setattr(files_of_a_run, "content", str.upper)
    found = {name: files.contents(of(name)) for name in files.proteins}
    ready = str(files.proteins["ready"].surface).upper()
    assert found == {
        "moving": ["A.PDB", "A.XTC"],
        "still": ["B.PDB"],
        "ready": [ready],
        "water": ["D.PDB"],
        "got": [],
    }


def test_a_simulated_molecule_is_what_the_simulation_gives(files):
    folder = "results/r/water/simulation"
    assert files.given(of("water")) == {"structure": "d.pdb"}
    found = {"structure": f"{folder}/topology.pdb", "trajectory": f"{folder}/trajectory.xtc"}
    assert files.molecule(of("water")) == found
    assert files.stage_before(of("water", stage="minimise")) == {}
    assert files.stage_before(of("water", stage="npt")) == {"before": f"{folder}/nvt"}


def test_a_stage_takes_the_time_that_the_config_or_the_protocol_says(files):
    stages = ("minimise", "nvt", "npt", "production")
    assert [files.nanoseconds(of("water", stage=stage)) for stage in stages] == [0.0, 0.1, 0.3, 1.0]


def test_atoms_of_a_conformation_come_with_the_frames_of_a_trajectory(files):
    own = "results/r/{}/c1/structure.pdb"
    assert files.atoms(of("ready", conformation="c1")) == {}
    assert files.structure(of("ready", conformation="c1")) == []
    assert files.atoms(of("still", conformation="c1")) == {"own": own.format("still")}
    assert files.atoms(of("moving", conformation="c1")) == {
        "structure": "a.pdb",
        "trajectory": "a.xtc",
        "frames": "results/r/moving/frames.csv",
        "own": own.format("moving"),
    }


def test_every_conformation_is_named_once_its_frames_are_chosen(files):
    assert files.every("a.csv", "residues.csv")(of("moving")) == [
        "results/r/moving/f0/a.csv",
        "results/r/moving/f0/residues.csv",
        "results/r/moving/f7/a.csv",
        "results/r/moving/f7/residues.csv",
    ]
    places = ["moving/f0", "moving/f7", "still/c1", "ready/c1", "water/f3", "got/c1"]
    assert files.every("a.csv")(Wildcards()) == [f"results/r/{place}/a.csv" for place in places]


def test_a_single_structure_has_no_frames(files, checkpoints):
    assert [name for name in files.proteins if files.has_frames(name)] == ["moving"]
    for stride, names in ((1, []), (2, files.many)):
        other = FilesOfARun(CONFIG | {"frames": {"stride": stride}}, checkpoints)
        assert [name for name in other.proteins if other.steps_over_frames(name)] == names


def test_what_the_config_goes_without_is_in_no_list(checkpoints):
    without = {"got": "cut short", "moving/f0": "no atoms", "still/draw_frames": "?"}
    files = FilesOfARun(CONFIG | {"without": without}, checkpoints)
    assert list(files.proteins) == ["moving", "still", "ready", "water"] and files.fetched == {}
    assert files.every("a.csv")(of("moving")) == ["results/r/moving/f7/a.csv"]
    assert files.first("moving") == "f0"  # the pairs' one stays the same
    assert files.goes_on_with("moving", "f7") and not files.goes_on_with("moving", "f0")
    assert not files.goes_on_with("got", "c1") and not files.goes_on_with(None, "c1")
    assert files.goes_without("still", "draw_frames") and not files.goes_without("still", "c1")


def test_frames_are_few_where_all_molecules_are_small(checkpoints, tmp_path):
    small, large = tmp_path / "small.pdb", tmp_path / "large.xtc"
    small.write_bytes(bytes(1000))
    with large.open("wb") as stream:
        stream.truncate(10**9)  # of zeros, which take no place on the disk
    still = {"structure": str(small)}

    def few(**proteins):
        return FilesOfARun(CONFIG | {"proteins": proteins}, checkpoints).few_frames

    assert few(a=still) and few(a={"surface": str(large)})
    moving = {"a": still, "b": still | {"trajectory": str(large)}}
    assert not few(**moving)
    assert FilesOfARun(CONFIG | {"proteins": moving, "frames": {"stride": 100}}, checkpoints).few_frames
    assert not few(a=still | {"simulate": {}})


def test_what_jobs_need_grows_with_the_files(checkpoints, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    files = FilesOfARun(CONFIG, checkpoints)
    (tmp_path / "c.dms").write_bytes(bytes(60_000))
    (tmp_path / "a.xtc").write_bytes(bytes(3_000_000))
    (tmp_path / "results/r/still/structures").mkdir(parents=True)
    (tmp_path / "results/r/still/structures/c1.pdb").write_bytes(bytes(81_000))
    (tmp_path / "a.pdb").write_bytes(bytes(500_000))
    assert files.megabytes(1)(of("moving")) == 3.5
    assert files.megabytes(10)(of("moving")) == 0.8  # all of the structure, a tenth of the trajectory
    assert files.dots(of("ready", conformation="c1")) == pytest.approx(1)
    assert files.dots(of("still", conformation="c1")) == pytest.approx(30)
    # 2 combinations, 500 draws, 30,000 / 200 test dots, two distances of 4 bytes; 2 readings, and one four times
    assert files.distances(of("still", conformation="c1")) == pytest.approx(2 * 500 * 150 * 8 * 6 / 1e6)


@pytest.mark.parametrize(
    ("proteins", "cores", "threads"),
    [
        (["moving"], 2, 1),  # two grids at once, each on its core
        (["moving"], 3, 3),  # one after the other
        (["moving"], 4, 2),
        (["moving"], 64, 4),  # at most eight in all
        (["still"], 2, 2),
        (["still", "ready", "got"], 2, 2),
        (["still", "ready", "got", "water", "moving"], 1, 1),
        (["moving", "ready"], 4, 1),
        (["moving", "ready", "got"], 4, 2),  # six grids in three rounds
        (["moving", "ready", "got", "water"], 2, 1),
    ],
)
def test_grids_run_side_by_side_where_that_leaves_no_core_idle(checkpoints, proteins, cores, threads):
    some = {name: CONFIG["proteins"][name] for name in proteins}
    asked = FilesOfARun(CONFIG | {"proteins": some}, checkpoints).side_by_side(8, cores)
    assert asked(of("moving" if "moving" in proteins else "still")) == threads


@pytest.mark.parametrize(("surfaces", "threads"), [(7, 2), (9, 1)])
def test_many_grids_run_side_by_side_even_if_the_last_is_alone(checkpoints, surfaces, threads):
    some = {f"s{k}": CONFIG["proteins"]["ready"] for k in range(surfaces)}
    asked = FilesOfARun(CONFIG | {"proteins": some}, checkpoints).side_by_side(8, 2)
    assert asked(of("s0")) == threads


def test_a_grid_of_a_cluster_gets_all_its_threads(files):
    assert files.side_by_side(8, None) == 8


def test_threads_can_be_asked_for_before_the_frames_are_chosen(files, monkeypatch):
    def not_yet(protein):
        raise IncompleteCheckpointException(SimpleNamespace(name="choose_frames"), "frames.csv")

    monkeypatch.setattr(files._checkpoints.choose_frames, "get", not_yet)
    assert files.side_by_side(8, 4)(of("moving")) == 4  # five proteins


ATOM = "ATOM      1  CA  ALA A   1       0.000   0.000   0.000  1.00  0.00           C\n"
TABLE = "data_x\nloop_\n_atom_site.group_PDB\n_atom_site.id\n_atom_site.{last}\n"


@pytest.mark.parametrize(
    ("name", "text", "one"),
    [
        ("a.pdb", ATOM + "END\n", True),
        ("a.ent", "MODEL        1\n" + ATOM + "ENDMDL\nEND\n", True),
        ("a.pdb", "MODEL        1\n" + ATOM + "ENDMDL\nMODEL        2\n" + ATOM + "ENDMDL\n", False),
        ("a.pdb", ATOM + "END\n" + ATOM, False),
        ("a.pdb", "MODEL 1\n" + ATOM + "MODEL 2\n" + ATOM + "END\n", False),
        ("a.pdb", "HEADER\nMODEL 1\n" + ATOM + "MODEL 2\n" + ATOM + "END\n", False),
        ("a.pdb", "HEADER\nMODEL 1\n" + ATOM + "END\n", True),
        ("a.cif", TABLE.format(last="pdbx_PDB_model_num") + "ATOM 1 1\nATOM 2 1\n#\n", True),
        ("a.cif.gz", TABLE.format(last="pdbx_PDB_model_num") + "ATOM 1 1\nATOM 2 1\n#\n", True),
        ("a.cif", TABLE.format(last="pdbx_PDB_model_num") + "ATOM 1 1\nHETATM 2 2\n#\n", False),
        ("a.cif", TABLE.format(last="Cartn_x") + "ATOM 1 1\nATOM 2 1\n#\n", False),
        ("a.cif", "data_x\n", False),
        ("a.h5", "", False),
    ],
)
def test_a_file_with_one_model_is_one_conformation(tmp_path, name, text, one):
    path = tmp_path / name
    path.write_bytes(gzip.compress(text.encode()) if name.endswith(".gz") else text.encode())
    assert has_one_model(str(path)) == one and not has_one_model(str(tmp_path / "no.pdb"))


@pytest.mark.parametrize(("use", "names"), [("clusters", ["c1"]), ("all", ["f0"]), ([3], ["f0"])])
def test_a_single_structure_waits_for_no_checkpoint(tmp_path, use, names):
    (tmp_path / "a.pdb").write_text(ATOM + "END\n")
    own = {"structure": str(tmp_path / "a.pdb")}
    proteins = {"one": own, "second": own | {"model": 2}, "moving": own | {"trajectory": "a.xtc"}}
    config = CONFIG | {"proteins": proteins, "frames": {"stride": 1, "use": use}}
    files = FilesOfARun(config, None)  # no checkpoint is asked
    assert (files.single, files.many) == (["one"], ["second", "moving"])
    assert files.conformations("one") == names and files.first("one") == names[0]
