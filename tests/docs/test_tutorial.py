"""Pages of the book, word for word: their commands and their Python, on a short peptide."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import mdtraj
import pandas as pd
import pytest

import sparsurf
import warm_python
from conftest import ROOT
from sparsurf_study.config.check import check_config, read_config

pytestmark = pytest.mark.slow


def page(name):
    """The source of a page of the book."""
    return (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")


def blocks(language, name="tutorial"):
    """The code blocks of a language, in their order."""
    return re.findall(rf"^```{language}\n(.*?)^```", page(name), re.M | re.S)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with `protein.pdb`, in which all of the tutorial was done; its processes are forks of a warm Python."""
    folder = tmp_path_factory.mktemp("tutorial")
    shutil.copy(ROOT / "evidence" / "quick" / "piece_1.pdb", folder / "protein.pdb")
    (folder / "bin").mkdir()
    python, script = warm_python.interpreter(), folder / "bin" / "sparsurf.py"
    script.write_text("import sys\nfrom sparsurf.cli.command import main\nsys.exit(main(sys.argv[1:]))\n")
    (folder / "bin" / "sparsurf").write_text(f'#!/bin/sh\nexec "{python}" "{script}" "$@"\n')
    (folder / "bin" / "sparsurf").chmod(0o755)
    environment = os.environ | {"PATH": f"{folder / 'bin'}:{os.environ['PATH']}", "MPLBACKEND": "agg"}
    environment |= {"PYTHONPATH": str(ROOT / "src"), "DISPLAY": "", "WAYLAND_DISPLAY": ""}  # no browser opens
    (folder / "lines.py").write_text("".join(blocks("python")), encoding="utf-8")
    for command in (["sh", "-ec", "".join(blocks("bash"))], [python, "lines.py"]):
        done = subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr
    return folder


def test_the_tutorial_gives_what_it_says(folder):
    kept, whole = (pd.read_csv(folder / f"{name}.csv") for name in ("minimal", "roughness"))
    assert len(kept) == pytest.approx(len(whole) / 10, abs=1)
    again, dots = (
        len(sparsurf.read_surface(folder / f"{name}.ply").points) for name in ("recovered", "surface")
    )
    assert again > 0.9 * dots
    assert "roughest residues</h2>" in (folder / "protein.html").read_text(encoding="utf-8")
    for picture in ("figure", "roughness", "residues"):
        assert (folder / f"{picture}.png").stat().st_size > 10_000
    assert (folder / "figure.pdf").is_file()


def test_the_residues_to_look_at_are_the_roughest_of_the_table(folder):
    table, listed = (pd.read_csv(folder / f"{name}.csv") for name in ("residues", "residues_to_look_at"))
    seen = table.query("area >= 20").dropna(subset="mean_roughness").sort_values("mean_roughness").head(10)
    assert [*listed["residue"]] == [*seen["residue"]] and len(table) > len(listed) == 10
    assert listed["mean_roughness"].to_numpy() == pytest.approx(seen["mean_roughness"].to_numpy(), rel=1e-6)


def test_more_dots_are_better_than_few_and_than_uniform_ones(folder):
    table = pd.read_csv(folder / "table.csv")
    z, error = table["Z"], table["Z_se"]
    assert z.iloc[0] - z.iloc[-1] > 3 * error.iloc[0]
    assert (
        z.diff().iloc[1:] < error.iloc[1:]
    ).all()  # the curve is flat at few dots of a peptide: 0.61, 0.62
    assert table["d"].iloc[0] > 0.1


def test_the_commands_and_the_python_of_the_readme_do_what_they_say(folder, tmp_path):
    shutil.copy(folder / "protein.pdb", tmp_path)
    shutil.copytree(ROOT / "data" / "tdp43", tmp_path / "data" / "tdp43")
    frame, moved = (mdtraj.load(folder / "protein.pdb") for _ in range(2))
    moved.xyz += 0.1
    mdtraj.join([frame, moved]).save_xtc(tmp_path / "run.xtc")
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    installed, *blocks_of_text = re.findall(r"(?ms)^```bash\n(.*?)^```", text)
    commands = installed.removeprefix("pip install .\n") + "".join(
        block for block in blocks_of_text if block.startswith("sparsurf")
    )
    (lines,) = re.findall(r"(?ms)^```python\n(.*?)^```", text)
    environment = os.environ | {
        "PATH": f"{folder / 'bin'}:{os.environ['PATH']}",
        "PYTHONPATH": str(ROOT / "src"),
    }
    code = lines + "print(len(dots), len(few), len(dense), xyz.shape)\n"
    (tmp_path / "lines.py").write_text(code, encoding="utf-8")
    subprocess.run(["sh", "-ec", commands], cwd=tmp_path, env=environment, check=True)
    assert (tmp_path / "topology.html").is_file()
    said = subprocess.run(
        [warm_python.interpreter(), "lines.py"],
        cwd=tmp_path,
        env=environment,
        check=True,
        stdout=subprocess.PIPE,
    )
    whole, kept, again, *_ = map(int, re.findall(rb"\d+", said.stdout))
    assert kept == len(pd.read_csv(tmp_path / "minimal.csv")) < 0.2 * whole and again > 0.9 * whole
    assert b"(1024, 3)" in said.stdout


def test_the_readme_and_the_book_are_short():
    hidden = r"(?s)<!--.*?-->|^```.*?^```|\]\(.*?\)"

    def words(page):
        text = re.sub(hidden, "", page.read_text(encoding="utf-8"), flags=re.M)
        return len(re.sub(r"\||-{3,}|<img.*?>", " ", text).split())

    assert words(ROOT / "README.md") <= 1_000
    assert sum(map(words, ROOT.glob("docs/*.md"))) <= 23_500


def test_its_study_is_one(folder, monkeypatch):
    (config,) = blocks("yaml")
    (folder / "my_study.yaml").write_text(config)
    monkeypatch.chdir(folder)
    assert check_config(read_config("my_study.yaml"))["run"] == "my_study"


def test_few_dots_serve_a_descriptor_of_ones_own_as_its_page_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shutil.copy(ROOT / "evidence" / "quick" / "piece_1.pdb", "protein.pdb")
    section = page("python").partition("## Points for a descriptor of your own")[2].partition("\n## ")[0]
    exec("".join(re.findall(r"^```python\n(.*?)^```", section, re.M | re.S)), {})
    (_, floor), *rows = (line.split() for line in capsys.readouterr().out.splitlines())
    errors = pd.DataFrame(rows, columns=["percent", "as they are", "reconstructed"], dtype=float)
    assert (errors["reconstructed"] < errors["as they are"]).all()
    assert errors["as they are"].iloc[0] > 3 * float(floor) > errors["reconstructed"].iloc[2]


@pytest.mark.parametrize("name", ["start", "study", "trajectory", "proteins"])
def test_every_config_of_a_page_is_one(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    configs = blocks("yaml", name)
    for config in configs:
        for path in map(Path, re.findall(r"[\w./]+\.(?:pdb|xtc)\b", config)):
            path.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(
                ROOT / "data" / "tdp43" / f"{'trajectory.xtc' if path.suffix == '.xtc' else 'topology.pdb'}",
                path,
            )
        if "my_structures/" in config:
            Path("my_structures").mkdir()
            shutil.copy(ROOT / "evidence" / "quick" / "piece_1.pdb", "my_structures")
        Path("my_study.yaml").write_text(config)
        assert check_config(read_config("my_study.yaml"))["run"] in config
    assert configs
