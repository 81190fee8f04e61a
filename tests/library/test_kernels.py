"""Stored kernels: loaded without what compiles them, complete for all commands; none where another numba lacks what they need."""

import os
import subprocess
import sys
from contextlib import suppress

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


def test_what_processes_store_is_right_after_a_kill_and_beside_others(tmp_path):
    """One is killed once it has begun to store a kernel of another source; three store it at once."""
    (package := tmp_path / "kernels_of_a_type").mkdir()
    (package / "__init__.py").touch()
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "kernels")}
    call = [sys.executable, "-c", "import kernels_of_a_type.scaling"]

    def start(n):
        started = {"cwd": tmp_path, "env": environment, "stdout": subprocess.PIPE, "text": True}
        return [subprocess.Popen(call, **started) for _ in range(n)]

    def stored():
        found = set()
        for path in tmp_path.glob("kernels/**/*.nb?"):
            with suppress(FileNotFoundError):  # another process is replacing it
                found.add((path, path.stat().st_mtime_ns))
        return found

    (package / "scaling.py").write_text(OF_A_TYPE.format(type="Same", factor=1))
    assert start(1)[0].communicate()[0] == "21.0\n"
    before = stored()
    (package / "scaling.py").write_text(OF_A_TYPE.format(type="Same", factor=2))
    (killed,) = start(1)
    while stored() == before and killed.poll() is None:
        pass
    killed.kill()
    killed.communicate()
    assert [each.communicate()[0] for each in [*start(3), *start(1)]] == 4 * ["42.0\n"]


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
