"""Build hook of hatchling: `pip install .` compiles the numba kernels, so that the first command only loads them.

The kernels are valid for this processor, numba and Python, which the tag of the wheel tells as far as it can; elsewhere the
commands compile at their first use. The wheel is plain in an editable install (`make setup` compiles beside the sources), where
compiling fails, and with HATCH_BUILD_NO_HOOKS=1 (`make package`, for an index).
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PARTS = ("surfaces", "patches")  # of sparsurf.compile_kernels, in one process each


class CompiledKernels(BuildHookInterface):
    """Adds the compiled kernels to a wheel."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile the kernels of a copy of the package, and include their files in the `__pycache__` beside its modules."""
        if self.target_name != "wheel" or version == "editable":
            return
        self.folder = tempfile.mkdtemp(prefix="sparsurf-wheel-")  # until the wheel is written
        copy = Path(self.folder, "sparsurf")
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(Path(self.root, "src", "sparsurf"), copy, ignore=ignored)
        self.app.display_info("Compiling the kernels, which takes about a minute ...")
        if not self._compile(copy.parent):
            self.app.display_warning(
                "The kernels could not be compiled: the first commands will compile them."
            )
            return
        files = [*copy.rglob("*.nbi"), *copy.rglob("*.nbc")]
        build_data["force_include"] |= {str(file): str(file.relative_to(self.folder)) for file in files}
        build_data["pure_python"], build_data["infer_tag"] = False, True

    def _compile(self, folder: Path) -> bool:
        """Compile both parts at once beside the sources in a folder; return whether both succeeded."""
        unset = {"NUMBA_CACHE_DIR", "NUMBA_DISABLE_JIT", "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"}
        environment = {name: value for name, value in os.environ.items() if name not in unset}
        paths = [str(folder), environment.get("PYTHONPATH", "")]
        environment["PYTHONPATH"] = os.pathsep.join(filter(None, paths))
        command = [sys.executable, "-m", "sparsurf.compile_kernels"]
        jobs = [subprocess.Popen([*command, part], env=environment, cwd=folder) for part in PARTS]
        return not any([job.wait() for job in jobs])

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:  # noqa: ARG002
        """Remove the copy."""
        shutil.rmtree(getattr(self, "folder", ""), ignore_errors=True)
