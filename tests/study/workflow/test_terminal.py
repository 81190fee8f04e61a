"""What a run says: a line for each job, its warnings, why one failed, the first picture, and a bar for a long job."""

import fcntl
import os
import pty
import re
import struct
import subprocess
import sys
import termios

import pytest

from conftest import ROOT

SNAKEFILE = r"""
rule all:
    input: "mark", "picture.html", "grid", "structure"

rule mark:
    output: touch("mark")

rule other_draw_roughness:
    output: "picture.html"
    log: "picture.log"
    message: "First picture of p/c1"
    shell: r"printf 'Compiling kernels (once, about half a minute)\nWARNING a hole\n' > {log}; sleep 2.5; touch {output}"

rule grid:
    output: "grid"
    log: "grid.log"
    message: "Grid of a protein with a name so long that no terminal of eighty columns has place for it"
    shell: r"printf 'PROGRESS p/c1: 5 of 20 subsets, 10 s\n' > {log}; sleep 13; touch {output}"

rule choose_frames:
    output: "structure"
    log: "structure.log"
    message: "Choosing the conformations of q"
    shell: r"printf 'ERROR q.pdb has no atoms.\n' > {log}; exit 1"
"""
COMMAND = [sys.executable, "-m", "snakemake", "--cores", "3", "--keep-going", "--logger", "sparsurf"]


@pytest.fixture
def options(tmp_path):
    """A folder with a workflow, and the environment that finds the plugin."""
    (tmp_path / "Snakefile").write_text(SNAKEFILE)
    return {"cwd": tmp_path, "env": os.environ | {"PYTHONPATH": str(ROOT / "src")}}


def test_a_terminal_of_eighty_columns_shows_a_line_for_each_job_and_a_bar(options):
    terminal, inside = pty.openpty()
    fcntl.ioctl(inside, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    process = subprocess.Popen(COMMAND, stdout=inside, stderr=subprocess.DEVNULL, **options)
    os.close(inside)
    parts = []
    while True:
        try:
            parts.append(os.read(terminal, 4096))
        except OSError:  # all is closed
            break
    os.close(terminal)
    assert process.wait() == 1
    text = b"".join(parts).decode()
    bars = [bar for bar in re.findall(r"[^\r\n]*░[^\r\n]*", text)]
    assert bars and all(len(bar.split("\033[K")[-1]) <= 79 for bar in bars)
    assert "█" * 6 + "░" * 18 in bars[0] and "Grid of a protein" in bars[0]
    left = re.sub(r"[^\n]*\r\033\[K", "", text.replace("\r\n", "\n"))
    assert "░" not in left  # each bar has made way
    lines = left.splitlines()
    assert f"{'':>10}  Compiling kernels (once, about half a minute)" in lines
    assert f"{'Failed':>10}  Choosing the conformations of q: q.pdb has no atoms." in lines
    picture = next(
        k for k, line in enumerate(lines) if re.match(r" +\d of 5  First picture of p/c1 \(\d+ s\)", line)
    )
    assert lines[picture + 1 : picture + 3] == [f"{'':>10}  Warning: a hole", "First picture  picture.html"]
    assert len(lines) == 6 and lines[-1].startswith("  ")


def test_a_plan_is_snakemakes_own(options):
    process = subprocess.run([*COMMAND, "-n"], capture_output=True, text=True, check=True, **options)
    assert "This was a dry-run" in process.stdout and "other_draw_roughness" in process.stdout


def test_a_disk_that_cannot_be_written_is_told_in_one_sentence(options, tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    (disk / "mark").touch()
    (tmp_path / "Snakefile").write_text('rule mark:\n    output: "disk/mark"\n    shell: "touch {output}"\n')
    call = [*COMMAND, "--forceall"]
    if os.geteuid():
        (disk / "mark").chmod(0o400)
    else:  # who may write all but a disk that is mounted read-only
        call = ["unshare", "--mount", "sh", "-c", 'mount --bind -o ro disk disk && exec "$@"', "sh", *call]
        if subprocess.run([*call[:6], "true"], **options, capture_output=True).returncode:
            pytest.skip("no disk can be mounted here")
    run = subprocess.run(call, capture_output=True, text=True, **options)
    assert run.returncode == 1
    assert run.stdout == "disk/mark cannot be written. Make it and its folder writable and run again.\n"
