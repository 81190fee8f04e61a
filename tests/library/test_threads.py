"""Slices of work: whole, in order, whatever the threads."""

import subprocess
import sys
import time

import psutil
import pytest

from sparsurf.threads import available_cores, in_processes, parallel_map


def leave(path):
    time.sleep(0.1)
    path.touch()
    return path.name


@pytest.mark.parametrize("threads", [1, 3])
def test_slices_cover_the_range_in_order(threads):
    assert parallel_map(lambda a, b: (a, b), 10, threads, 4) == [(0, 4), (4, 8), (8, 10)]
    assert parallel_map(lambda a, b: (a, b), 8, threads, 4) == [(0, 4), (4, 8)]
    assert parallel_map(lambda a, b: (a, b), 0, threads, 4) == []
    assert available_cores() >= 1


def test_tasks_that_wait_are_cancelled_with_their_iterator(tmp_path):
    paths = [tmp_path / str(k) for k in range(12)]
    names = in_processes(leave, paths, 1, len(paths))
    assert next(names) == "0"
    names.close()
    assert len([*tmp_path.iterdir()]) <= 6
    assert [*in_processes(leave, paths, 4, 2)] == [path.name for path in paths]


def test_processes_end_when_their_parent_is_killed(tmp_path):
    """A process that waits for tasks hears nothing of the kill."""
    text = "import os, signal\nfrom sparsurf.threads import in_processes\n"
    text += "def pid(k):\n    return os.getpid()\n"
    text += "for number in in_processes(pid, range(9), 1, 1):\n    print(number, flush=True)\n"
    text += "    os.kill(os.getpid(), signal.SIGKILL)\n"
    (tmp_path / "parent.py").write_text(text)
    with (tmp_path / "printed").open("w") as stream:  # a pipe would stay open
        subprocess.run([sys.executable, tmp_path / "parent.py"], stdout=stream, check=False)
    child, deadline = int((tmp_path / "printed").read_text()), time.monotonic() + 20
    while psutil.pid_exists(child) and psutil.Process(child).status() != "zombie":
        assert time.monotonic() < deadline
        time.sleep(0.05)
