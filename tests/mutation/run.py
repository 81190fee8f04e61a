"""Plants the mistakes of mistakes.toml one by one and counts those that a test notices.

By hand: `python tests/mutation/run.py [words]`; with words, only mistakes in files whose path holds one of them. The
checkout stays as it is: mistakes are planted in a copy. `--check` only tells which mistakes have no place any more.
"""

import multiprocessing
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

FOLDER = Path(tempfile.gettempdir(), f"mutation-{os.getuid()}")  # kept
sys.dont_write_bytecode = True
os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
os.environ.setdefault("SPARSURF_SHARED", str(Path(__file__).resolve().parents[3] / "shared"))
os.environ["NUMBA_CACHE_DIR"] = str(FOLDER / ".cache" / "numba" / "sources-mutation")  # numba reads it once

for heavy in ("matplotlib.pyplot", "mdtraj", "numba", "pandas", "scipy.stats", "hypothesis"):
    __import__(heavy)  # once for all tests
import pytest  # noqa: E402
from mistakes import ROOT, SCRIPTS, mistakes, without_place  # noqa: E402

PATIENCE = 600  # s for the tests of one mistake; one that hangs is noticed
# One folder of kernels for all mistakes: only those that hold something of a file that changed are compiled anew.
SHARED_KERNELS = ("hashlib.sha256(kernel_sources()).hexdigest()[:16]", '"mutation"')


def copy_to(folder):
    """A copy of the checkout's files, whose kernels lie in one folder and stay there from one call to the next."""
    for name in ("scripts", "tests"):
        shutil.rmtree(folder / name, ignore_errors=True)
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, check=True, capture_output=True, text=True
    )
    for name in listed.stdout.splitlines():
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    plant(folder / SCRIPTS / "sparsurf" / "kernel_cache.py", *SHARED_KERNELS)


def plant(path, old, new):
    """Replace the only place of a text in a file; returns what it held before."""
    before = path.read_text("utf-8")
    assert before.count(old) == 1, f"{path}: {old!r} stands there {before.count(old)} times"
    path.write_text(before.replace(old, new), "utf-8")
    return before


def forget_kernels(folder, file):
    """Have kernels compiled anew that may hold something of a file: those that import it, in however many steps.

    numba looks at what stands in a kernel's own file only.
    """
    library = folder / SCRIPTS
    texts = {path: path.read_text("utf-8") for path in (library / "sparsurf").rglob("*.py")}
    imported = {}
    for path, text in texts.items():
        lines = re.findall(r"^from (sparsurf[\w.]*) import (\([^)]*|.*)", text, re.M)
        names = {f"{module}.{word}" for module, words in lines for word in re.findall(r"\w+", words)}
        imported[path] = names | {module for module, _ in lines}
    stale, before = {library / file}, set()
    while stale != before:
        names = {".".join(path.relative_to(library).with_suffix("").parts) for path in stale}
        before, stale = stale, stale | {path for path in texts if imported[path] & names}
    for path in stale:
        if "njit" in texts.get(path, ""):
            for kernel in Path(os.environ["NUMBA_CACHE_DIR"]).glob(f"*/{path.stem}.*"):
                kernel.unlink()


def passes(folder, tests):
    """Whether tests pass in a copy: run in a fork of this process, which has the heavy libraries loaded."""
    child = multiprocessing.get_context("fork").Process(target=run_pytest, args=(folder, tests))
    child.start()
    child.join(PATIENCE)
    if child.is_alive():
        child.kill()
        child.join()
    return child.exitcode == 0


def run_pytest(folder, tests):
    """Run pytest silently in a copy and end this process with its exit code."""
    os.chdir(folder / "tests")
    for stream in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
    os._exit(pytest.main(["-q", "-x", "-p", "no:cacheprovider", *shlex.split(tests)]))


def main(*words):
    """Print each mistake that nobody notices, then the rate of every package; returns the exit code."""
    stale = list(without_place())
    if stale or words == ("--check",):
        print("\n".join(stale) or "Every mistake has its place.")
        return len(stale) > 0
    chosen = [each for each in mistakes() if not words or any(word in each[0] for word in words)]
    if not chosen:
        sys.exit(f"No file with a mistake has {' or '.join(words)} in its path.")
    planted, noticed = Counter(), Counter()
    with tempfile.TemporaryDirectory(prefix="mutation-") as name:
        folder = Path(name)
        copy_to(folder)
        for tests in dict.fromkeys(each[3] for each in chosen):
            assert passes(folder, tests), (
                f"{tests}: these fail, skip or do not exist before a mistake is planted"
            )
        for file, old, new, tests in chosen:
            path = folder / SCRIPTS / file
            before = plant(path, old, new)
            forget_kernels(folder, file)
            missed = passes(folder, tests)
            path.write_text(before, "utf-8")
            forget_kernels(folder, file)
            planted[file] += 1
            noticed[file] += not missed
            print(f"{'NOT NOTICED' if missed else 'noticed'}  {file}: {old!r} -> {new!r}", flush=True)
    for file in planted:
        print(f"{file:45s} {noticed[file]:3d} of {planted[file]:3d}")
    total, found = sum(planted.values()), sum(noticed.values())
    print(f"all: {found} of {total} ({100 * found / total:.0f} %)")
    return found < total


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
