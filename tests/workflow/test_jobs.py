"""The frame of a script's work: outputs complete or not there, errors as sentences, progress in words."""

import errno
import io
import re
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from snakemake.iocontainers import Wildcards

from sparsurf import InputError
from sparsurf.workflow import jobs, timing


@pytest.fixture
def snakemake(tmp_path):
    """What Snakemake hands to the script of a rule with one output, and one of two files."""
    given = tmp_path / "in.csv"
    given.write_bytes(bytes(2_500_000))

    class Named(list):
        def items(self):
            return {"table": str(given)}.items()

    one, two, three = (str(tmp_path / "out" / name) for name in ("one.csv", "two.csv", "three.csv"))
    return SimpleNamespace(
        rule="work",
        input=Named([str(given), str(tmp_path / "not there")]),
        output={"one": one, "both": [two, three]},
        params={"settings": {"seed": 3}},
        wildcards=Wildcards(fromdict={"protein": "p", "conformation": "c1", "file": "p.pdb"}),
        threads=2,
        log=[str(tmp_path / "work.log")],
    )


def test_a_script_gets_what_it_asks_for_and_its_outputs_their_names(snakemake, tmp_path):
    seen = {}

    def main(inputs, outputs, settings, name, threads, unknown_to_the_rule=()):
        seen.update(locals())
        for path in (outputs["one"], *outputs["both"]):
            assert ".part-work" in path
            with open(path, "w") as stream:
                stream.write(path.rpartition("/")[2])
        assert not (tmp_path / "out" / "one.csv").exists()
        print("said")

    jobs.run(main, snakemake)
    assert (seen["settings"], seen["name"], seen["threads"]) == ({"seed": 3}, "p/c1", 2)
    assert seen["inputs"] == {"table": str(tmp_path / "in.csv")} and seen["unknown_to_the_rule"] == ()
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["one.csv", "three.csv", "two.csv"]
    assert (tmp_path / "out" / "two.csv").read_text() == "two.csv"
    log = (tmp_path / "work.log").read_text().splitlines()
    assert log[0] == "said" and log[-1].endswith(" s for 2.50 MB") and log[-1].startswith("USED ")


def test_what_a_job_begins_to_make_anew_is_not_complete(snakemake, tmp_path):
    marks = [tmp_path / folder / jobs.COMPLETE for folder in ("p", "p/c1", ".", "other")]
    for mark in marks:
        mark.parent.mkdir(exist_ok=True, parents=True)
        mark.touch()
    snakemake.output = {"table": str(tmp_path / "p" / "c1" / "deep" / "a.csv")}

    def killed(inputs):
        assert [mark.is_file() for mark in marks] == [False, True, True, True]
        raise SystemExit(137)

    with pytest.raises(SystemExit):
        jobs.run(killed, snakemake)
    assert [mark.is_file() for mark in marks] == [False, True, True, True]


def test_two_jobs_of_a_rule_at_once_leave_each_other_alone(snakemake, tmp_path):
    other = SimpleNamespace(**vars(snakemake))
    other.output, other.log = {"one": str(tmp_path / "out" / "other.csv")}, [str(tmp_path / "other.log")]

    def write(outputs):
        for path in (outputs["one"], *outputs.get("both", [])):
            with open(path, "w") as stream:
                stream.write("whole")

    def write_while_another_begins_and_ends(outputs):
        write(outputs)
        jobs.run(write, other)

    jobs.run(write_while_another_begins_and_ends, snakemake)
    written = {path.name: path.read_text() for path in (tmp_path / "out").iterdir()}
    assert written == dict.fromkeys(["one.csv", "two.csv", "three.csv", "other.csv"], "whole")


@pytest.mark.parametrize(
    ("error", "words", "traced"),
    [
        (InputError("the file is wrong."), "the file is wrong.", False),
        (OSError(errno.ENOSPC, "No space left", "x.csv"), "x.csv: No space left; mend that", False),
        (OSError(errno.EIO, "bad disk"), "a defect of this program (OSError", True),
        (KeyError("k"), "a defect of this program (KeyError: 'k')", True),
    ],
)
def test_an_error_is_a_sentence_and_leaves_no_outputs(snakemake, tmp_path, monkeypatch, error, words, traced):
    terminal = io.StringIO()
    monkeypatch.setattr(sys, "__stderr__", terminal)

    def main(outputs):
        with open(outputs["one"], "w") as stream:
            stream.write("half")
        raise error

    with pytest.raises(SystemExit) as end:
        jobs.run(main, snakemake)
    log = (tmp_path / "work.log").read_text()
    assert end.value.code == 1 and f"ERROR {words}" in log and words in terminal.getvalue()
    assert ("Traceback" in log) == traced and "Traceback" not in terminal.getvalue()
    assert list((tmp_path / "out").iterdir()) == []


def test_progress_is_told_every_few_seconds_and_at_the_end(monkeypatch, capsys):
    terminal, now = io.StringIO(), [100.0]
    monkeypatch.setattr(sys, "__stderr__", terminal)
    monkeypatch.setattr(jobs.time, "monotonic", lambda: now[0])
    report = jobs.reporter("grid", "frames")
    for seconds, done in ((4.0, 1), (10.0, 5), (12.0, 6), (20.0, 20)):
        now[0] = 100 + seconds
        report(done, 20)
    said = ["grid: 5 of 20 frames, 10 s, 30 s to go", "grid: 20 of 20 frames, 20 s, 0 s to go"]
    assert terminal.getvalue().splitlines() == capsys.readouterr().err.splitlines() == said


def test_processes_of_jobs_import_this_library_first(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "elsewhere")
    jobs.use_this_library()
    first, second = jobs.os.environ["PYTHONPATH"].split(jobs.os.pathsep)
    assert first.endswith("scripts") and second == "elsewhere"


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
