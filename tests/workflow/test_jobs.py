"""The frame of a script's work: outputs complete or not there, errors as sentences, progress in words."""

import errno
import io
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from snakemake.iocontainers import Wildcards

import collect_warnings
from measures import timing
from sparsurf import InputError
from sparsurf.workflow import job_logs, jobs, results


@pytest.fixture
def snakemake(tmp_path):
    """What Snakemake hands to the script of a rule with one output, and one of two files."""
    given = tmp_path / "in.csv"
    given.write_bytes(bytes(2_500_000))

    class Named(list):
        def items(self):
            return {"table": str(given)}.items()

    class Outputs(list):
        def items(self):
            return {"one": self[0], "both": self[1:]}.items()

    (tmp_path / "logs").mkdir()
    (tmp_path / "out").mkdir()
    return SimpleNamespace(
        rule="work",
        input=Named([str(given), str(tmp_path / "not there")]),
        output=Outputs(str(tmp_path / "out" / name) for name in ("one.csv", "two.csv", "three.csv")),
        params={"settings": {"seed": 3}},
        wildcards=Wildcards(fromdict={"protein": "p", "conformation": "c1", "file": "p.pdb"}),
        threads=2,
        log=[str(tmp_path / "logs" / "work.log")],
    )


def write(outputs):
    for path in (outputs["one"], *outputs["both"]):
        Path(path).write_text(Path(path).name)


def test_a_script_gets_what_it_asks_for_and_its_log_tells_what_it_made(snakemake, tmp_path):
    seen = {}

    def main(inputs, outputs, settings, name, threads, unknown_to_the_rule=()):
        seen.update(locals())
        write(outputs)
        print("said")

    jobs.run(main, snakemake)
    assert (seen["settings"], seen["name"], seen["threads"]) == ({"seed": 3}, "p/c1", 2)
    assert seen["inputs"] == {"table": str(tmp_path / "in.csv")} and seen["unknown_to_the_rule"] == ()
    log = Path(snakemake.log[0]).read_text().splitlines()
    assert log[0] == "said" and re.fullmatch(r"USED \d+ MB [\d.]+ s for 2\.50 MB", log[-1])
    assert [line.split(" ")[-1] for line in log if line.startswith("MADE ")] == snakemake.output
    assert job_logs.failure(snakemake.log[0]) is None


@pytest.mark.parametrize(
    ("error", "words", "traced"),
    [
        (InputError("the file is wrong."), "the file is wrong.", False),
        (
            OSError(errno.ENOSPC, "No space left", "x.csv"),
            "x.csv: No space left. Free or repair the disk",
            False,
        ),
        (OSError(errno.EIO, "bad disk"), "A defect of this program (OSError", True),
        (KeyError("k"), "A defect of this program (KeyError: 'k')", True),
    ],
)
def test_an_error_is_a_sentence(snakemake, monkeypatch, error, words, traced):
    terminal = io.StringIO()
    monkeypatch.setattr(sys, "__stderr__", terminal)

    def main():
        raise error

    with pytest.raises(SystemExit) as end:
        jobs.run(main, snakemake)
    log = Path(snakemake.log[0]).read_text()
    assert end.value.code == 1 and f"ERROR {words}" in log and words in terminal.getvalue()
    assert ("Traceback" in log) == traced and "Traceback" not in terminal.getvalue()
    assert job_logs.failure(snakemake.log[0]).startswith(words)


def test_a_damaged_input_is_no_defect_of_the_program(snakemake, tmp_path):
    jobs.run(write, snakemake)
    made = snakemake.output[0]
    Path(made).write_text("7")
    later = SimpleNamespace(**vars(snakemake))
    later.log, later.input = [str(tmp_path / "logs" / "later.log")], [made]
    later.input = type("Named", (list,), {"items": lambda self: [("table", self[0])]})([made])

    def main(inputs):
        {}[Path(inputs["table"]).read_text()]

    with pytest.raises(SystemExit):
        jobs.run(main, later)
    assert (
        job_logs.failure(later.log[0]) == f"{made} is not what the study wrote. Run again: it is regenerated."
    )


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_full_disk_under_the_log_is_a_sentence_without_a_traceback(snakemake, tmp_path):
    (tmp_path / "logs" / "full.log").symlink_to("/dev/full")
    code = (
        "import sys; from types import SimpleNamespace as S; from sparsurf.workflow import jobs\n"
        "named = type('N', (list,), {'items': lambda self: []})()\n"
        "s = S(rule='r', log=[sys.argv[1]], input=named, output=named, params={}, wildcards={}, threads=1)\n"
        "jobs.run(lambda: print('x' * 10**6), s)\n"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "logs" / "full.log")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "No space left on device. Free or repair" in done.stderr
    assert "Traceback" not in done.stderr and len(done.stderr.split("\n")) < 6


def test_progress_goes_to_the_log_every_few_seconds_and_at_the_end(monkeypatch, capsys, tmp_path):
    now = [100.0]
    monkeypatch.setattr(jobs.time, "monotonic", lambda: now[0])
    report = jobs.reporter("p/c1, part 1 of 2", "frames")
    for seconds, done in ((1.0, 1), (10.0, 5), (11.0, 6), (20.0, 20)):
        now[0] = 100 + seconds
        report(done, 20)
    said = capsys.readouterr().err
    assert said.splitlines() == [
        "PROGRESS p/c1, part 1 of 2: 5 of 20 frames, 10 s, 30 s to go",
        "PROGRESS p/c1, part 1 of 2: 20 of 20 frames, 20 s, 0 s to go",
    ]
    log = tmp_path / "x.log"
    for text, found in (
        ("", (0, 0, 0)),
        (said.split("\n")[0] + "\n", (5, 20, 30)),
        ("x\n" * 3000 + said, (20, 20, 0)),
    ):
        log.write_text(text)
        assert job_logs.progress(log) == found


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (lambda path: None, False),
        (lambda path: path.write_text("one.csv"), False),  # the same again
        (lambda path: path.write_text("One.csv"), True),
        (lambda path: path.write_text("longer"), True),
        (lambda path: path.unlink(), False),  # missing, which Snakemake sees
    ],
)
def test_a_result_that_is_not_what_a_job_wrote_is_found(snakemake, tmp_path, change, found):
    jobs.run(write, snakemake)
    path = Path(snakemake.output[0])
    change(path)
    if path.exists():
        os.utime(path, (1e9, 1e9))
    expected = [str(path)] if found else []
    assert (
        results.damaged(tmp_path / "logs")
        == results.damaged(tmp_path / "logs" / "p" / "other.log")
        == expected
    )
    assert results.damaged(tmp_path / "logs", [path.parent]) == expected
    assert results.damaged(tmp_path / "logs", snakemake.output[1:]) == []


@pytest.mark.parametrize(
    ("path", "found"),
    [
        ("p/c1/draw_view.log", ("p", "c1", "draw_view")),
        ("p/choose_frames.log", ("p", "", "choose_frames")),
        ("summarise_run.log", ("", "", "summarise_run")),
        ("pairs/one/draw_pair.log", ("pairs/one", "", "draw_pair")),
    ],
)
def test_a_log_lies_where_its_job_belongs(path, found):
    assert job_logs.place(f"results/r/logs/{path}", "results/r/logs") == found


def test_a_job_that_said_nothing_was_killed(tmp_path, monkeypatch):
    (tmp_path / "x.log").write_text("WARNING a hole\nINFO x\nWARNING a hole\n")
    assert job_logs.failure(tmp_path / "x.log") == job_logs.failure(tmp_path / "no.log") == job_logs.NO_WORD
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=0))
    assert job_logs.failure(tmp_path / "no.log") == job_logs.NO_ROOM
    assert job_logs.warnings_in(tmp_path / "x.log") == ["a hole"]


def test_processes_of_jobs_import_this_library_first(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "elsewhere")
    jobs.use_this_library()
    first, second = jobs.os.environ["PYTHONPATH"].split(jobs.os.pathsep)
    assert first.endswith("src") and second == "elsewhere"


def test_what_a_job_has_used_counts_the_processes_that_it_started(monkeypatch, tmp_path):
    (tmp_path / "in").write_bytes(bytes(2_500_000))
    spent = {
        jobs.resource.RUSAGE_SELF: SimpleNamespace(ru_maxrss=2_000_000, ru_utime=1.0, ru_stime=0.5),
        jobs.resource.RUSAGE_CHILDREN: SimpleNamespace(ru_maxrss=1_000_000, ru_utime=2.0, ru_stime=0.0),
    }
    monkeypatch.setattr(jobs.resource, "getrusage", spent.get)
    for platform, memory in (("linux", 3072), ("darwin", 3)):  # in kB and in bytes
        monkeypatch.setattr(jobs.sys, "platform", platform)
        assert jobs.used([str(tmp_path / "in")]) == f"USED {memory} MB 3.5 s for 2.50 MB"


def test_the_peak_of_memory_is_told_in_bytes():
    status = Path("/proc/self/status")
    if not status.is_file():
        pytest.skip("only Linux tells it")
    kilobytes = int(re.search(r"VmHWM:\s+(\d+) kB", status.read_text())[1])
    assert timing.peak_memory() == pytest.approx(1024 * kilobytes, rel=0.01)


def test_figures_above_what_was_promised_are_named(capsys):
    table = timing.Table()
    table.add("fast", 10, 1.0, "s", 2.0, 1.0)
    table.add("slow", 10, 1.5, "s", 1.0, 1.25)
    table.add("waits", None, None, "s", 3.0, 2.0)
    table.add("free", 10, 99.0, "s")
    assert table.missed() == ["slow", "waits"]
    assert (
        "| slow | 10 | 1.5 | 1 | s | 1.25 |" in table.markdown()
        and "| free | 10 | 99 |  | s |  |" in table.markdown()
    )
    assert capsys.readouterr().out == table.markdown()


def test_a_time_is_the_median_after_one_call_in_vain(monkeypatch):
    clock, calls = [0.0], []

    def run():
        calls.append(1)
        clock[0] += {1: 100.0, 2: 1.0, 3: 9.0, 4: 2.0}[len(calls)]

    monkeypatch.setattr(timing.time, "process_time", lambda: clock[0])
    monkeypatch.setattr(timing.time, "perf_counter", lambda: 2 * clock[0])
    assert timing.timed(run, 3) == (2.0, 4.0) and len(calls) == 4


def test_a_time_is_told_in_its_unit(monkeypatch):
    monkeypatch.setattr(timing, "timed", lambda run, repeats: (0.5, 0.75))
    table = timing.Table()
    assert table.time("a", 10, None, 3) == 0.5 and table.time("b", 10, None, 3, "ms", 1e3, 400) == 500
    assert [(row["value"], row["wall"], row["unit"], row["at_most"]) for row in table.rows] == [
        (0.5, 0.75, "s", None),
        (500, 750, "ms", 400),
    ]


def test_conformations_are_the_first_column_without_its_header(tmp_path):
    (tmp_path / "frames.csv").write_text("conformation,frame\nc1,5\nc2,9\n")
    assert jobs.conformations_of(tmp_path / "frames.csv") == ["c1", "c2"]


def test_a_wildcard_is_one_of_the_names_and_nothing_else():
    assert re.fullmatch(jobs.one_of(["a.b", "c"]), "a.b") and not re.fullmatch(jobs.one_of(["a.b"]), "axb")
    assert not re.match(jobs.one_of([]), "")


def test_warnings_of_earlier_studies_in_the_folder_do_not_count(tmp_path):
    logs, run = tmp_path / "logs", tmp_path
    others = "a/c1/compare_samplers", "a/c5/make_surface", "b/c1/make_surface", "summarise_comparison"
    own = "a/c1/make_surface", "a/c2/make_surface", "a/choose_frames", "a/simulate_nvt"
    own = [*own, "pairs/ab/match_partners", "summarise_run"]
    for log in (*own, *others):
        path = logs / f"{log}.log"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"WARNING {log}\n")
    results = [f"{run}/a/c1/surface.npz", f"{run}/a/c1/figures/enough.png", f"{run}/surfaces.csv"]
    jobs = ["make_surface", "simulate_*", "choose_frames", "summarise_run", "match_partners"]
    places = ["a", "pairs/ab", "a/c2"]  # the last failed
    collect_warnings.main({"results": results}, {"table": tmp_path / "w.csv"}, places, jobs)
    told = [line.rsplit(",", 1)[1] for line in (tmp_path / "w.csv").read_text().splitlines()[1:]]
    assert told == own and b"\r" not in (tmp_path / "w.csv").read_bytes()


def test_warnings_of_a_job_whose_results_another_has_made_since_do_not_count(tmp_path):
    """The steps of a grid's run, and all of them in one job where `sampling` was made false."""
    (tmp_path / "logs" / "a" / "c1").mkdir(parents=True)
    made = {"make_surface": ["dots"], "take_minimal": ["few", "kept"], "take_all_steps": ["dots", "few"]}
    for time, (job, paths) in enumerate(made.items(), 1):
        path = tmp_path / "logs" / "a" / "c1" / f"{job}.log"
        path.write_text(f"WARNING {job}\n" + "".join(f"MADE 1 2 x {each}\n" for each in paths))
        os.utime(path, (time, time))
    collect_warnings.main({"results": []}, {"table": tmp_path / "w.csv"}, ["a", "a/c1"], list(made))
    told = [line.rsplit(",", 1)[1] for line in (tmp_path / "w.csv").read_text().splitlines()[1:]]
    assert told == ["take_all_steps", "take_minimal"]
