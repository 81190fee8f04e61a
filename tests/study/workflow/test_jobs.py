"""The frame of a job: its log, errors as sentences, progress in words; what is read from logs."""

import errno
import io
import os
import re
import resource
import signal
import sys
import tempfile
import warnings
from pathlib import Path
from types import SimpleNamespace

import pytest

from conftest import ROOT
from small_study import run_script
from sparsurf.errors import InputError
from sparsurf_study.config.conformations import require_excluded
from sparsurf_study.workflow import job_logs, jobs


@pytest.fixture
def snakemake(tmp_path):
    """What Snakemake hands to a script, as far as the frame of a job uses it."""
    return SimpleNamespace(rule="work", log=[str(tmp_path / "work.log")])


def failure(log):
    """The reason of a failed job, as its log has it; None where it finished."""
    return dict(job_logs.failures_since(0.0, Path(log).parent)).get(Path(log))


def test_the_log_of_a_job_has_what_it_prints_logs_and_uses(snakemake):
    with jobs.job(snakemake):
        print("printed")
        jobs.logging.getLogger("sparsurf").warning("a hole")
        jobs.logging.getLogger("sparsurf").info("a step")
        warnings.warn("a division", stacklevel=1)
    log = Path(snakemake.log[0]).read_text().splitlines()
    assert log[:3] == ["printed", "WARNING a hole", "INFO a step"]
    assert any("a division" in line for line in log[3:])
    megabytes, seconds = map(float, re.fullmatch(r"USED (\d+) MB ([\d.]+) s", log[-1]).groups())
    usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    kilobytes = 1 / 1024 if sys.platform == "darwin" else 1
    assert megabytes == pytest.approx(sum(u.ru_maxrss for u in usages) * kilobytes * 1.024e-3, rel=0.02)
    assert seconds == pytest.approx(sum(u.ru_utime + u.ru_stime for u in usages), rel=0.1)
    assert failure(snakemake.log[0]) is None
    assert job_logs.warnings_in(snakemake.log[0])[0] == "a hole"


@pytest.mark.parametrize(
    ("error", "words", "traced"),
    [
        (InputError("the file is wrong."), "the file is wrong.", False),
        (
            OSError(errno.ENOSPC, "words of a library", "x.csv"),
            "x.csv: No space left on device. Free or repair the disk",
            False,
        ),
        (OSError(errno.EIO, "bad disk"), "A defect of this program (OSError", True),
        (KeyError("k"), "A defect of this program (KeyError: 'k')", True),
    ],
)
def test_an_error_is_a_sentence(snakemake, monkeypatch, error, words, traced):
    terminal = io.StringIO()
    monkeypatch.setattr(sys, "__stderr__", terminal)

    with pytest.raises(SystemExit) as end, jobs.job(snakemake):
        raise error
    log = Path(snakemake.log[0]).read_text()
    assert end.value.code == 1 and f"ERROR {words}" in log and words in terminal.getvalue()
    assert ("Traceback" in log) == traced and "Traceback" not in terminal.getvalue()
    assert failure(snakemake.log[0]).startswith(words)


def of_numba():
    raise SystemError("returned a result with an exception set") from KeyboardInterrupt()


@pytest.mark.parametrize("stop", [lambda: os.kill(os.getpid(), signal.SIGTERM), of_numba])
def test_a_job_that_is_stopped_leaves_no_folder_and_says_so(snakemake, tmp_path, stop):
    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(SystemExit), jobs.job(snakemake), tempfile.TemporaryDirectory(dir=tmp_path):
        stop()
    signal.signal(signal.SIGTERM, before)
    assert failure(snakemake.log[0]) == job_logs.STOPPED
    assert {path.name for path in tmp_path.iterdir()} == {"work.log", ".jobs"}


@pytest.mark.parametrize("job", ["summarise_surfaces", "summarise_best", "summarise_comparison"])
def test_a_summary_of_conformations_that_are_all_excluded_is_refused(tmp_path, job):
    """As is known only when their frames are chosen."""
    inputs = {"surfaces": [], "tables": []}
    with pytest.raises(InputError, match="exclude leaves"):
        run_script(job, tmp_path, inputs, {"table": "t.csv"}, {"sampled": [], "exclude": []})


def test_an_excluded_conformation_that_does_not_exist_is_named_once_frames_are_chosen(tmp_path):
    (tmp_path / "p").mkdir()
    (tmp_path / "p" / "frames.csv").write_text("conformation,frame\nc1,7\nf012,12\n")
    require_excluded(["p", "p/*", "p/c01", "p/f12", "q/c9", "pairs/c9"], tmp_path)
    with pytest.raises(InputError, match=r"^exclude: there is no 'p/c3'; p has c1, f012\.$"):
        require_excluded(["p/c1", "p/c3"], tmp_path)


def test_progress_goes_to_the_log_every_few_seconds_and_at_the_end(monkeypatch, capsys):
    now = [100.0]
    monkeypatch.setattr(jobs.time, "monotonic", lambda: now[0])
    report = jobs.reporter("p/c1, part 1 of 2", "frames")
    for seconds, done in ((1.0, 1), (10.0, 5), (11.0, 6), (12.0, 10), (13.0, 20)):
        now[0] = 100 + seconds
        report(done, 20)
    assert capsys.readouterr().err.splitlines() == [
        "PROGRESS p/c1, part 1 of 2: 5 of 20 frames, 10 s",
        "PROGRESS p/c1, part 1 of 2: 10 of 20 frames, 12 s",
        "PROGRESS p/c1, part 1 of 2: 20 of 20 frames, 13 s",
    ]


def test_a_job_that_said_nothing_was_killed(tmp_path):
    (tmp_path / "x.log").write_bytes(b"WARNING a hole\nINFO x\nWARNING a hole\n\xff of another program\n")
    assert failure(tmp_path / "x.log") == job_logs.NO_REASON
    assert job_logs.warnings_in(tmp_path / "x.log") == ["a hole"]


def test_jobs_of_a_clone_import_its_packages_before_others(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "of/the/user")
    jobs.let_jobs_import_packages(is_clone=False)
    assert os.environ["PYTHONPATH"] == "of/the/user"
    jobs.let_jobs_import_packages(is_clone=True)
    assert os.environ["PYTHONPATH"].split(os.pathsep) == [str(ROOT / "src"), "of/the/user"]
    monkeypatch.delenv("PYTHONPATH")
    jobs.let_jobs_import_packages(is_clone=True)
    assert os.environ["PYTHONPATH"] == str(ROOT / "src")


def test_a_heading_of_gromacs_is_no_warning(tmp_path):
    (tmp_path / "x.log").write_text(
        "WARNING 1 [file topol.top, line 2315]:\n  a charge\nWARNING the box is small\n"
    )
    assert job_logs.warnings_in(tmp_path / "x.log") == ["the box is small"]


def test_warnings_of_earlier_studies_in_the_folder_do_not_count(tmp_path, monkeypatch):
    """Those of jobs and of places that this study does not have; a sentence counts once for each conformation."""
    others = "a/c1/compare_samplers", "a/c5/compute_surface", "b/c1/compute_surface", "summarise_comparison"
    counted = "a/c1/compute_surface", "a/choose_frames", "a/simulate_nvt", "pairs/ab/match_partners"
    counted = [*counted, "summarise_best"]
    run = Path("results", "r")
    monkeypatch.chdir(tmp_path)
    for log in (*counted, *others):
        path = run / "logs" / f"{log}.log"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"WARNING {log}\n")
    for folder in ("a/c1", "a/c2"):
        (run / "logs" / folder).mkdir(exist_ok=True)
        (run / "logs" / folder / "measure_floors.log").write_text("WARNING a/c1/compute_surface\n")
    files = (
        "a/c1/surface.npz",
        "a/c2/surface.npz",
        "a/c1/figures/required_dots.png",
        "surfaces.csv",
        "pairs/ab/contacts.csv",
    )
    names = (
        "compute_surface",
        "measure_floors",
        "simulate_",
        "choose_frames",
        "summarise_best",
        "match_partners",
    )
    rows = job_logs.collected_warnings([f"{run}/{file}" for file in files], f"{run}/logs", names)
    places = {
        "summarise_best": ("", ""),
        "a/c1/compute_surface": ("a", "c1"),
        "pairs/ab/match_partners": ("pairs/ab", ""),
    }
    wanted = [(*places.get(log, ("a", "")), log.rpartition("/")[2], log) for log in counted]
    assert rows == [wanted[0], ("a", "c2", "measure_floors", wanted[0][3]), *wanted[1:]]
