"""A sound run breaks no invariant; a number that is changed in one file breaks that of the file."""

import numpy as np
import pandas as pd
import pytest

from small_study import copy_of
from sparsurf_study import manifest
from sparsurf_study.report.closing import close_run
from sparsurf_study.report.invariants import broken_batches, broken_invariants, numbers_missing_on_page

PLACE = "still/f0"


def files_of(run):
    """Paths of all files of a run below its folder."""
    return sorted(path.relative_to(run).as_posix() for path in run.rglob("*") if path.is_file())


@pytest.fixture
def run(study, tmp_path):
    """Results of the small study, whose files may be replaced."""
    return copy_of(study, tmp_path / "own") / "results" / "small"


def change(path, edit):
    """Replace a table by an edited one."""
    table = edit(pd.read_csv(path))
    path.unlink()  # a link to that of the study
    table.to_csv(path, index=False)


def test_the_small_study_breaks_no_invariant(study):
    run = study / "results" / "small"
    assert broken_invariants(run, files_of(run)) == [] == numbers_missing_on_page(run, files_of(run))
    assert len(pd.read_csv(run / "checks.csv")) == 0


@pytest.mark.parametrize(
    ("file", "edit", "words"),
    [
        ("minimal.csv", lambda t: t.assign(weight=t.weight + (t.index == 3)), "weights sum"),
        ("minimal.csv", lambda t: t.assign(dot=t["dot"].where(t.index != 1, t["dot"][0])), "not different numbers"),
        ("components.csv", lambda t: t.assign(area=2 * t.area), "areas sum"),
        ("residues.csv", lambda t: t.assign(kept=t.kept + (t.index == 0)), "column kept sums"),
        ("residues.csv", lambda t: t.assign(dots=t.dots - (t.index == 2)), "column dots sums"),
        ("grid.csv", lambda t: t.assign(d_kept=t.d_kept + 0.01 * (t.index == 5)),
         "d_kept is not Z_tR - Z_tS in 1 rows, first in row 5."),
        ("grid.csv", lambda t: t.assign(Z_tS_full=t.Z_tS_full.where(t.index != 3, -0.1)),
         "row 3."),
        ("grid.csv", lambda t: t.assign(n_S=t.n_S * np.where(t.index == 2, 2, 1)), "in closed form"),
        ("ranges.csv", lambda t: t.assign(n_S_percent=t.n_S_percent + 30), "outside of its range"),
        ("ranges.csv", lambda t: t.assign(beta=0.4 - t.beta), "largest d"),
        ("floors.csv", lambda t: t.assign(Z=t.high + 1), "outside of its interval"),
        ("recovered.csv", lambda t: t.assign(mean=t.largest + 1), "are not in this order"),
    ],
)  # fmt: skip
def test_a_changed_number_is_named_with_its_file(run, file, edit, words):
    change(run / PLACE / file, edit)
    broken = broken_invariants(run, files_of(run))
    assert {name for name, _ in broken} >= {f"{PLACE}/{file}"}
    assert any(words in sentence for name, sentence in broken if name == f"{PLACE}/{file}"), broken


def test_the_number_of_dots_of_every_surface_is_checked(run):
    change(run / "surfaces.csv", lambda t: t.assign(N=t.N + (t.index == 1)))
    ((file, sentence),) = broken_invariants(run, files_of(run))
    assert file == "surfaces.csv" and "N of " in sentence


def test_a_contradiction_is_on_the_first_page_and_in_the_list(run):
    """Also a number that the page does not have, as the page was written before."""
    change(run / PLACE / "minimal.csv", lambda t: t.assign(weight=t.weight + (t.index == 0)))
    outputs = {key: str(run / f"{key}.csv") for key in ("failures", "warnings", "checks")}
    names = {"page": "index.html", "crate": "ro-crate-metadata.json", "sums": "SHA256SUMS"}
    outputs |= {key: str(run / name) for key, name in names.items()}
    results = [
        str(run / file) for file in files_of(run) if "/logs/" not in file and file not in outputs.values()
    ]
    for path in outputs.values():
        (run / path).unlink()
    close_run(run, results, [], {}, outputs)
    checks = pd.read_csv(run / "checks.csv")
    assert checks["file"].to_list() == [f"{PLACE}/minimal.csv"]
    assert manifest.read_sums(run).keys() >= {"index.html", "checks.csv"} and not [*manifest.differing(run)]
    page = (run / "index.html").read_text(encoding="utf-8")
    assert "run contradict" in page and checks["sentence"][0] in page
    change(run / PLACE / "ranges.csv", lambda t: t.assign(d_cv=t.d_cv + 1))
    missing = numbers_missing_on_page(run, [f"{PLACE}/ranges.csv"])
    assert missing and all(name == "index.html" and f"{PLACE}/ranges.csv" in words for name, words in missing)


def test_residues_of_a_batch_hold_the_dots_of_their_surface(tmp_path):
    pytest.importorskip("pyarrow")
    for name in ("surfaces", "residues"):
        (tmp_path / name).mkdir()
    pd.DataFrame({"protein": ["a", "b"], "N": [5, 7]}).to_parquet(tmp_path / "surfaces" / "0001.parquet")
    residues = pd.DataFrame({"protein": ["a", "a", "b"], "dots": [2, 3, 7], "weight": [2, 3, 7]})
    residues.to_parquet(tmp_path / "residues" / "0001.parquet")
    assert broken_batches(tmp_path) == []
    residues.assign(weight=[2, 3, 6]).to_parquet(tmp_path / "residues" / "0001.parquet")
    ((file, sentence),) = broken_batches(tmp_path)
    assert file == "residues/0001.parquet" and sentence.startswith("weight of the")
