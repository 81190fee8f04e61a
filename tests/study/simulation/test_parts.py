"""Parts of the simulation that need no GROMACS: what is asked of it, and what is read from its files."""

import json
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from peptides import atom_line, peptide, write
from small_study import run_script
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf_study.simulation import gromacs, protocol, quality, stages, system

SYSTEM_GRO = """\
in water
   10
    1GLY      N    1   0.100   0.200   0.300
    1GLY     CA    2   0.200   0.200   0.300
    2SOL     OW    3   1.100   0.200   0.300
    2SOL    HW1    4   1.200   0.200   0.300
    2SOL    HW2    5   1.100   0.300   0.300
    3SOL     OW    6   2.100   0.200   0.300
    3SOL    HW1    7   2.200   0.200   0.300
    3SOL    HW2    8   2.100   0.300   0.300
    4NA      NA    9   3.100   0.200   0.300
    5CL      CL   10   4.100   0.200   0.300
   5.0 5.0 5.0
"""


def test_a_system_is_counted_from_its_files(tmp_path):
    write(tmp_path / "system.gro", SYSTEM_GRO)
    molecules = "[ molecules ]\n; name  number\nProtein_chain_A 1\nSOL   1\nSOL   1\nNA 1\nCL  1\n"
    write(tmp_path / "topol.top", "SOL 99\n" + molecules)
    assert system.count_molecules(tmp_path) == {"atoms": 10, "protein_atoms": 2, "waters": 2, "ions": 2}
    neutral = SYSTEM_GRO.replace("   10\n", "    8\n").replace(
        "    4NA      NA    9   3.100   0.200   0.300\n", ""
    )
    write(tmp_path / "system.gro", neutral.replace("    5CL      CL   10   4.100   0.200   0.300\n", ""))
    write(tmp_path / "topol.top", "[ molecules ]\nProtein 1\nSOL 2\n")
    assert system.count_molecules(tmp_path) == {"atoms": 8, "protein_atoms": 2, "waters": 2, "ions": 0}


def molecule(tmp_path, text, **keys):
    return read_molecule(write(tmp_path / "x.pdb", text + "END\n"), **keys)


def test_chains_come_back_residue_by_residue(tmp_path):
    text = peptide(("ALA", "GLY"), "A", 7) + "TER\n" + peptide(("ALA",), "B", 3, (30, 0, 0))
    one = molecule(tmp_path, text)
    atoms = list(zip(one.residue_index, one.residue_name, one.name, one.xyz[0], strict=True))
    atoms.insert(1, (0, "ALA", "H", np.ones(3)))  # a hydrogen that GROMACS built
    lines = [
        f"{r + 1:5d}{residue:<5s}{name:>5s}{k:5d}{x / 10:8.3f}{y / 10:8.3f}{z / 10:8.3f}\n"
        for k, (r, residue, name, (x, y, z)) in enumerate(atoms, 1)
    ]
    path = write(tmp_path / "h.gro", f"x\n{len(lines):5d}\n{''.join(lines)}   5.0 5.0 5.0\n")
    found = system.with_chains(path, one)
    assert found.name[1] == "H"
    for name in ("chain", "residue"):
        labels = getattr(one, name)
        assert getattr(found, name).tolist() == np.insert(labels, 1, labels[0]).tolist()
    assert found.chain[0] == "A" and found.residue[-1] == "3"
    with pytest.raises(InputError, match="GROMACS built 3 residues from 2"):
        system.with_chains(path, one.take(one.chain == "A"))


def test_only_protein_of_the_first_model_is_simulated(tmp_path, caplog):
    water = "HETATM   99  O   HOH A  99      50.000  50.000  50.000  1.00  0.00           O  \n"
    hydrogen = atom_line("H", "SER", "A", "3", (6, 3, 1))
    path = write(tmp_path / "x.pdb", peptide(("ALA", "GLY", "SER")) + hydrogen + water + "END\n")
    found = system.select_protein(path, {"residues": "2-3", "hydrogens": "keep", "ns": 1})
    assert sorted(set(found.residue_name)) == ["GLY", "SER"] and found.n_frames == 1
    assert "H" not in found.element
    assert set(system.select_protein(path, {"selection": "all"}).kind) == {"protein"}
    one = peptide(("ALA", "GLY"))
    path = write(tmp_path / "x.pdb", "".join(f"MODEL     {k:4d}\n{one}ENDMDL\n" for k in (1, 2)) + "END\n")
    assert system.select_protein(path, {}).n_frames == 1 and "has 2 models" in caplog.text
    caplog.clear()
    assert system.select_protein(path, {"model": 2}).n_frames == 1 and "models" not in caplog.text


def values(stage, **changes):
    text = protocol.parameters(stage, protocol.GROMACS_DEFAULTS | changes, 5)
    return dict(line.split(" = ") for line in text.splitlines())


def test_times_become_steps():
    found = values("production", ns=0.5, time_step_fs=4.0, save_ps=10.0, temperature=310.0, cutoff=10.0)
    assert (found["nsteps"], found["dt"], found["nstxout-compressed"]) == ("125000", "0.004", "2500")
    assert (found["nstenergy"], found["ref-t"], found["rvdw"]) == ("250", "310 310", "1")
    assert (
        values("nvt", nvt_ns=0.25)["nsteps"] == "125000" and values("npt", npt_ns=0.05)["nsteps"] == "25000"
    )
    assert (
        values("npt", pressure=2.0)["ref-p"] == "2" and values("nvt", temperature=290.0)["gen-temp"] == "290"
    )
    assert protocol.n_time_steps("production", protocol.GROMACS_DEFAULTS | {"ns": 1e-9}) == 1
    assert values("production", ns=1e-6)["nstenergy"] == "1"
    assert values("production", save_ps=0.0005)["nstxout-compressed"] == "1"
    assert [protocol.length_ns(s, protocol.GROMACS_DEFAULTS) for s in protocol.STAGES] == [0.0, 0.1, 0.1, 1.0]
    assert protocol.velocity_seed(0) == 1 and protocol.velocity_seed(2**31) == 1
    assert protocol.velocity_seed(7) == 7 and protocol.velocity_seed(2**31 + 4) == 5


@pytest.fixture
def asked(monkeypatch):
    """What GROMACS is asked for; it does nothing but lay the files that a stage ends with."""
    calls = []

    def run(*words, folder, stdin="", wait=None):
        calls.append((words, stdin))
        made = {"grompp": "topol.tpr", "mdrun": "final.gro"}.get(words[0])
        if made:
            (folder / made).write_text("made")
        if wait:
            write(folder / "md.log", "           Step           Time\n            350        0.7\n")
            wait()

    monkeypatch.setattr(gromacs, "run_gromacs", run)
    monkeypatch.setattr(gromacs, "program", lambda: "/usr/bin/gmx")
    return calls


def test_a_stage_runs_once_and_again_where_its_inputs_change(asked, tmp_path):
    built, before, own = (tmp_path / name for name in ("system", "nvt", "npt"))
    for folder in (built, before):
        folder.mkdir()
    for path in (built / "topol.top", before / "final.gro", before / "state.cpt"):
        path.write_text("one")

    def run(settings=protocol.GROMACS_DEFAULTS):
        asked.clear()
        stages.run_stage("npt", built, before, settings, 3, own, 2)
        return [words[0] for words, _ in asked]

    assert run() == ["grompp", "mdrun"]
    grompp, mdrun = (words for words, _ in asked)
    assert grompp[grompp.index("-c") + 1] == grompp[grompp.index("-r") + 1] == before / "final.gro"
    assert grompp[grompp.index("-t") + 1] == before / "state.cpt" and grompp[-1] == 0
    assert mdrun[mdrun.index("-nt") + 1] == 2 and "-cpi" not in mdrun and "state.cpt" in mdrun
    assert run() == []
    (own / "final.gro").unlink()
    (own / "state.cpt").write_text("checkpoint")
    assert run() == ["mdrun"]
    assert "-cpi" in asked[0][0]
    assert run(protocol.GROMACS_DEFAULTS | {"temperature": 310.0}) == ["grompp", "mdrun"]
    for path in (built / "topol.top", built / "chain.itp", before / "final.gro", before / "state.cpt"):
        path.write_text("two")
        assert run(protocol.GROMACS_DEFAULTS | {"temperature": 310.0}) == ["grompp", "mdrun"], path.name
    assert json.loads((own / "stage.json").read_text())["inputs"]
    (before / "state.cpt").unlink()  # a minimisation has none
    assert run() == ["grompp", "mdrun"] and "-t" not in asked[0][0]
    (built / "system.gro").write_text("one")
    told = []
    stages.run_stage(
        "npt", built, None, protocol.GROMACS_DEFAULTS, 3, own, 2, lambda *steps: told.append(steps)
    )
    grompp = asked[2][0]
    assert grompp[grompp.index("-c") + 1] == built / "system.gro" and told == [(350, 50000)]
    assert (own / "stage.mdp").read_text() == protocol.parameters("npt", protocol.GROMACS_DEFAULTS, 3)


def test_a_system_is_built_by_the_keys_of_its_protein(asked, monkeypatch, tmp_path):
    """A box is as large as its margin, 15 Å and so 1.5 nm; `seed` places the ions."""
    monkeypatch.setattr(gromacs, "version", lambda: "2025")
    monkeypatch.setattr(gromacs, "force_field_folder", lambda name: tmp_path / name)
    (tmp_path / "mine").mkdir()
    write(tmp_path / "mine" / "a.rtp", "[ ALA ]\n")
    protein = molecule(tmp_path, peptide(("ALA", "ALA")))
    monkeypatch.setattr(system, "with_chains", lambda path, given: given)
    for name, text in (("system.gro", SYSTEM_GRO), ("topol.top", "[ molecules ]\nSOL 2\nNA 1\nCL 1\n")):
        write(tmp_path / name, text)
    keys = protocol.GROMACS_DEFAULTS | {"force_field": "mine", "water": "tip4p", "margin": 15.0}
    built = system.prepare_system(protein, "in.pdb", keys, 7, tmp_path)
    assert (built["waters"], built["ions"], built["gromacs"]) == (2, 2, "2025")
    options = {words[0]: dict(pairwise(words)) for words, _ in asked}
    assert (options["pdb2gmx"]["-ff"], options["pdb2gmx"]["-water"]) == ("mine", "tip4p")
    assert options["editconf"]["-d"] == 1.5 and options["genion"]["-seed"] == 7
    assert (options["genion"]["-pname"], options["genion"]["-nname"]) == ("NA", "CL")
    assert read_molecule(tmp_path / "protein.pdb").n_atoms == protein.n_atoms


def test_the_jobs_of_a_simulation_follow_its_keys(asked, monkeypatch, tmp_path):
    """From a file with more than is chosen, to the folder of a finished stage, and its means against their targets."""
    monkeypatch.setattr(gromacs, "version", lambda: "2025")
    monkeypatch.setattr(gromacs, "force_field_folder", lambda name: tmp_path)
    monkeypatch.setattr(system, "with_chains", lambda path, given: given)
    counted = {"atoms": 9, "protein_atoms": 5, "waters": 1, "ions": 1}
    monkeypatch.setattr(system, "count_molecules", lambda folder: counted)
    write(tmp_path / "a.rtp", "[ ALA ]\n")
    path = str(write(tmp_path / "in.pdb", peptide(("ALA", "ALA", "ALA")) + "END\n"))
    made = {"system": str(tmp_path / "system"), "contents": str(tmp_path / "system.json")}
    params = {"simulate": {"water": "tip4p"}, "structure_options": {"residues": "2-3"}, "seed": 11}
    run_script("prepare_system", tmp_path, {"structure": path}, made, params, protein="p")
    options = {words[0]: dict(pairwise(words)) for words, _ in asked}
    assert options["pdb2gmx"]["-water"] == "tip4p" and options["genion"]["-seed"] == 11
    assert {*read_molecule(tmp_path / "system" / "protein.pdb").residue} == {"2", "3"}
    assert json.loads((tmp_path / "system.json").read_text()) == counted | {"gromacs": "2025"}

    (before := tmp_path / "minimise").mkdir()
    for place in (before / "final.gro", tmp_path / "system" / "topol.top"):
        write(place, "x")
    params = {
        "simulate": {"temperature": 310.0},
        "stage": "nvt",
        "unfinished": str(tmp_path / "running"),
        "seed": 11,
    }
    inputs = {"system": made["system"], "before": str(before)}
    run_script("simulate_stage", tmp_path, inputs, {"folder": str(tmp_path / "nvt")}, params, protein="p")
    wanted = protocol.parameters("nvt", protocol.GROMACS_DEFAULTS | {"temperature": 310.0}, 11)
    assert (tmp_path / "nvt" / "stage.mdp").read_text() == wanted and not (tmp_path / "running").exists()
    assert (tmp_path / "nvt" / "final.gro").is_file()


def test_a_simulation_is_judged_by_its_own_targets(monkeypatch, tmp_path):
    text = "".join(f"MODEL     {k:4d}\n{peptide(origin=(k, 0, 0))}ENDMDL\n" for k in (1, 2)) + "END\n"
    means = {"temperature_K": 310.0, "pressure_bar": 40.0, "density_kg_m3": 1006.0}
    rows = pd.DataFrame(
        means | {"potential_kJ_mol": -5.0, "total_energy_kJ_mol": -3.0, "stage": ["production"] * 60}
    )
    given = []
    monkeypatch.setattr(
        quality, "energies", lambda folders: given.append(folders) or rows.assign(time_ps=np.arange(60.0))
    )
    topology = write(tmp_path / "topology.pdb", text)
    moving = read_molecule(topology)
    monkeypatch.setattr("sparsurf.molecules.read_molecule.read_molecule", lambda *_: moving)
    inputs = {"topology": topology, "trajectory": "t.xtc"} | {
        stage: f"of/{stage}" for stage in protocol.STAGES
    }
    names = {"png": "simulation.png"} | {name: f"{name}.csv" for name in ("energies", "motion", "quality")}
    outputs = {name: str(tmp_path / file) for name, file in names.items()}
    run_script(
        "judge_simulation", tmp_path, inputs, outputs, {"simulate": {"temperature": 310.0}}, protein="p"
    )
    assert given == [{stage: f"of/{stage}" for stage in protocol.STAGES}]
    judged = pd.read_csv(outputs["quality"]).set_index("quantity")
    assert judged["near"].to_dict() == {"temperature_K": True, "pressure_bar": False, "density_kg_m3": True}
    assert judged.loc["temperature_K", "target"] == 310
    assert len(pd.read_csv(outputs["energies"])) == 60 and len(pd.read_csv(outputs["motion"])) == 2
    said = (tmp_path / "judge_simulation.log").read_text()
    assert said.count("WARNING ") == 1 and "WARNING the mean pressure_bar of the production is 40 " in said


@pytest.mark.parametrize(("program", "option"), [("gmx", "-nt"), ("gmx_mpi", "-ntomp")])
def test_threads_are_given_to_either_program(asked, monkeypatch, tmp_path, program, option):
    monkeypatch.setattr(gromacs, "program", lambda: f"/opt/{program}")
    (tmp_path / "system").mkdir()
    write(tmp_path / "system" / "system.gro", "x")
    stages.run_stage("minimise", tmp_path / "system", None, protocol.GROMACS_DEFAULTS, 3, tmp_path / "own", 6)
    options = dict(pairwise(asked[-1][0]))
    assert options[option] == 6 and not {"-x", "-cpo"} & options.keys()


def test_energies_are_those_that_a_stage_has(monkeypatch, tmp_path):
    """A minimisation has the potential alone, and only a barostat gives a density."""
    for stage in protocol.STAGES:
        (tmp_path / stage).mkdir()
        write(tmp_path / stage / "stage.mdp", protocol.parameters(stage, protocol.GROMACS_DEFAULTS, 1))
        if stage != "minimise":
            write(tmp_path / stage / "state.cpt", "")

    def energy(*words, folder, stdin):
        names = stdin.split()
        legends = [f'@ s{k} legend "{name.replace("Total-", "Total ")}"\n' for k, name in enumerate(names)]
        values = " ".join(str(10 * protocol.STAGES.index(folder.name) + len(name)) for name in names)
        write(words[words.index("-o") + 1], f"{''.join(legends)}0.5 {values}\n")

    monkeypatch.setattr(gromacs, "run_gromacs", energy)
    table = quality.energies({stage: tmp_path / stage for stage in protocol.STAGES})
    nan = float("nan")
    wanted = [[0.5, 9, nan, nan, nan, nan], [0.5, 19, 22, 21, 18, nan]]
    wanted += [[0.5, 29, 32, 31, 28, 27], [0.5, 39, 42, 41, 38, 37]]
    names = "potential_kJ_mol total_energy_kJ_mol temperature_K pressure_bar density_kg_m3"
    assert table["stage"].tolist() == [*protocol.STAGES]
    np.testing.assert_array_equal(table[["time_ps", *names.split()]].to_numpy(), wanted)


def test_the_interval_of_a_series_is_that_of_its_ten_blocks():
    """Block means 0 to 9: standard deviation 3.0277, and Student's t of 9 degrees of freedom is 2.2622 at 97.5 %."""
    mean, half = quality.mean_of_blocks(np.repeat(np.arange(10.0), 4))
    assert mean == 4.5 and half == pytest.approx(2.2622 * 3.0277 / 10**0.5, abs=1e-3)
    assert np.isnan(quality.mean_of_blocks(np.arange(19.0))).tolist() == [False, True]  # too short for blocks
    assert np.isnan(quality.mean_of_blocks(np.array([]))).all()


@pytest.mark.parametrize(
    ("column", "off", "near"),
    [("temperature_K", 300.99, True), ("temperature_K", 301.01, False), ("temperature_K", 298.99, False),
     ("pressure_bar", 11.0, True), ("pressure_bar", 11.5, False), ("density_kg_m3", 1036.0, True),
     ("density_kg_m3", 975.0, False)],
)  # fmt: skip
def test_a_mean_off_its_target_is_reported_where_there_are_fifty_values(column, off, near):
    means = {"temperature_K": 300.0, "pressure_bar": 1.0, "density_kg_m3": 1006.0} | {column: off}
    table = pd.DataFrame(means | {"stage": ["production"] * 50})
    before = pd.DataFrame({"stage": ["npt"] * 50, "temperature_K": 0.0})  # does not count
    judged = quality.judge(pd.concat([before, table]), protocol.GROMACS_DEFAULTS).set_index("quantity")
    assert judged["near"].to_dict() == dict.fromkeys(means, True) | {column: near}
    assert len(quality.warnings(judged.reset_index())) == (not near)
    others = protocol.GROMACS_DEFAULTS | {"temperature": off if column == "temperature_K" else 300.0}
    others["pressure"] = (
        off if column == "pressure_bar" else 1.0
    )  # targets of the config; the density has none
    judged = quality.judge(table, others).set_index("quantity")
    assert judged["near"].all() == (near or column != "density_kg_m3")
    assert judged.loc[column, "mean"] == pytest.approx(off)
    short = quality.judge(table.head(49), protocol.GROMACS_DEFAULTS)
    assert short["near"].isna().all() and not quality.warnings(short)


def test_a_mean_that_is_uncertain_may_be_near():
    wide = pd.DataFrame({"stage": "production", "temperature_K": 311.5 + np.repeat([-200.0, 200.0], 25)})
    judged = quality.judge(wide.assign(pressure_bar=1.0, density_kg_m3=1006.0), protocol.GROMACS_DEFAULTS)
    assert judged["near"].all()


def test_the_radius_of_gyration_is_that_of_the_heavy_atoms():
    """The C-alpha atoms move, and come back; an oxygen stays in their middle, and a hydrogen does not count."""
    xyz = np.array([[[0.0, 0, 0], [x, 0, 0], [x / 2, 0, 0], [0, 50, 0]] for x in (4.0, 8.0, 4.0)])
    moving = SimpleNamespace(
        xyz=xyz,
        name=np.array(["CA", "CA", "O", "H"]),
        heavy=np.array([True, True, True, False]),
        time_ps=np.array([0.0, 1, 2]),
    )
    table = quality.motion(moving)
    assert table["radius_of_gyration"].tolist() == pytest.approx(np.array([2, 4, 2]) * (2 / 3) ** 0.5)
    assert table["rmsd"].tolist() == pytest.approx([0, 2, 0])  # each 2 Å off, with equal middles
    assert table["time_ps"].tolist() == [0, 1, 2]


def test_an_old_gromacs_is_refused(monkeypatch):
    for said, old in {
        "2018.8": True,
        "2019": False,
        "2022.5-Debian": False,
        "unknown": False,
        "5.1.4": True,
    }.items():
        monkeypatch.setattr(gromacs, "_build_information", lambda said=said: {"GROMACS version": said})
        monkeypatch.setattr(gromacs, "program", lambda: "gmx")
        if old:
            with pytest.raises(InputError, match=f"needs GROMACS 2019 or later, but gmx is version {said}"):
                gromacs.version()
        else:
            assert gromacs.version() == said


def test_force_fields_are_sought_where_gromacs_does(monkeypatch, tmp_path):
    places = {"lib": tmp_path / "lib", "data": tmp_path / "data" / "top"}
    places["prefix"] = tmp_path / "usr" / "share" / "gromacs" / "top"
    for name, place in places.items():
        (place / f"{name}.ff").mkdir(parents=True)
        (place / "every.ff").mkdir()
    monkeypatch.setattr(gromacs, "_build_information", lambda: {"Data prefix": str(tmp_path / "usr")})
    monkeypatch.setenv("GMXLIB", str(places["lib"]))
    monkeypatch.setenv("GMXDATA", str(tmp_path / "data"))
    for name, place in places.items():
        assert gromacs.force_field_folder(name) == place / f"{name}.ff"
    assert gromacs.force_field_folder("every") == places["lib"] / "every.ff"
    monkeypatch.delenv("GMXLIB")
    assert gromacs.force_field_folder("every") == places["data"] / "every.ff"
    with pytest.raises(InputError, match=r"has no 'none'; it has data, every, prefix\."):
        gromacs.force_field_folder("none")


def test_gromacs_says_why_it_failed(monkeypatch, tmp_path, capsys):
    program = tmp_path / "gmx"
    program.write_text(
        '#!/bin/sh\ncat\necho "args $@"\necho "Fatal error:"\necho "no such\nfile"\necho\nexit ${CODE:-3}\n'
    )
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    with pytest.raises(InputError, match="`gmx trjconv` failed:"):
        gromacs.run_gromacs("trjconv", "-f", 7, folder=tmp_path, stdin="Protein\n")
    monkeypatch.setenv("CODE", "0")
    said = gromacs.run_gromacs("trjconv", "-f", 7, folder=tmp_path, stdin="Protein\n")
    assert (
        said.startswith("Protein\nargs -quiet -nobackup trjconv -f 7\n") and said in capsys.readouterr().out
    )
