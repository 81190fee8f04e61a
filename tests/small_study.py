"""A small study in which every rule runs but for those of simulations, and Snakemake as a user runs it."""

import base64
import copy
import functools
import gc
import hashlib
import json
import multiprocessing
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
import threading
import zlib
from contextlib import contextmanager
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import yaml
from snakemake.rules import Namedlist  # where every version since 9.0 has it

import warm_python
from conftest import ROOT
from peptides import peptide, write
from sparsurf_study import catalogue, columns, debug

TDP43 = ROOT / "data" / "tdp43"
SEQUENCE = ("ALA", "LEU", "LYS", "GLY", "SER", "VAL")
SETTINGS = {
    "run": "small",
    "frames": {"selection": [0, 700]},
    "sampling": {"alpha": [0.5, 1.0], "beta": [0.0, 0.4], "gamma": [0, 6], "delta": [0]},
    "evaluation": {"test_dots": 20, "draws": 2},
    "fields": ["hydropathy"],
}
PARTS = ["--set-scatter=frames=2"]  # of the frames of an ensemble
EMBEDDED = {"structure": "data/tdp43/topology.pdb", "trajectory": "data/tdp43/trajectory.xtc"}


def write_study(folder, address="http://127.0.0.1:1"):
    """Write the input files of the small study into a folder, which a server has at an address; return its config."""
    from sparsurf.molecules.read_molecule import read_molecule
    from sparsurf.surfaces.formats.npz import write_npz
    from sparsurf.surfaces.molecular_surface import molecular_surface
    from sparsurf.surfaces.radii import radii

    folder.mkdir(exist_ok=True)
    for name in ("topology.pdb", "trajectory.xtc"):
        shutil.copy(TDP43 / name, folder)
    for name, chain, y in (("still", "A", 0.0), ("loaded", "A", 0.0), ("one", "A", 0.0), ("two", "B", 9.0)):
        write(folder / f"{name}.pdb", peptide(SEQUENCE, chain, origin=(0, y, 0)) + "END\n")
    both = peptide(SEQUENCE, "A") + "TER\n" + peptide(SEQUENCE, "B", origin=(0, 9.0, 0))
    write(folder / "complex.pdb", both + "END\n")
    write(folder / "scores.csv", "residue,score\n2,1\n5,0\n210,1\n213,0\n")
    write(folder / "other.csv", "residue,score\n2,0\n5,1\n210,0\n213,1\n")
    write(folder / "other.pdb", both + "TER\nEND\n")
    molecule = read_molecule(folder / "two.pdb")
    write_npz(folder / "ready.npz", molecular_surface(molecule.xyz[0], radii(molecule, "dms"), density=9.0))
    shutil.copy(folder / "ready.npz", folder / "other.npz")
    digest = hashlib.sha256((folder / "loaded.pdb").read_bytes()).hexdigest()
    proteins = {
        "moving": {"structure": "topology.pdb", "trajectory": "trajectory.xtc", "residues": "209-216"}
        | {"table": "scores.csv"},
        "still": {"structure": "still.pdb", "table": "scores.csv"},
        "loaded": {"url": f"{address}/loaded.pdb", "sha256": digest, "sampling": False},
        "ready": {"surface": "ready.npz"},
    }
    pairs = {
        "both": {"proteins": ["moving", "still"]},
        "half": {"proteins": ["still", "ready"]},
        "files": {"files": ["one.pdb", "two.pdb"]},
        "chains": {"complex": "complex.pdb", "chains": [["A"], ["B"]]},
    }
    return SETTINGS | {
        "proteins": proteins,
        "pairs": pairs,
        "changes": {"bend": ["moving/f700", "moving/f0"]},
        "paper": "ready",
        "fields": ["hydropathy", "mean_curvature", "hbond", "score"],
        "compare": {"run": True, "percents": [20, 40], "samplers": ["paper", "uniform", "farthest"]},
        "ensemble": {"run": True, "test_dots": 20, "stride": 500},
        "complementarity": {"centres": "all"},
    }


def changed(config, key, value):
    """Return a copy of a config with another value of a key such as patches.r_patch; None: without it."""
    config = section = copy.deepcopy(config)
    *sections, last = key.split(".")
    for name in sections:
        section = section.setdefault(name, {})
    assert section.get(last) != value
    section[last] = value
    return {name: section for name, section in config.items() if section is not None}


def run_study(folder, python=sys.executable):
    """Run the small study in a folder with a Python; return the finished process."""
    folder.mkdir()
    (folder / warm_python.OPENED).mkdir()
    with served(folder) as url:
        return snakemake(folder, write_study(folder, url), python=python)


@contextmanager
def served(folder):
    """Serve a folder over http while a block runs; yield its URL."""
    server = ThreadingHTTPServer(
        ("127.0.0.1", 0), functools.partial(SimpleHTTPRequestHandler, directory=folder)
    )
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}"
    finally:
        server.shutdown()


def snakemake(folder, config, *options, root=ROOT, python=None):
    """Run the workflow in a folder of its own, with the warm Python or another; return the finished process."""
    call = command(folder, config, *options, root=root, python=python or warm_python.interpreter())
    return subprocess.run(call, capture_output=True, text=True, check=False)


def command(folder, config, *options, root=ROOT, python=sys.executable):
    """Return the command of Snakemake for a config in a folder of its own."""
    folder.mkdir(exist_ok=True)
    (folder / "config.yaml").write_text(yaml.safe_dump(config, sort_keys=False))
    where = ["--snakefile", root / "Snakefile", "--directory", folder, "--configfile", folder / "config.yaml"]
    return [python, "-m", "snakemake", *map(str, where), "--cores", "2", *PARTS, *options]


def run_script(name, folder, inputs, outputs, params=(), **wildcards):
    """Run a script of a rule in this process, with its log in a folder; its error is raised."""
    files = [named_files(inputs), named_files(outputs)]
    files += [Namedlist(fromdict=values) for values in (dict(params), wildcards)]
    given = dict(zip(("input", "output", "params", "wildcards"), files, strict=True))
    snakemake = SimpleNamespace(**given, log=[str(folder / f"{name}.log")], rule=name, threads=1)
    debug.run_script(ROOT / "scripts" / f"{name}.py", snakemake)


def named_files(files):
    """Return files by name, each a path or a list of paths, as Snakemake hands them to a script."""
    given = Namedlist()
    for name, paths in files.items():
        begin, several = len(given), isinstance(paths, list)
        given.extend(paths if several else [paths])
        given._set_name(name, begin, end=len(given) if several else None)
    return given


def output(process):
    """Return what a process printed."""
    return process.stdout + process.stderr


def unpacked(text):
    """Return the header and the columns that the page of a surface holds, read back by their description."""
    content = zlib.decompress(base64.b64decode(text.split('PACKED = "')[1].split('"')[0]))
    size = int.from_bytes(content[:4], "little")
    header, place, columns = json.loads(content[4 : 4 + size]), 4 + size, {}
    for name, length, planes, summed in header["columns"]:
        planes = np.frombuffer(content, np.uint8, planes * length, place).reshape(planes, length).astype(int)
        folded = (planes << 8 * np.arange(len(planes))[:, None]).sum(axis=0)
        values = np.where(folded % 2, -(folded + 1) // 2, folded // 2)
        columns[name], place = np.cumsum(values) if summed else values, place + planes.size
    assert place == len(content)
    return header, columns


def copy_of(study, folder):
    """Copy the folder of a study by hard links: files of the copy may be deleted and replaced, not edited or dated.

    Snakemake writes its records in place, so that these are copies.
    """
    ignored = shutil.ignore_patterns("locks", "log", warm_python.OPENED)
    records = study / ".snakemake"

    def copy(source, target):
        (shutil.copy2 if records in Path(source).parents else os.link)(source, target)

    shutil.copytree(study, folder, copy_function=copy, ignore=ignored)
    return folder


def planned_rules(folder, config, edited=()):
    """Return the names of the rules that a dry run in the folder of a study plans; see `planned_jobs`."""
    jobs = planned_jobs(folder, config, edited=edited)
    return {job["rule"] for job in jobs} - {"all", "complete_protein"}


def planned_jobs(folder, config, *options, all_jobs=False, edited=(), asks=False):
    """Return the jobs that a dry run in the folder of a study plans: a dict each, with rule, script and what the script is given.

    With `all_jobs` all of the study, where at least one is planned; `edited` are files below src/, as if each had a line more.
    With `asks`, a job says which cores, memory and time it asks for.
    """
    quiet = ["--cores", "2", *PARTS, "--dry-run", "--nolock", "--quiet", "host", "reason"]
    warm_python.import_snakemake()  # once for all dry runs, which are forks of this process
    with tempfile.TemporaryDirectory() as own:  # not in the folder, which others copy
        path, log, listed = (Path(own, f"planned.{suffix}") for suffix in ("yaml", "log", "jobs"))
        path.write_text(yaml.safe_dump(config, sort_keys=False))
        where = ["--snakefile", ROOT / "Snakefile", "--directory", folder, "--configfile", path]
        call = (
            log,
            listed,
            [*map(str, where), *quiet, *options],
            all_jobs,
            [ROOT / "src" / name for name in edited],
            asks,
        )
        process = multiprocessing.get_context("fork").Process(target=_dry_run, args=call)
        process.start()
        process.join()
        text = log.read_text()
        jobs, parsed = pickle.loads(listed.read_bytes()) if listed.is_file() else ([], {})
    assert process.exitcode == 0, text
    PARSED.update(parsed)
    return jobs


# What Snakemake makes of each file of rules that a dry run has included: code, number of rules, and numbers of lines
PARSED = {}


def parse_once(parse, new, path, workflow, linemap, rulecount=0):
    """Parse a file of rules as Snakemake's `parse` does, or take what an earlier dry run made of it; note what is `new`."""
    key = path.get_path_or_uri(secret_free=True), rulecount
    if key not in PARSED:
        PARSED[key] = new[key] = (*parse(path, workflow, linemap, rulecount=rulecount), dict(linemap))
    code, rulecount, lines = PARSED[key]
    linemap.update(lines)
    return code, rulecount


def _dry_run(log, listed, options, all_jobs, edited, asks):
    """Plan in this process, whose output goes to a file."""
    gc.disable()  # it would search, and so copy, what this fork shares with the tests
    with open(log, "w", encoding="utf-8") as stream:
        os.dup2(stream.fileno(), 1)
        os.dup2(stream.fileno(), 2)
        sys.stdout, sys.stderr = (os.fdopen(number, "w", closefd=False) for number in (1, 2))
        import snakemake.workflow
        from snakemake.cli import main
        from snakemake.jobs import Job

        planned, parsed = {}, {}
        snakemake.workflow.parse = functools.partial(parse_once, snakemake.workflow.parse, parsed)

        def note(job, **_):
            jobs = job.dag.jobs if all_jobs else [job]
            planned.update((each, _description(each, asks)) for each in jobs if each not in planned)

        Job.log_info = note  # of this fork
        from sparsurf import registry

        for registered in registry._registered.values():  # a new process knows nothing that other tests added
            registered.clear()
        registry._plugins_in_use.clear()
        registry.plugins.cache_clear()
        catalogue.checksum.cache_clear()
        as_it_is = Path.read_bytes
        Path.read_bytes = lambda path: as_it_is(path) + (b"\n# a line more" if path in edited else b"")
        try:
            main(options)
        finally:  # which ends the process
            listed.write_bytes(pickle.dumps(([*planned.values()], parsed)))


def _description(job, asks):
    files = {kind: getattr(job, kind)._plainstrings() for kind in ("input", "output", "log")}
    known = {
        "rule": job.rule.name,
        "script": job.rule.script,
        "config": {"origin": job.rule.workflow.config["origin"]},
    }
    known["needs"] = [(each.rule.name, *each.wildcards[1:]) for each in job.dag.dependencies[job]]
    known |= {"asks": _resources(job)} if asks else {}
    return known | files | {"wildcards": job.wildcards, "params": job.params}


def _resources(job):
    """Return the cores and the resources of the first and of the second attempt of a job."""
    attempts, before = [], job.attempt
    for attempt in (1, 2):
        job.attempt = attempt  # which makes Snakemake ask again
        attempts.append({name: job.resources.get(name) for name in ("_cores", "mem_mb", "runtime")})
    job.attempt = before
    return attempts


def run_job(folder, job, first=""):
    """Run some code and the script of a planned job in the folder of a study, as Snakemake does; return the finished process."""
    from snakemake.script import Snakemake

    for path in map(folder.joinpath, (*job["output"], *job["log"])):
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
        path.parent.mkdir(parents=True, exist_ok=True)
    names = ("input", "output", "params", "wildcards")
    given = Snakemake(
        *(job[name] for name in names), 1, {}, job["log"], job["config"], job["rule"], [], ROOT / "scripts"
    )
    script = ROOT / "scripts" / Path(job["script"]).name
    (folder / "job.pickle").write_bytes(pickle.dumps(given))
    text = f"import pickle, sys; sys.path.insert(0, {str(script.parent)!r})\n"
    text += f"snakemake = pickle.load(open('job.pickle', 'rb'))\n{first}{script.read_text(encoding='utf-8')}"
    (folder / "job.py").write_text(text, encoding="utf-8")
    call = [warm_python.interpreter(), "job.py"]
    return subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)


def table_of(path):
    """The table of the catalogue that a file of a run is, by its path below results/<run>/; KeyError if it is not listed."""
    output = catalogue.output_of(path)
    if output is None or not output.row:
        raise KeyError(f"{path} is not a table of catalogue.yaml")
    return columns.tables()[output.path]
