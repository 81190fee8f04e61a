"""Stored kernels: loaded without what compiles them, complete for all commands; none where another numba lacks what they need."""

import ast
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from conftest import ROOT
from sparsurf import kernels

CALL_ALL = """
import sys
from sparsurf import compile_kernels
for part in compile_kernels.PARTS.values():
    part()
print(*{"numba.np.polynomial.polynomial_core", "numba.typed.typeddict"} & set(sys.modules))  # which no kernel uses
"""


def double(x):
    """A function to compile."""
    return 2 * x


def test_stored_kernels_load_without_what_compiles_them():
    for _ in range(2):  # the first may compile some
        run = subprocess.run([sys.executable, "-c", CALL_ALL], capture_output=True, text=True, check=True)
        if run.stdout == "\n":
            break
    assert run.stdout == "\n"


def test_another_numba_stores_no_kernel(monkeypatch):
    """A kernel that it stored would be that of the older version after an upgrade."""
    assert type(kernels.njit()(double)._cache) is kernels.LightCache
    monkeypatch.setattr(kernels, "NUMBA_OFFERS_IT", False)
    kernel = kernels.njit()(double)
    assert kernel.stats.cache_path is None and kernel(21) == 42


def test_a_kernel_that_is_not_stored_stays_as_numba_makes_it():
    kernel = kernels.njit(cache=False)(double)
    assert kernel(21) == 42 and kernel.stats.cache_path is None


OF_A_TYPE = """
from typing import NamedTuple
from sparsurf.kernels import njit

class {type}(NamedTuple):
    number: float

@njit()
def scaled(of):
    return {factor} * of.number

print(scaled({type}(21.0)))
"""


def test_an_upgrade_that_renames_a_type_compiles_anew(tmp_path):
    """The signatures that an older version stored name a type that is gone."""
    (tmp_path / "kernels_of_a_type").mkdir()
    (tmp_path / "kernels_of_a_type" / "__init__.py").touch()
    for names, printed in (
        ({"type": "Older", "factor": 1}, "21.0"),
        ({"type": "Newer", "factor": 2}, "42.0"),
    ):
        (tmp_path / "kernels_of_a_type" / "scaling.py").write_text(OF_A_TYPE.format(**names))
        for _ in range(2):  # compiled, and loaded
            call = [sys.executable, "-c", "import kernels_of_a_type.scaling"]
            run = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True, check=False)
            assert run.stdout == f"{printed}\n", run.stderr[-500:]


KILLED = """
import os
from numba.core import caching
opened = caching.IndexDataCacheFile._open_for_write
def kill_at_a_form(self, path):
    return os._exit(1) if path.endswith(".nbc") else opened(self, path)
caching.IndexDataCacheFile._open_for_write = kill_at_a_form
"""


WAITING = """
import time
from pathlib import Path
from numba.core import caching
named = caching.IndexDataCacheFile._save_index
def after_another_process(self, forms):
    Path("stored").touch()
    while not Path("go").exists():
        time.sleep(0.01)
    named(self, forms)
caching.IndexDataCacheFile._save_index = after_another_process
"""


def test_no_older_form_is_loaded_after_a_kill_or_beside_another_process(tmp_path):
    """The index of numba names a form before it is there.

    A process is killed between the files of a kernel. Another one waits there, and a third, which would remove what no index
    names, waits for it.
    """
    (tmp_path / "kernels_of_a_type").mkdir()
    (tmp_path / "kernels_of_a_type" / "__init__.py").touch()
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "kernels")}

    def start(factor, before=""):
        code = OF_A_TYPE.format(type="Same", factor=factor)
        (tmp_path / "kernels_of_a_type" / "scaling.py").write_text(code)
        call = [sys.executable, "-c", before + "import kernels_of_a_type.scaling"]
        return subprocess.Popen(call, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True)

    assert [start(1).communicate()[0], start(2, KILLED).communicate()[0]] == ["21.0\n", ""]
    first = start(2, WAITING)
    while not (tmp_path / "stored").exists() and first.poll() is None:
        time.sleep(0.01)
    second = start(2)
    with pytest.raises(subprocess.TimeoutExpired):
        second.wait(3)
    (tmp_path / "go").touch()
    printed = [first.communicate()[0], second.communicate()[0], start(2).communicate()[0]]
    assert printed == 3 * ["42.0\n"] and len([*tmp_path.rglob("*.nbc")]) == 1  # the older one is removed


ALL_COMMANDS = """
import sys
from numba.core.dispatcher import Dispatcher
from sparsurf import compile_kernels
from sparsurf.cli.command import main

def loaded():
    kernels = {
        kernel for name, module in [*sys.modules.items()] if name.startswith("sparsurf.")
        for kernel in vars(module).values() if isinstance(kernel, Dispatcher)
    }
    return {(kernel.__module__, kernel.__name__, str(form)) for kernel in kernels for form in kernel.signatures}

for part in compile_kernels.PARTS.values():
    part()
before = loaded()
for command in open(sys.argv[1]).read().splitlines():
    assert main([*command.split(), "-q"]) == 0, command
    for kernel in sorted(loaded() - before):
        print(command, *kernel)
"""
COMMANDS = """\
surface protein.pdb --residues 209-214 -o dots.csv
surface protein.pdb --fields hydropathy,potential,mean_curvature,gaussian_curvature,shape_index,hbond -o dots.npz
surface protein.pdb --cavities remove --radii bondi -o dots.dms
surface protein.pdb -o dots.png
surface protein.pdb --mesh --fields potential -o mesh.ply
surface protein.pdb --mesh --density 1 -o mesh.ply
roughness dots.npz -o page.html
roughness dots.dms -o roughness.csv
residues protein.pdb --fields hydropathy,hbond -o residues.csv
regions protein.pdb --field enclosure --above 2 -o regions.csv
frames protein.pdb --fields hydropathy -o frames.csv
points protein.pdb -n 512 -o points.ply
points protein.pdb --density 0.5 --fields roughness,potential -o points.npz
minimal protein.pdb --percent 10 --sampler paper -o minimal.csv
minimal dots.npz --percent 10 --sampler paper_corrected -o minimal.npz
minimal dots.npz --percent 10 --sampler poisson -o minimal.npz
minimal dots.npz --density 0.6 --sampler uniform -o minimal.npz
minimal protein.pdb -o minimal.csv
minimal dots.npz --max-z 1 -o page.html
recover minimal.csv -o dense.dms
recover minimal.csv --mesh --density 2 -o mesh.ply
recover minimal.csv --at minimal.csv -o descriptors.csv
descriptors protein.pdb --every 500 -o descriptors.csv
descriptors protein.pdb --every 500 --down --descriptor rotation_robust -o descriptors.npz
show protein.pdb --no-open -o page.html
show minimal.csv --no-open -o page.html
show mesh.ply --no-open -o page.html
"""


def test_two_processes_that_store_one_kernel_keep_both_forms(tmp_path, monkeypatch):
    """As the two parts of the build of a wheel do; the lock is that of an open folder, so that threads show it."""
    load, forms = kernels.StoredForms._load_index, [kernels.StoredForms(tmp_path, "k", 1) for _ in range(4)]

    def load_slowly(self):
        index = load(self)
        time.sleep(0.1)
        return index

    monkeypatch.setattr(kernels.StoredForms, "_load_index", load_slowly)
    with ThreadPoolExecutor() as pool:
        list(pool.map(lambda number: forms[number].save(number, str(number)), range(4)))
    assert [forms[0].load(number) for number in range(4)] == ["0", "1", "2", "3"]


def test_no_command_compiles_a_kernel_after_the_installation(tmp_path):
    """All forms that commands load are among those that `compile_kernels`, which builds a wheel, has compiled before."""
    lines = (ROOT / "data" / "tdp43" / "topology.pdb").read_text().splitlines(keepends=True)
    atoms = [line for line in lines if line.startswith("ATOM") and int(line[22:26]) < 221]
    (tmp_path / "protein.pdb").write_text("".join(atoms))
    (tmp_path / "commands").write_text(COMMANDS)
    call = [sys.executable, "-c", ALL_COMMANDS, "commands"]
    run = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr[-2000:]
    assert run.stdout == ""


def test_kernels_import_their_constants_from_sources_that_are_hashed():
    """A line of several rows, or a module that is imported by another, would be missed."""
    folder, missed = ROOT / "src" / "sparsurf", []
    for path in sorted(folder.rglob("*.py")):
        if "@njit(" in (text := path.read_text()) and path.name != "kernels.py":
            names = {each.decode() for each, _ in kernels.IMPORTED.findall(text.encode())}
            imports = [each for each in ast.parse(text).body if isinstance(each, ast.ImportFrom)]
            used = {each.module for each in imports if (each.module or "").startswith("sparsurf.")}
            missed += sorted(used - names)
    assert missed == []
