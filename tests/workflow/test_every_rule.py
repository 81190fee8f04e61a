"""Every rule, run for real once: a section of the settings that a script lacks stops its job. What rules read and go by
is in test_rules.py; simulations are planned only.
"""

import os

import everything
import pandas as pd
import pytest

from small_study import output, snakemake

pytestmark = pytest.mark.skipif(
    "SPARSURF_EVERY_RULE" not in os.environ, reason="takes 6 CPU minutes: set SPARSURF_EVERY_RULE=1"
)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Folder and config of the finished study."""
    folder = tmp_path_factory.mktemp("everything") / "study"
    config, process = everything.run(folder)
    assert process.returncode == 0, output(process)
    return folder, config


def test_each_part_of_an_ensemble_follows_its_own_frames(study):
    table = pd.read_csv(study[0] / "results/all/moving/ensemble.csv")
    assert table["frame"].to_list() == [0, 1] and table["n_S"].nunique() > 1


def test_the_comparison_over_all_is_of_every_surface(study):
    run = study[0] / "results" / "all"
    own = [pd.read_csv(path) for path in sorted(run.glob("*/*/compare.csv"))]
    assert len(own) == 4
    assert len(pd.read_csv(run / "surfaces.csv")) == 4 and len(pd.read_csv(run / "summary.csv")) == 4 * 2 * 2


def test_warnings_of_all_jobs_are_in_one_table(study):
    table = pd.read_csv(study[0] / "results/all/warnings.csv")
    assert table.columns.to_list() == ["protein", "conformation", "job", "sentence"]
    told = table[table["job"] == "choose_frames"]
    assert {*told["protein"]} == {"moving", "got"} and told["sentence"].str.contains("lack heavy atoms").all()


def test_a_finished_study_has_nothing_to_do_until_a_file_is_replaced(study):
    """By one of another content and an older date, as `cp -p` does."""
    folder, config = study
    again = snakemake(folder, config, "--dry-run")
    assert "Nothing to be done" in output(again), output(again)
    for name in ("moving.pdb", "one.pdb"):
        path, when = folder / name, (folder / name).stat().st_mtime
        path.write_text("REMARK another\n" + path.read_text())
        os.utime(path, (when, when))
    config["proteins"]["got"]["sha256"] = "0" * 64
    reasons = output(snakemake(folder, config, "--dry-run")).split(
        "params have changed since last execution:"
    )[1]
    assert {"choose_frames", "make_partners", "fetch_structure"} <= {
        *reasons.split("\n")[1].replace(",", " ").split()
    }
