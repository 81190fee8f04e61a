"""What a run says on the terminal: a line for each job, its warnings, why one failed, a bar for a long one."""

import logging
import time
from types import SimpleNamespace

import pytest
from snakemake_interface_logger_plugins.common import LogEvent

from sparsurf_study.workflow import job_logs, ledger, terminal
from sparsurf_study.workflow.terminal import Terminal


@pytest.fixture
def said(tmp_path, monkeypatch, capsys):
    """Function that hands events to a terminal and returns what it says."""
    monkeypatch.chdir(tmp_path)
    own = Terminal(SimpleNamespace(dryrun=False), None)

    def say(*events):
        for event, fields in events:
            record = logging.LogRecord(
                "snakemake", fields.pop("level", logging.INFO), "", 0, fields.pop("msg", ""), (), None
            )
            vars(record).update(fields, event=event)
            own.emit(record)
        return capsys.readouterr().out

    say.terminal = own
    return say


def begins(jobid, message, log, rule="compute_surface", output=()):
    known = {"jobid": jobid, "rule_name": rule, "rule_msg": message, "output": list(output)}
    return LogEvent.JOB_INFO, known | {"log": [log] if log else []}


def test_a_job_is_a_line_with_its_warnings(said, tmp_path):
    (tmp_path / "a.log").write_text("INFO x\nWARNING a hole\nWARNING a hole\nUSED 1 MB\n")
    assert said(begins(1, "Surface of p/c1", "a.log"), begins(2, "All of p is there", "")) == ""
    ends = [(LogEvent.JOB_FINISHED, {"job_id": 1}), (LogEvent.PROGRESS, {"done": 3, "total": 12})]
    assert said(*ends).splitlines() == ["   3 of 12  Surface of p/c1 (0 s)", "            Warning: a hole"]
    assert said((LogEvent.JOB_FINISHED, {"job_id": 2}), (LogEvent.PROGRESS, {"done": 4, "total": 12})) == ""


def test_why_a_result_is_made_again_is_said_when_its_job_begins(said, tmp_path, monkeypatch):
    """Once, also where the job is tried again; of the results of other studies in the folder, nothing."""
    (tmp_path / "reasons.json").write_text(
        '{"a.csv": "a.csv was changed.", "b.csv": "", "other.csv": "other."}'
    )
    monkeypatch.setenv(ledger.TO_MAKE_AGAIN, str(tmp_path / "reasons.json"))
    own = Terminal(SimpleNamespace(dryrun=False), None)
    monkeypatch.setattr(said.terminal, "emit", own.emit)
    begin = begins(1, "Surface of p/c1", "a.log", output=["a.csv", "b.csv"])
    assert said(begin) == f"{'':>10}  a.csv was changed.\n"
    assert said(begins(1, "Surface of p/c1", "a.log", output=["a.csv", "b.csv"])) == ""


def test_a_job_that_failed_is_reported_with_its_sentence_and_noted(said, tmp_path, monkeypatch):
    monkeypatch.setenv(job_logs.FAILED_JOBS, str(tmp_path / "failed"))
    (tmp_path / "a.log").write_text("ERROR x.pdb holds no atoms.\n")
    (tmp_path / "b.log").write_text("USED 1 MB\n")
    (tmp_path / "c.log").write_text("INFO begins\n")
    lost = (
        LogEvent.JOB_ERROR,
        {"jobid": 1, "rule_name": "choose_frames", "log": ["a.log"], "level": logging.ERROR},
    )
    assert "Failed  Frames of p: x.pdb holds no atoms.\n" in said(begins(1, "Frames of p", "a.log"), lost)
    group = [{"rule_name": name, "log": [f"{name}.log"]} for name in "bc"]
    text = said((LogEvent.GROUP_ERROR, {"job_error_info": group, "level": logging.ERROR}))
    assert f"Failed  c: {job_logs.NO_REASON}" in text and " b: " not in text
    assert (tmp_path / "failed").read_text().split() == ["a.log", "c.log"]


def test_a_job_that_failed_before_it_began_goes_by_the_name_of_its_rule(said, tmp_path, monkeypatch):
    """And one without a log is not noted, nor has a job failed that was stopped from outside."""
    monkeypatch.setenv(job_logs.FAILED_JOBS, str(tmp_path / "failed"))
    (tmp_path / "a.log").write_text(f"ERROR {job_logs.STOPPED}\n")
    for log, text in (
        ([], "   Failed  draw_view: see .snakemake/log\n"),
        (["a.log"], "  Stopped  draw_view\n"),
    ):
        ended = LogEvent.JOB_ERROR, {"jobid": 9, "rule_name": "draw_view", "log": log}
        assert said(ended).endswith(text)
    assert (tmp_path / "failed").read_text() == "a.log\n"
    stops = (None, {"msg": "Will exit after finishing currently running jobs."})
    assert said(stops) == "   Nothing  done. Stopping ...\n"


def test_a_plan_names_its_jobs_but_for_marks(tmp_path, capsys):
    own = Terminal(SimpleNamespace(dryrun=True), None)
    for jobid, message in ((1, "Frames of p"), (2, "")):
        record = logging.LogRecord("snakemake", logging.INFO, "", 0, "", (), None)
        vars(record).update(begins(jobid, message, "")[1], event=LogEvent.JOB_INFO)
        own.emit(record)
    own.close()
    assert capsys.readouterr().out == "Frames of p\n"


def test_a_bar_makes_way_for_a_line_and_is_gone_at_the_end(tmp_path, monkeypatch, capsys):
    """On a terminal of 30 columns; of two jobs, the one that works longer has the bar, once it has worked for some seconds."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(terminal.sys.stdout, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(terminal.shutil, "get_terminal_size", lambda: SimpleNamespace(columns=30))
    own = Terminal(SimpleNamespace(dryrun=False), None)
    now = time.monotonic()
    later, first, new = (
        SimpleNamespace(rule_msg=f"{name} of protein/c1", log=[]) for name in ("Later", "First", "New")
    )
    own._running = {3: (new, now)}
    time.sleep(1.2)
    own._running |= {1: (later, now - 20), 2: (first, now - 50)}
    time.sleep(1.2)
    with own._lock:
        own._say("a line")
    own._running = {}
    own.close()
    clear = "\r\033[K"
    bar, line, *end = capsys.readouterr().out.removeprefix(clear).split(clear)
    assert bar == f"{'':>10}  First of protein/c1, 52 s"[:29] and line == "a line\n" and not any(end)


def test_jobs_that_a_signal_stops_have_not_failed(said):
    stops = (None, {"msg": "Terminating processes on user request, this might take some time."})
    ended = LogEvent.JOB_ERROR, {"jobid": 1, "rule_name": "choose_frames", "log": ["no.log"]}
    text = said(
        (LogEvent.PROGRESS, {"done": 3, "total": 12}), begins(1, "Frames of p", "no.log"), stops, ended
    )
    assert text == "   3 of 12  done. Stopping ...\n   Stopped  Frames of p\n"


def test_what_snakemake_says_itself_goes_to_its_log_but_for_errors(said):
    wrong = {"msg": "WorkflowError: no rule", "level": logging.ERROR}
    echo = {"msg": "Exiting because a job execution failed. Look below", "level": logging.ERROR}
    full = {"msg": "Error recording metadata ([Errno 28] No space left on device)", "level": logging.ERROR}
    once, twice = (None, wrong), (None, dict(wrong))
    heard = said((None, {"msg": "Building DAG of jobs..."}), once, twice, (None, echo), (None, full))
    assert heard == "WorkflowError: no rule\n"


@pytest.mark.parametrize(
    ("log", "bar"),
    [
        (
            "PROGRESS p/c1: 5 of 20 subsets, 10 s, 31 s to go\n",
            "██████░░░░░░░░░░░░░░░░░░ Grid of p/c1, 40 s, about 31 s of this job to go",
        ),
        ("PROGRESS p/c1: 20 of 20 subsets, 39 s, 0 s to go\n", "████████████████████████ Grid of p/c1, 40 s"),
        ("INFO begins\n", "Grid of p/c1, 40 s"),
    ],
)
def test_a_long_job_has_a_bar(said, tmp_path, log, bar):
    (tmp_path / "a.log").write_text(log)
    record = SimpleNamespace(rule_msg="Grid of p/c1", log=["a.log"])
    assert said.terminal._bar_of(record, time.monotonic() - 40).strip() == bar


def test_the_first_picture_of_a_run_is_named_once(said, tmp_path):
    pages = [[f"{name}/surface.html", f"{name}/figures/roughness.png"] for name in ("a", "b")]
    for name in "ab":
        (tmp_path / f"{name}.log").write_text("USED 1 MB\n")
    jobs = [begins(k, "x", f"{'ab'[k]}.log", "mine_draw_roughness", pages[k]) for k in range(2)]
    lines = said(
        *jobs,
        *[(LogEvent.JOB_FINISHED, {"job_id": k}) for k in range(2)],
        (LogEvent.PROGRESS, {"done": 2, "total": 9}),
    ).splitlines()
    assert lines == [
        "    2 of 9  x (0 s)",
        "First picture  a/figures/roughness.png",
        "First view     a/surface.html",
        "    2 of 9  x (0 s)",
    ]


def test_a_run_without_a_terminal_says_how_far_the_longest_job_is(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(terminal, "SECONDS_BETWEEN_LINES", 0.05)
    monkeypatch.setattr(terminal, "SECONDS_BEFORE_BAR", -1)
    (tmp_path / "a.log").write_text("PROGRESS p/c1: 5 of 20 subsets, 10 s, 31 s to go\n")
    own = Terminal(SimpleNamespace(dryrun=False), None)
    record = logging.LogRecord("snakemake", logging.INFO, "", 0, "", (), None)
    vars(record).update(begins(1, "Grid of p/c1", "a.log")[1], event=LogEvent.JOB_INFO)
    own.emit(record)
    own._running[2] = (SimpleNamespace(rule_msg="Later", log=[]), time.monotonic())
    time.sleep(0.3)
    own.close()
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) > 1 and {line.strip() for line in lines} == {
        "Grid of p/c1, 5 of 20, 0 s, about 31 s of this job to go"
    }
