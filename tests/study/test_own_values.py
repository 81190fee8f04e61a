"""Own tables, ligands and frames as a user asks for them, by commands and by studies, against areas by positions."""

import numpy as np
import pandas as pd
import pytest

import sparsurf
from conftest import sphere
from peptides import atom_line, peptide, write
from small_study import planned_jobs, run_job
from sparsurf.cli import command
from sparsurf_study.batches.tables import read_parquet

NAMES = ("GLY", "ALA", "SER", "CYS", "ALA")
BONDI = {"C": 1.7, "N": 1.55, "O": 1.52, "S": 1.8}
PLACES = {"QA1": (4.0, 4.6, 2.0), "QB2": (8.0, -3.2, 0.5)}  # Å, of ligands
SCALE = {"GLY": 4.0, "ALA": 3.0, "SER": 10.0, "CYS": 7.0}


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """Two structures, each with a ligand of its own name, models, and tables."""
    folder = tmp_path_factory.mktemp("own")
    (folder / "structures").mkdir()
    for name, start in PLACES.items():
        ligand = "".join(
            atom_line(f"C{k}", name, "A", "900", np.add(start, (0.7 * k, 1.2 * (k % 2), 0)), record="HETATM")
            for k in (1, 2, 3)
        )
        write(folder / "structures" / f"{name}.pdb", peptide(NAMES, first=215) + "TER\n" + ligand + "END\n")
    write(folder / "structures" / "third.pdb1", peptide(NAMES, first=215) + "END\n")
    models = (peptide(NAMES, origin=(0, 0, 0.1 * k)) for k in range(5))
    write(folder / "models.pdb", "".join(f"MODEL {k}\n{text}ENDMDL\n" for k, text in enumerate(models, 1)))
    write(folder / "scale.csv", "residue_name,score\nGly,4\nala,3\nSER,10\nCys,7\n")
    write(folder / "shifted.csv", "chain,residue,residue_name,score\nA,216,GLY,1\nA,217,ALA,2\n")
    write(folder / "elsewhere.csv", "chain,residue,score\nB,215,1\nA,216,2\nB,217,1\n")
    write(folder / "nowhere.csv", "chain,residue,score\nB,215,1\n")
    return folder


def buried_by_positions(path, name, n=6000):
    """Accessible area of a ligand that the protein buries, by n positions on the sphere of each atom."""
    molecule = sparsurf.read_molecule(path, ligands=True)
    own, unit = np.flatnonzero(molecule.residue_name == name), sphere(n)[0]
    reach = np.array([BONDI[element] for element in molecule.element]) + 1.4

    def accessible(present):
        total = 0.0
        for atom in own:
            places = molecule.xyz[0, atom] + reach[atom] * unit
            others = present[present != atom]
            gaps = np.linalg.norm(places[:, None] - molecule.xyz[0, others], axis=2) - reach[others]
            total += (gaps >= 0).all(axis=1).mean() * 4 * np.pi * reach[atom] ** 2
        return total

    return accessible(own) - accessible(np.arange(molecule.n_atoms))


def run(capsys, *words):
    """Return the exit code of a command, and what it says."""
    code = command.main([str(word) for word in words])
    return code, capsys.readouterr().err


@pytest.mark.parametrize("ligands", ["all", "true", "QA1,QB2"])
def test_all_ligands_of_a_folder_have_their_buried_areas(place, capsys, ligands):
    table = place / "groups.csv"
    folder = place / "structures"
    keys = ("--radii", "bondi", "--of", "groups", "--ligands", ligands)
    if ligands == "QA1,QB2":  # the third has none, and is named
        code, said = run(capsys, "areas", folder, *keys, "-o", table)
        assert code == 0 and "1 of 3 structures is left out" in said and "third" in said
    else:
        assert run(capsys, "areas", folder, *keys, "-o", table)[0] == 0
    rows = pd.read_csv(table).set_index(["name", "group"])["buried"]
    for name in PLACES:
        expected = buried_by_positions(folder / f"{name}.pdb", name)
        assert rows[name, f"{name} 900 A"] == pytest.approx(expected, abs=0.4) and expected > 10


@pytest.mark.parametrize(
    "words", ["residues --fields score", "surface --fields score", "minimal --fields score"]
)
def test_a_table_fits_or_is_told(place, tmp_path, capsys, words):
    name, *options = words.split()
    path = write(tmp_path / "a.pdb", (place / "structures" / "third.pdb1").read_text())
    for table, exit_code, sentence in (
        ("elsewhere.csv", 0, "2 of 3 rows name no residue or atom of the molecule: B 215, B 217"),
        (
            "shifted.csv",
            1,
            "row 1: residue_name is GLY, and the molecule has ALA 216 A there (2 rows disagree)",
        ),
        ("nowhere.csv", 1, "no row fits a residue of the molecule"),
        ("scale.csv", 0, ""),
    ):
        out = tmp_path / f"{table}.csv"
        code, said = run(capsys, name, path, "--table", place / table, *options, "-o", out)
        assert code == exit_code and sentence in said and out.exists() == (code == 0)
    found = pd.read_csv(out)
    column = "mean_score" if name == "residues" else "score"
    assert found[column].tolist() == [SCALE[residue] for residue in found["residue_name"]]


def test_regions_tell_the_dots_without_a_value(place, tmp_path, capsys):
    path = write(tmp_path / "a.pdb", (place / "structures" / "third.pdb1").read_text())
    call = ("regions", path, "--table", place / "elsewhere.csv", "--field", "score", "--above", "0")
    code, said = run(capsys, *call, "-o", tmp_path / "out.csv")
    dots = sparsurf.surface(path, cavities="remove")
    n_blank = int((dots.molecule.residue[dots.atom] != "216").sum())
    assert code == 0 and f"{n_blank:,} of {len(dots):,} dots have no value and are in no region" in said


@pytest.mark.slow
def test_a_study_reads_all_ligands_a_scale_and_some_frames(place):
    proteins = {
        name: {"structure": f"structures/{name}.pdb", "ligands": "all", "table": "scale.csv"}
        for name in PLACES
    }
    config = {"run": "own", "sampling": False, "pages": [], "fields": ["score"], "proteins": proteins}
    job = next(job for job in planned_jobs(place, config) if job["rule"] == "analyse_batch")
    assert run_job(place, job).returncode == 0
    residues = read_parquet(place / "results" / "own", "residues").set_index("protein")
    for name in PLACES:
        molecule = sparsurf.read_molecule(place / "structures" / f"{name}.pdb", ligands=True)
        found, exact = residues.loc[name], sparsurf.areas(molecule).residues
        assert found["residue_name"].tolist() == [*NAMES, name] == exact["residue_name"].tolist()
        assert found["area"].to_numpy() == pytest.approx(exact["excluded"].to_numpy(), abs=0.01)
        assert found["mean_score"].tolist()[:-1] == [SCALE[residue] for residue in NAMES]
    config |= {"proteins": {"m": {"structure": "models.pdb", "table": "scale.csv"}}, "pages": ["m"]}
    config["frames"] = {"selection": "all", "start": 1, "stop": 4}
    job = next(job for job in planned_jobs(place, config) if job["rule"].startswith("choose_"))
    assert run_job(place, job).returncode == 0
    assert pd.read_csv(place / "results/own/m/frames.csv")["frame"].tolist() == [1, 2, 3]
