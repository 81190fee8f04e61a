"""Plant mistakes one at a time and count those that the tests notice: `make planted` (not part of `make test`).

    python tests/planted/run.py [--number 150] [--seed 1] [--only surfaces] [--table planted.csv] [--everywhere]

Mistakes are drawn from every package, script, rule and the viewer, by the seed. Each is planted in a copy of the checkout
and met by the tests of its package; with `--everywhere`, where these do not notice it, by those of the packages that import its
file, one after the other. The tests must pass before a mistake is planted, and none of its own package may skip. Prints each
mistake that nobody notices and the rate of every part.
"""

import argparse
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pandas as pd
from operators import mistakes

ROOT = Path(__file__).resolve().parents[2]
LIBRARY = Path("src", "sparsurf")
LEAST = {"rules": 20, "viewer": 6}  # mistakes of a part; of the others 4
OF_RULES = (
    ("rules", "needs", "outputs"),
    ("workflow", "pairs", "own_proteins"),
)  # plans take seconds, runs minutes
PATIENCE = 60, 5  # s, and times what the tests take without a mistake: one that hangs is noticed


def part_of(path):
    """The part of the project that a file belongs to, which is the unit that rates are told of."""
    if path.suffix == ".js":
        return "viewer"
    if path.parts[:2] == LIBRARY.parts:
        return path.parts[2] if len(path.parts) > 3 else "top"
    return "scripts" if path.parts[0] == "scripts" else "rules"


def tests_of(part, path):
    """Where the mistakes of a part should be noticed: arguments of pytest, in turn until one notices."""
    if part == "rules":
        return [[f"tests/workflow/test_{name}.py" for name in names] for names in OF_RULES]
    return [tests_of_package(part, path)]


def tests_of_package(part, path):
    """Where the mistakes of the library, a script or the viewer should be noticed."""
    if part == "viewer":
        return ["tests/report/test_viewer.py"]
    if part == "top":
        return sorted(str(each.relative_to(ROOT)) for each in (ROOT / "tests").glob("test_*.py"))
    if part == "scripts":
        word = re.compile(rf"\b{path.stem}\b")
        files = [
            each
            for each in sorted((ROOT / "tests").rglob("test_*.py"))
            if word.search(each.read_text("utf-8"))
        ]
        runs = "--ignore=tests/workflow/test_every_rule.py"
        return [*sorted({"tests/workflow", *(str(each.relative_to(ROOT)) for each in files)}), runs]
    return [f"tests/{part}"]


def tests_beyond(path):
    """Where else a mistake of the library may be noticed: the tests of each other package that imports its file."""
    imports = re.compile(rf"^\s*(?:from|import) sparsurf[^\n]*\b{path.stem}\b", re.M)
    packages = {
        each.relative_to(ROOT / LIBRARY).parts[0]
        for each in (ROOT / LIBRARY).glob("*/**/*.py")
        if path.parts[:2] == LIBRARY.parts and imports.search(each.read_text("utf-8"))
    }
    return [[f"tests/{package}"] for package in sorted(packages - {part_of(path)})]


def sources():
    """The files in which mistakes are planted, by part."""
    patterns = ("src/**/*.py", "scripts/*.py", "rules/*.smk", "Snakefile", "src/**/viewer/*.js")
    found = {}
    for path in sorted(each.relative_to(ROOT) for pattern in patterns for each in ROOT.glob(pattern)):
        found.setdefault(part_of(path), []).append(path)
    return found


def drawn(number, seed, only):
    """Mistakes (part, path, line, what, text), as many of each part as it has a share of the lines, and LEAST at least."""
    rng, chosen = random.Random(seed), []
    files = {part: paths for part, paths in sources().items() if not only or part in only}
    size = {part: sum(len((ROOT / p).read_bytes()) for p in paths) for part, paths in files.items()}
    for part, paths in files.items():
        n = max(LEAST.get(part, 4), round(number * size[part] / sum(size.values())))
        possible = [
            (part, path, *mistake)
            for path in paths
            for mistake in mistakes(path, (ROOT / path).read_text("utf-8"))
        ]
        chosen += rng.sample(possible, min(n, len(possible)))
    return chosen


def copied(folder):
    """Copy the checkout's files, as they are in the working tree."""
    listed = ["git", "ls-files", "-co", "--exclude-standard"]
    for name in subprocess.run(
        listed, cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.splitlines():
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)


class Copy:
    """A copy of the checkout, in which one mistake at a time is planted and met by tests."""

    def __init__(self, folder):
        self.folder, self.took = folder, {}
        copied(folder)
        self.environment = os.environ | {
            "PYTHONPATH": str(folder / "src"),
            "NUMBA_CACHE_DIR": str(folder / ".kernels"),
            "MPLCONFIGDIR": str(folder / ".matplotlib"),
            "PYTHONDONTWRITEBYTECODE": "1",
            "OPENBLAS_NUM_THREADS": "1",
            "SPARSURF_SHARED": os.environ.get("SPARSURF_SHARED", str(ROOT.parent / "shared")),
        }
        self.kernels = self.kernel_folder()

    def kernel_folder(self):
        """Where the copy's kernels lie as it stands: it is named after their sources."""
        code = "from sparsurf.kernel_cache import cache_folder; print(cache_folder())"
        done = subprocess.run(
            [sys.executable, "-c", code], env=self.environment, capture_output=True, text=True
        )
        return Path(done.stdout.strip()) if done.returncode == 0 else None

    def pytest(self, tests, seconds=None):
        """Exit code and last line of pytest; 124 where it took longer than it may."""
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
        process = subprocess.Popen(
            command, cwd=self.folder, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, start_new_session=True,
        )  # fmt: skip
        try:
            said, _ = process.communicate(timeout=seconds)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, 9)
            process.communicate()
            return 124, "no end"
        return process.returncode, said.strip().splitlines()[-1] if said.strip() else ""

    def check(self, tests, all_run=True):
        """Run tests without a mistake; end the program where one fails, or skips where `all_run`."""
        begin = time.monotonic()
        code, said = self.pytest(tests)
        if code or (all_run and "skipped" in said):
            sys.exit(f"{' '.join(tests)}: {said}; all must pass, and none skip, before a mistake is planted.")
        self.took[tuple(tests)] = time.monotonic() - begin

    def notices(self, path, text, tests):
        """Whether tests notice a file's other text."""
        file = self.folder / path
        before, times = file.read_text("utf-8"), file.stat()
        file.write_text(text, "utf-8")
        try:
            kernels = self.kernel_folder()
            if kernels is None:
                return True  # the library cannot be imported any more
            if kernels != self.kernels and self.kernels.is_dir():
                shutil.copytree(self.kernels, kernels, dirs_exist_ok=True)
                self.forget(path, kernels)
            extra, times_longer = PATIENCE
            code, _ = self.pytest(tests, extra + times_longer * self.took.get(tuple(tests), 600))
            if kernels != self.kernels:
                shutil.rmtree(kernels, ignore_errors=True)
            return code != 0
        finally:
            file.write_text(before, "utf-8")
            os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))  # numba goes by it

    def notices_beyond(self, path, text):
        """The same by the tests of other packages, each checked when it is first asked."""
        for tests in tests_beyond(path):
            if tuple(tests) not in self.took:
                self.check(tests, all_run=False)
            if self.notices(path, text, tests):
                return True
        return False

    def forget(self, path, kernels):
        """Remove the kernels that may hold something of a file: of all modules that import it, however far off."""
        modules = {each: each.read_text("utf-8") for each in (self.folder / "src").rglob("*.py")}
        stale, before = {self.folder / path}, set()
        while stale != before:
            words = "|".join(each.stem for each in stale)
            imports = re.compile(rf"^\s*(?:from|import) [^\n]*\b(?:{words})\b", re.M)
            before, stale = stale, stale | {each for each, text in modules.items() if imports.search(text)}
        for module in stale:
            for kernel in kernels.glob(f"*/{module.stem}.*"):
                kernel.unlink()


def main(number, seed, only, table, everywhere):
    """Plant, print, count; returns the exit code: 1 where more than one in ten passes unnoticed."""
    chosen = drawn(number, seed, only)
    rows = []
    with tempfile.TemporaryDirectory(prefix="planted-") as name:
        copy = Copy(Path(name, "checkout"))
        asked = [tuple(tests) for part, path, *_ in chosen for tests in tests_of(part, path)]
        for tests in dict.fromkeys(asked):
            copy.check(list(tests))
        for part, path, line, what, text in chosen:
            noticed = any(copy.notices(path, text, tests) for tests in tests_of(part, path))
            noticed = noticed or (everywhere and copy.notices_beyond(path, text))
            rows.append({"part": part, "file": str(path), "line": line, "mistake": what, "noticed": noticed})
            print(f"{'noticed' if noticed else 'SURVIVED':9} {path}:{line}: {what}", flush=True)
            pd.DataFrame(rows).to_csv(table, index=False)
    found = pd.DataFrame(rows)
    rate = found.groupby("part")["noticed"].agg(["sum", "count"])
    print(rate.rename(columns={"sum": "noticed", "count": "planted"}).to_string())
    print(f"all: {found['noticed'].sum()} of {len(found)} ({100 * found['noticed'].mean():.0f} %)")
    return int(found["noticed"].mean() < 0.9)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--number", type=int, default=150, help="how many mistakes")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="*", default=(), help="parts: packages, scripts, rules, viewer")
    parser.add_argument(
        "--table", type=Path, default=Path("planted.csv"), help="where the outcome of each is written"
    )
    parser.add_argument(
        "--everywhere",
        action="store_true",
        help="ask the packages that import it before one counts as survived",
    )
    asked = parser.parse_args()
    sys.exit(main(asked.number, asked.seed, asked.only, asked.table, asked.everywhere))
