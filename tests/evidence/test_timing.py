"""The measure of the benchmark: memory, processor time, and the table of what was promised."""

import re
from pathlib import Path

import pytest

from measures import timing


def test_the_peak_of_memory_is_reported_in_bytes():
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


def test_a_time_is_reported_in_its_unit(monkeypatch):
    monkeypatch.setattr(timing, "timed", lambda run, repeats: (0.5, 0.75))
    table = timing.Table()
    assert table.time("a", 10, None, 3) == 0.5 and table.time("b", 10, None, 3, "ms", 1e3, 400) == 500
    assert [(row["value"], row["wall"], row["unit"], row["at_most"]) for row in table.rows] == [
        (0.5, 0.75, "s", None),
        (500, 750, "ms", 400),
    ]
