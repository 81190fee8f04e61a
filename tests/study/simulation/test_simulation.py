"""The molecular dynamics before the study: parameters, checks of the structure, stages, quality."""

import json
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import yaml
from scipy.spatial.transform import Rotation

import warm_python
from conftest import ROOT
from peptides import STEP, peptide, write
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf_study.config.models import Simulate
from sparsurf_study.simulation import gromacs, protocol, quality, stages, system

pytestmark = pytest.mark.slow

SHORT_KEYS = {"ns": 0.0004, "nvt_ns": 0.0002, "npt_ns": 0.0002, "save_ps": 0.1}
SHORT = protocol.GROMACS_DEFAULTS | SHORT_KEYS
needs_gromacs = pytest.mark.skipif(
    not any(map(shutil.which, gromacs.PROGRAMS)),
    reason="GROMACS is not installed (Debian: apt install gromacs)",
)


def values(text):
    """Keys and values of a GROMACS parameter file."""
    return dict(line.split(" = ") for line in text.splitlines())


def test_parameters_are_those_of_the_paper():
    production = values(protocol.parameters("production", protocol.GROMACS_DEFAULTS | {"ns": 10_000}, 7))
    assert int(production["nsteps"]) * float(production["dt"]) == pytest.approx(1e7)  # ps: 10 µs
    assert (production["rcoulomb"], production["rvdw"]) == ("1.2", "1.2")  # nm: 12 Å
    assert (production["ref-t"], production["ref-p"], production["tau-p"]) == ("300 300", "1", "2")
    assert (production["tcoupl"], production["pcoupl"]) == ("V-rescale", "Parrinello-Rahman")
    assert int(production["nstxout-compressed"]) * float(production["dt"]) == pytest.approx(1.0)
    assert production["continuation"] == "yes" and "define" not in production
    nvt = values(protocol.parameters("nvt", protocol.GROMACS_DEFAULTS, 7))
    assert (nvt["nsteps"], nvt["gen-vel"], nvt["gen-seed"], nvt["define"]) == (
        "50000",
        "yes",
        "7",
        "-DPOSRES",
    )
    assert "pcoupl" not in nvt
    npt = values(protocol.parameters("npt", protocol.GROMACS_DEFAULTS, 7))
    assert (npt["gen-vel"], npt["pcoupl"], npt["define"]) == ("no", "Parrinello-Rahman", "-DPOSRES")
    minimise = values(protocol.parameters("minimise", protocol.GROMACS_DEFAULTS, 7))
    assert (minimise["emstep"], minimise["emtol"], minimise["integrator"]) == ("0.01", "1000", "steep")


def test_the_config_has_the_defaults_of_the_protocol():
    assert Simulate().model_dump().items() <= protocol.GROMACS_DEFAULTS.items()
    assert protocol.with_defaults({"ns": 5}) == protocol.GROMACS_DEFAULTS | {"ns": 5}


def test_the_step_reached_is_the_last_of_the_log(tmp_path):
    head = "           Step           Time\n"
    text = f"{head}              0        0.00000\nx\n{head}            350        0.7\n"
    assert stages.current_step(write(tmp_path / "md.log", text)) == 350
    assert stages.current_step(tmp_path / "none.log") == 0


@pytest.mark.parametrize(
    "said, why",
    [
        ("x\nFatal error:\nResidue 'XYZ' not found in\nthe topology\n\nFor more", "Residue 'XYZ' not found in the topology."),
        ("Error in user input:\nInvalid command-line options\n\nmore", "Invalid command-line options."),
        ("nothing to see\nlast words", "last words."),
        ("", "it gave no reason."),
    ],
)  # fmt: skip
def test_the_reason_of_a_failure_is_one_line(said, why):
    assert gromacs.reason(said) == why


def test_without_gromacs_one_sentence_says_how_to_get_it(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match=r"GROMACS.*apt install gromacs.*conda.*module"):
        gromacs.program()


def molecule(tmp_path, text):
    return read_molecule(write(tmp_path / "x.pdb", text + "END\n"))


def test_a_gap_is_named(tmp_path):
    broken = peptide() + peptide(first=6, origin=5 * STEP)  # residue 5 is missing
    with pytest.raises(InputError, match=r"broken between ALA 4 A and ALA 6 A;"):
        system.refuse_incomplete(molecule(tmp_path, broken), "x.pdb")
    system.refuse_incomplete(
        molecule(tmp_path, peptide() + "TER\n" + peptide(chain="B", origin=(40, 0, 0))), "x"
    )


def test_missing_atoms_are_named(tmp_path):
    lacking = "".join(line for line in peptide().splitlines(True) if line[12:16] != " CB " or line[25] != "3")
    with pytest.raises(InputError, match=r"x.pdb: atoms are missing in ALA 3 A; build"):
        system.refuse_incomplete(molecule(tmp_path, lacking), "x.pdb")
    lacking = "".join(line for line in peptide(["ALA"] * 10).splitlines(True) if line[12:16] != " O  ")
    with pytest.raises(InputError, match=r"in ALA 1 A, .* ALA 8 A and 2 more; build"):
        system.refuse_incomplete(molecule(tmp_path, lacking), "x.pdb")


def test_residues_that_the_force_field_does_not_know_are_named(tmp_path):
    folder = tmp_path / "toy.ff"
    folder.mkdir()
    (folder / "aminoacids.rtp").write_text("[ bondedtypes ]\n[ ALA ]\n [ atoms ]\n")
    (folder / "aminoacids.r2b").write_text("; names\nHISD HSD\n")
    known = system.known_residues(folder)
    assert known == {"bondedtypes", "ALA", "HISD", "HIS"}
    with pytest.raises(InputError, match=r"toy does not know MSE 2 A, MSE 4 A; replace"):
        system.refuse_unknown(
            molecule(tmp_path, peptide(("ALA", "MSE", "ALA", "MSE"))), "x.pdb", known, "toy"
        )


def test_energies_are_read_by_their_names(tmp_path):
    text = '# c\n@ title "x"\n@ s0 legend "Potential"\n@ s1 legend "Total Energy"\n0 -1.5 2\n0.5 -2.5 3\n'
    table = quality.read_xvg(write(tmp_path / "e.xvg", text))
    assert table.to_dict("list") == {
        "time_ps": [0, 0.5],
        "potential_kJ_mol": [-1.5, -2.5],
        "total_energy_kJ_mol": [2, 3],
    }


def test_motion_is_that_of_the_shape(tmp_path):
    still = molecule(tmp_path, peptide())
    turn = Rotation.random(random_state=1).as_matrix()
    frames = np.concatenate([still.xyz, 1.1 * still.xyz, still.xyz @ turn.T + 5])
    moving = still.__class__(
        **vars(still) | {"xyz": frames, "time_ps": np.arange(3.0), "frame_number": np.arange(3)}
    )
    table = quality.motion(moving)
    assert np.allclose(table["rmsd"][[0, 2]], 0, atol=1e-6)  # from the first frame, not from the one before
    alpha = still.xyz[0][still.name == "CA"]
    spread = np.sqrt(((alpha - alpha.mean(axis=0)) ** 2).sum(axis=1).mean())
    assert table["rmsd"][1] == pytest.approx(0.1 * spread)
    assert table["radius_of_gyration"][1] == pytest.approx(1.1 * table["radius_of_gyration"][0])


@pytest.fixture(scope="module")
def small_system(tmp_path_factory):
    """Residues 209 to 212 of the embedded example in water."""
    folder = tmp_path_factory.mktemp("md")
    (folder / "system").mkdir()
    chosen = read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="209-212")
    chosen = replace(chosen, chain=np.full(chosen.n_atoms, "Q"))
    built = system.prepare_system(chosen, "in.pdb", SHORT, 3, folder / "system")
    return folder, built, chosen


@needs_gromacs
def test_a_system_is_counted_as_built(small_system):
    _, built, chosen = small_system
    charge = sum(
        {"GLU": -1, "ASP": -1, "LYS": 1, "ARG": 1}.get(str(name), 0)
        for name in chosen.residue_name[chosen.name == "CA"]
    )
    assert built["protein_atoms"] == chosen.n_atoms + 1  # the second oxygen of the new chain end
    assert built["ions"] == abs(charge) and built["waters"] > 500
    assert built["atoms"] == built["protein_atoms"] + built["ions"] + 3 * built["waters"]


@needs_gromacs
def test_an_interrupted_stage_goes_on_where_it_was(small_system):
    folder, _, chosen = small_system
    before = None
    for stage in ("minimise", "nvt", "npt"):
        before = stages.run_stage(stage, folder / "system", before, SHORT, 3, folder / stage, 1)

    longer = SHORT | {"ns": 0.002}

    class Stop(Exception):
        pass

    def stop(done, of):
        assert of == 1000
        if done > 100:
            raise Stop

    where = folder / "production"
    with pytest.raises(Stop):
        stages.run_stage("production", folder / "system", before, longer, 3, where, 1, stop)
    assert (where / "state.cpt").is_file() and not (where / "final.gro").is_file()
    stages.run_stage("production", folder / "system", before, longer, 3, where, 1)
    assert "Restarting from checkpoint" in (where / "md.log").read_text(errors="replace")
    stages.extract_protein(folder / "system", where, folder / "topology.pdb", folder / "trajectory.xtc")
    protein = read_molecule(folder / "topology.pdb", folder / "trajectory.xtc")
    assert np.allclose(protein.time_ps, np.arange(21) * 0.1, atol=1e-3)
    assert set(protein.chain) == {"Q"} and sorted(set(protein.residue)) == ["209", "210", "211", "212"]
    assert protein.n_atoms == chosen.n_atoms + 1
    folders = {stage: folder / stage for stage in protocol.STAGES}
    table = quality.energies(folders)
    assert table["temperature_K"][table["stage"] == "production"].mean() == pytest.approx(300, abs=15)
    assert table["density_kg_m3"][table["stage"] == "nvt"].isna().all()


@needs_gromacs
def test_the_papers_fragment_gets_the_papers_water(shared, tmp_path):
    path = shared / "data" / "tdp43" / "4bs2_209-269.pdb"
    built = system.prepare_system(
        read_molecule(path).frame(0), path, protocol.GROMACS_DEFAULTS, 20261120, tmp_path
    )
    assert (built["waters"], built["atoms"], built["protein_atoms"], built["ions"]) == (4607, 14777, 953, 3)


@needs_gromacs
def test_a_structure_alone_becomes_a_study(tmp_path):
    protein = {
        "structure": str(ROOT / "data" / "tdp43" / "topology.pdb"),
        "residues": "209-212",
        "simulate": SHORT_KEYS | {"ns": 0.001},
    }
    study = {
        "run": "simulated",
        "proteins": {"fragment": protein},
        "frames": {"selection": [10]},
        "sampling": {"alpha": [0.5, 1.0], "beta": [0.0], "gamma": [0, 6], "delta": [0, 6]},
        "evaluation": {"test_dots": 40, "draws": 2},
        "tables": {"ranges": 3},
    }
    path = write(tmp_path / "config.yaml", yaml.safe_dump(study))
    where = ["--snakefile", ROOT / "Snakefile", "--directory", tmp_path, "--configfile", path, "--cores", "1"]
    requested = [
        f"results/simulated/fragment/{name}" for name in ("f10/ranges.csv", "figures/simulation.png")
    ]
    command = [warm_python.interpreter(), "-m", "snakemake", *requested, *map(str, where)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "results" / "simulated" / "fragment"
    built = json.loads((folder / "simulation" / "system.json").read_text())
    assert built["waters"] > 500
    assert built["atoms"] == built["protein_atoms"] + built["ions"] + 3 * built["waters"]
    frames = pd.read_csv(folder / "frames.csv")
    assert frames["time_ps"].tolist() == [1.0]
    quality_table = pd.read_csv(folder / "simulation" / "quality.csv").set_index("quantity")
    # a few thousand degrees of freedom: one frame scatters by 300 sqrt(2 / n), 5 K
    assert quality_table["mean"]["temperature_K"] == pytest.approx(300, abs=15)
    assert len(pd.read_csv(folder / "simulation" / "motion.csv")) == 11
    assert (folder / "f10" / "ranges.csv").is_file() and (folder / "figures" / "simulation.png").is_file()
