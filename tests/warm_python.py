"""A Python that has imported the library, numba's kernels and Snakemake already: each process is a fork of it.

`interpreter()` returns the path of a command that takes the arguments of Python. Snakemake runs the script of a rule with
`sys.executable`; where that is this command, the script starts within milliseconds. What is neither a script, `-m snakemake`,
`-m sparsurf_study` nor `-m sparsurf_study.debug` is handed to the usual Python.
"""

import atexit
import functools
import gc
import importlib
import json
import os
import pkgutil
import runpy
import select
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from contextlib import suppress
from pathlib import Path

IMPORTED_BY_SNAKEMAKE = (
    "snakemake.cli", "snakemake.script", "snakemake.notebook", "requests", "sparsurf_study.config.check",
    "sparsurf_study.workflow.jobs", "sparsurf.dot_fields.columns", "sparsurf.molecules.read_molecule", "nbformat", "smart_open",
)  # fmt: skip
# Folder in the working folder of a script: where it is, a file lists what the script opened
OPENED = ".opened"
COMPILED = "compiled"  # what such a file says of a kernel that the script compiled
CLIENT = """
import json, os, socket, sys
python, address, *arguments = sys.argv[1:]
warm = "snakemake", "sparsurf_study", "sparsurf_study.debug"
if arguments[:1] == ["-m"] and arguments[1] not in warm or arguments[:1] == ["-c"]:
    os.execv(python, [python, *arguments])
server = socket.socket(socket.AF_UNIX)
server.connect(address)
message = json.dumps([arguments, os.getcwd(), dict(os.environ)]).encode()
socket.send_fds(server, [len(message).to_bytes(8, "big")], [0, 1, 2])
server.sendall(message)
code = (server.recv(1) or b"\\1")[0]
if code > 192:  # it was killed
    os.kill(os.getpid(), 256 - code)
sys.exit(code)
"""


@functools.cache
def interpreter():
    """Start the warm Python of this process, once; return the command that runs others as its forks."""
    folder = Path(tempfile.mkdtemp(prefix="warm-"))
    (folder / "client.py").write_text(CLIENT)
    command, address = folder / "python", folder / "socket"
    quoted = f'"{sys.executable}" -IS "{folder}/client.py" "{sys.executable}" "{address}"'
    command.write_text(f'#!/bin/sh\nexec {quoted} "$@"\n')
    command.chmod(0o755)
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    server = subprocess.Popen(
        [sys.executable, __file__, command, address],
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        start_new_session=True,
    )
    atexit.register(_stop, server, os.getpid(), folder)
    assert server.stdout.readline() == b"ready\n"
    return str(command)


def _stop(server, owner, folder):
    """End the warm Python and all its forks, where this is the process that started it."""
    if os.getpid() == owner:
        server.stdin.close()
        server.wait()
        shutil.rmtree(folder)


def _reap(*_):
    """Wait for the forks that have ended, so that their time counts as that of the tests."""
    with suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass


@functools.cache
def import_snakemake():
    """Import what each start of Snakemake does: its plugins, and what checks a config."""
    for name in IMPORTED_BY_SNAKEMAKE:
        importlib.import_module(name)
    sys.modules["snakemake.cli"].get_argument_parser()


def serve(command, address):
    """Import what jobs need, then fork for each call; return in the fork that is to run it."""
    import sparsurf
    import sparsurf_study
    from sparsurf import compile_kernels

    for package in (sparsurf, sparsurf_study):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not module.name.endswith("__main__"):
                importlib.import_module(module.name)
    import_snakemake()
    for part in compile_kernels.PARTS.values():
        part()
    importlib.import_module("sparsurf_study.compile_kernels").compile_study()
    gc.freeze()  # no fork searches what it shares with the others, which would copy it
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(address)
    listener.listen(64)
    os.write(1, b"ready\n")
    signal.signal(signal.SIGCHLD, _reap)
    while True:
        if (
            sys.stdin in select.select([listener, sys.stdin], [], [])[0]
        ):  # the tests have ended, or were killed
            os.killpg(0, signal.SIGKILL)
        connection, _ = listener.accept()
        if not os.fork():
            break
        connection.close()
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    listener.close()
    size, streams, _, _ = socket.recv_fds(connection, 8, 3)
    with connection.makefile("rb") as stream:
        arguments, folder, variables = json.loads(stream.read(int.from_bytes(size, "big")))
    if job := os.fork():
        code = os.waitstatus_to_exitcode(os.waitpid(job, 0)[1])
        connection.sendall(bytes([code % 256]))
        os._exit(0)
    connection.close()
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    for number, name in ((1, "stdout"), (2, "stderr")):  # the former may be of another kind, a file or a pipe
        stream = open(number, "w", buffering=1, closefd=False)  # noqa: SIM115
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(variables)
    sys.executable = command
    return arguments


def note_opened_files(folder):
    """Write the files that this process opens below its working folder into one file of a folder, if that is there."""
    if os.path.isdir(folder):
        name = f"{os.getpid()}-{time.monotonic_ns()}.tsv"
        notes = open(os.path.join(folder, name), "x", buffering=1, encoding="utf-8")  # noqa: SIM115
        here = os.getcwd() + os.sep

        def note(event, arguments):
            if event == "open" and isinstance(arguments[0], str):
                path, mode, flags = os.path.abspath(arguments[0]), arguments[1], arguments[2]
                if path.startswith(here):
                    writes = flags & (os.O_WRONLY | os.O_RDWR) or (mode and not {*"wax+"}.isdisjoint(mode))
                    notes.write(f"{'w' if writes else 'r'}\t{path.removeprefix(here)}\n")

            elif event == "os.rename" and str(arguments[1]).endswith(
                ".nbc"
            ):  # of numba, once it has compiled a kernel
                notes.write(f"{COMPILED}\t{os.path.basename(arguments[1])}\n")

        sys.addaudithook(note)


def run(arguments):
    """Run a script or Snakemake as the main program; return the exit code."""
    sys.argv[:] = arguments
    if sys.argv[0] != "-m":
        note_opened_files(OPENED)
    for folder in os.environ.get("PYTHONPATH", "").split(os.pathsep):  # as a new Python does
        if os.path.isfile(own := os.path.join(folder, "sitecustomize.py")):
            runpy.run_path(own)
    try:
        if sys.argv[0] == "-m":
            del sys.argv[0]
            sys.path[0] = os.getcwd()
            if not hasattr(sys.modules.get(sys.argv[0]), "__path__"):
                sys.modules.pop(sys.argv[0], None)  # a module that was imported already would be warned of
            runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
        else:
            sys.path[0] = os.path.dirname(os.path.abspath(sys.argv[0]))
            runpy.run_path(sys.argv[0], run_name="__main__")
    except SystemExit as end:
        if end.code is None or isinstance(end.code, int):
            return end.code or 0
        print(end.code, file=sys.stderr)
        return 1
    except BaseException:
        traceback.print_exc()
        return 1
    return 0


if __name__ == "__main__":
    code = run(serve(*sys.argv[1:]))
    threading._shutdown()
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code % 256)  # without taking apart what was imported, which would copy it
