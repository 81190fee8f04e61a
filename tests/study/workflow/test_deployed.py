"""The workflow deployed from a repository of a host, as `snakedeploy deploy-workflow` does; a bare clone plays the host."""

import os
import shutil
import subprocess

import pytest
import yaml

import sparsurf
import warm_python
from conftest import ROOT
from peptides import peptide, write
from small_study import SEQUENCE, output, snakemake
from test_package import build_wheel, environment_with

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("git") is None, reason="git is not installed"),
]

# What snakedeploy 0.17 writes into workflow/Snakefile
SNAKEFILE = """
from snakemake.utils import min_version

min_version("6.10.0")

configfile: "config/config.yaml"

module sparsurf:
    snakefile:
        github("owner/sparsurf", path="workflow/Snakefile", tag="{tag}")
    config:
        config

use rule * from sparsurf
"""
CAPTIONS = "src/sparsurf_study/report/captions"
OF_REPOSITORY = ("Snakefile", "workflow", "rules", "scripts", "envs", "config", "profiles", CAPTIONS)
CONFIG = {"run": "own", "sampling": False, "proteins": {"p": {"structure": "in/p.pdb"}}}
SURFACE = [
    f"results/own/p/c1/{name}" for name in ("surface.npz", "structure.pdb", "roughness.csv", "surface.html")
]


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    """Cache of a user in which Snakemake finds the repository: the tag `ours`, and `next`, of another version."""
    source, folder = (tmp_path_factory.mktemp(name) for name in ("source", "cache"))
    for name in OF_REPOSITORY:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, source / name)
    version = source / "src" / "sparsurf" / "version.py"
    version.parent.mkdir(parents=True, exist_ok=True)
    bare = folder / "snakemake/snakemake/source-cache/snakemake-git-cache/github.com/owner/sparsurf"
    git = ["git", "-C", source, "-c", "user.name=tests", "-c", "user.email=tests@localhost"]
    subprocess.run([*git, "init", "--quiet"], check=True)
    for tag, text in (
        ("ours", (ROOT / "src/sparsurf/version.py").read_text()),
        ("next", '__version__ = "99.0"\n'),
    ):
        version.write_text(text)
        for words in (["add", "."], ["commit", "--quiet", "--message", tag], ["tag", tag]):
            subprocess.run([*git, *words], check=True)
    subprocess.run(["git", "clone", "--quiet", "--bare", source, bare], check=True)
    return folder


def deploy(folder, config, tag="ours", *parts):
    """Write what snakedeploy does into a folder, with a config and a structure of the user."""
    (folder / "workflow").mkdir(parents=True)
    (folder / "workflow" / "Snakefile").write_text(SNAKEFILE.format(tag=tag))
    for name in ("config", *parts):
        shutil.copytree(ROOT / name, folder / name)
    if config:
        (folder / "config" / "config.yaml").write_text(yaml.safe_dump(config))
    (folder / "in").mkdir()
    write(folder / "in" / "p.pdb", peptide(SEQUENCE) + "END\n")
    return folder


def run(python, folder, cache, *options, **variables):
    """Run a module of Python in a folder, without a repository of a host; return the finished process."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    environment |= {"XDG_CACHE_HOME": str(cache)} | variables
    call = [python, "-m", *options]
    return subprocess.run(call, cwd=folder, env=environment, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    """Python of an environment without the package, in which Snakemake and what the study needs are installed."""
    return environment_with(None, tmp_path_factory.mktemp("bare"))


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Python of an environment with the wheel."""
    wheel = build_wheel(ROOT, tmp_path_factory.mktemp("wheel"), HATCH_BUILD_NO_HOOKS="1")
    return environment_with(wheel, tmp_path_factory.mktemp("installed"))


def test_a_deployed_workflow_writes_the_bytes_of_a_clone(cache, tmp_path):
    """And Snakemake's report, whose captions lie in the repository."""

    def call(*options):
        return run(
            warm_python.interpreter(), folder, cache, "snakemake", *options, PYTHONPATH=str(ROOT / "src")
        )

    folder = deploy(tmp_path / "deployed", CONFIG, "ours", "profiles")
    own = call("-c2", *SURFACE)
    assert own.returncode == 0, output(own)
    shutil.copytree(folder / "in", tmp_path / "clone" / "in")
    of_clone = snakemake(tmp_path / "clone", CONFIG, *SURFACE)
    assert of_clone.returncode == 0, output(of_clone)
    for name in SURFACE:
        assert (folder / name).read_bytes() == (tmp_path / "clone" / name).read_bytes(), name
    report = call("--report", "report.html", *SURFACE)
    assert report.returncode == 0 and (folder / "report.html").is_file(), output(report)
    (folder / "in" / "p.pdb").unlink()
    lost = call("-n")
    assert lost.returncode and f"no file 'in/p.pdb' (paths start at {folder}" in output(lost)


def test_the_installed_wheel_has_the_default_study(cache, installed, tmp_path):
    """Its files lie in the package, where Snakemake and `python -m sparsurf_study run` find them."""
    folder = deploy(tmp_path / "deployed", None, "ours", "profiles")
    for command in (["snakemake", "-c2"], ["sparsurf_study", "run"]):
        planned = run(installed, folder, cache, *command, "-n")
        assert planned.returncode == 0 and "choose_frames" in planned.stdout, output(planned)
    unknown = run(installed, tmp_path, cache, "sparsurf_study", "check")
    assert unknown.returncode == 2 and unknown.stderr.startswith("There is no")


@pytest.mark.parametrize(
    ("tag", "python", "needed", "found"),
    [
        ("ours", "bare", sparsurf.__version__, "lacks sparsurf"),
        ("next", "installed", "99.0", f"has {sparsurf.__version__}"),
    ],
)
def test_a_missing_package_or_one_of_another_version_is_one_sentence(
    request, cache, tmp_path, tag, python, needed, found
):
    folder = deploy(tmp_path / "deployed", CONFIG, tag)
    done = run(request.getfixturevalue(python), folder, cache, "snakemake", "-c2")
    sentence = (
        f"These rules need sparsurf {needed} with the extra `study`, but the environment of Snakemake {found}: "
        f"run pip install 'sparsurf[study]=={needed}' there."
    )
    assert done.returncode and sentence in output(done) and "Traceback" not in output(done), output(done)
    assert not (folder / "results").exists()
