"""What a batch of structures costs: CPU, memory and disk of each, next to the CPU of placing its dots once."""

import tempfile
import time
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf_study.workflow.jobs import Job
from measures.memory import peak_memory
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.settings import Settings
from sparsurf.surfaces.molecular_surface import density_for_d_link, roll_frame
from sparsurf.surfaces.radii import radii
from sparsurf_study.batches.analysis import Structure, analyse_batch
from sparsurf_study.batches.tables import write_parquet
from sparsurf_study.config.check import check_config
from sparsurf_study.config.yaml_file import read_config


def cpu_of_placing(path: str, settings: Settings) -> float:
    """Measure the CPU time, in s, of placing the dots of a structure once, at the density that suits d_link."""
    molecule, rules = read_molecule(path, model=1), settings.surface
    sizes = radii(molecule, rules.radii)
    density = density_for_d_link(molecule.xyz[0], sizes, rules, settings.patches.d_link, path)
    start = time.process_time()
    roll_frame(molecule.xyz[0], sizes, rules).surface(density)
    return time.process_time() - start


def measure_batch(job: Job) -> None:
    """Measure CPU, memory and disk of the structures of a batch, and the CPU of placing their dots once."""
    config = check_config(read_config(job.input.study), home=Path(__file__).resolve().parents[1])
    settings = Settings.of(config)
    paths = job.params.structures
    start = time.process_time()
    tables = analyse_batch(
        [Structure(name, path, None, {"model": 1}) for name, path in paths.items()], settings, config["seed"]
    )
    with tempfile.TemporaryDirectory() as folder:
        for name, rows in tables.items():
            write_parquet(Path(folder, name), name, rows)
        cpu, disk = time.process_time() - start, sum(path.stat().st_size for path in Path(folder).iterdir())
    failed = {*tables["failures"].get("protein", [])}
    placing = [cpu_of_placing(path, settings) for name, path in paths.items() if name not in failed]
    row = {
        "structures": len(paths),
        "failed": len(failed),
        "atoms": tables["surfaces"]["atoms"].mean(),
        "cpu_s": cpu / len(paths),
        "placing_cpu_s": np.mean(placing),
        "times": cpu / np.sum(placing),
        "memory_MB": peak_memory() / 1e6,
        "disk_kB": disk / 1e3 / len(paths),
    }
    pd.DataFrame([row]).to_csv(job.output.table, index=False)
