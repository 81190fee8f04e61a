"""Kill studies, `frames` and `points` of a folder within each kind of write, and compare the next run with an undisturbed one.

`python evidence/kill_studies.py [FOLDER]` prints a line for each kill; exit status 1 if any bytes differ.
"""

import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import kills
from kills import Kill
from peptides import peptide, write

# For each study the result that is deleted, computed again and killed meanwhile, and where: table, npz, page, picture, checksums
OF_STUDIES = {
    "one": [
        ("one/c1/roughness.csv", Kill(r"/roughness\.csv$")),
        ("one/c1/surface.npz", Kill(r"/surface\.npz$")),
        ("one/c1/surface.npz", Kill(r"/surface\.npz$", "job")),
        ("one/c1/surface.npz", Kill(r"/components\.csv$", "snakemake", seconds=2.5)),
        ("one/c1/roughness.csv", Kill(r"/roughness\.csv$", "snakemake", seconds=5.0)),
        ("one/c1/roughness.csv", Kill(r"\.snakemake/metadata/", "snakemake")),
        ("one/c1/residues.csv", Kill(r"/residues\.csv$", "job")),
        ("one/c1/ranges.csv", Kill(r"/best\.json$")),
        ("one/c1/grid.csv", Kill(r"/distances\.npz$", "job")),
        ("one/c1/minimal.csv", Kill(r"/minimal\.ply$")),
        ("one/c1/view.html", Kill(r"/view\.html$")),
        ("one/c1/surface.html", Kill(r"/surface\.html$", "snakemake")),
        ("one/c1/figures/subsets.png", Kill(r"/[^/]*\.svg$")),
        ("one/c1/figures/subsets.png", Kill(r"/figures/[^/]*\.svg$", "job")),
        ("one/frames.csv", Kill(r"one/.*/frames\.csv$")),
        ("one/frames.csv", Kill(r"one/frames\.csv$", "snakemake")),
        ("index.html", Kill(r"/index\.html$")),
        ("index.html", Kill(r"/ro-crate-metadata\.json$", "job")),
        ("index.html", Kill(r"/\.SHA256SUMS\.new$")),
    ],
    "two": [
        ("two/frames.csv", Kill(r"/projection\.csv$")),
        ("two/f1/surface.npz", Kill(r"/surface\.npz$", "snakemake", seconds=3.0)),
        ("two/f1/recovered.csv", Kill(r"/recovered\.csv$", "job")),
        ("pairs/both/agreement.csv", Kill(r"/agreement\.csv$")),
        ("surfaces.csv", Kill(r"/surfaces\.csv$")),
    ],
}
# Calls of the command line, and where they are killed
OF_CALLS = {
    "frames models.pdb -o r.csv --jobs 2": [
        Kill(r"\.part$"),
        Kill(r"\.part$", nth=2),
        Kill(r"\.npz$", "tree", "rename", 2),
        Kill(r"/part\.csv$"),
        Kill(r"/r_frames\.csv$", "tree", "rename"),
    ],
    "points set -o r.parquet --n-dots 64 --jobs 2": [
        Kill(r"\.part$"),
        Kill(r"\.part$", nth=3),
        Kill(r"\.npz$", "tree", "rename"),
        Kill(r"/r\.parquet$", "tree", "rename"),
    ],
    "show set/p0.pdb -o r.html": [Kill(r"/part\.html$"), Kill(r"/r\.html$", "tree", "rename")],
    "surface set/p0.pdb -o r.npz": [Kill(r"/part\.npz$"), Kill(r"/r\.npz$", "tree", "rename")],
}
CALL = "import sys\nfrom sparsurf.cli.command import main\nsys.exit(main(sys.argv[1:]))\n"


def main(folder: Path) -> int:
    """Kill all in a folder; return the exit status."""
    folder.mkdir(parents=True, exist_ok=True)
    differing = 0
    for name, outcome in chain(studies(folder), calls(folder)):
        print(f"{name}: {', '.join(outcome) or 'equal'}", flush=True)
        differing += bool(outcome)
    return int(differing > 0)


def studies(folder: Path) -> Iterator[tuple[str, list[str]]]:
    """Yield each kill of a study, and at last a whole run of it, with the files that differ then."""
    known, killed = kills.checkout(folder / "undisturbed"), folder / "killed"
    for name in OF_STUDIES:
        kills.run(kills.study(name), known)
    shutil.copytree(known, killed, symlinks=True)
    for name, results in OF_STUDIES.items():
        run = killed / "results" / name

        def differing(kept: Callable[[str], bool], name: str = name) -> list[str]:
            return different(*(kills.content(root / "results" / name) for root in (known, killed)), kept)

        for result, kill in results:
            (run / result).unlink()
            command = kills.study(name, f"results/{name}/{result}")
            kills.run(command, killed, kill, known)
            process = kills.run(command, killed)
            failed = [f"exit code {process.returncode}"] * (process.returncode != 0)
            # what lies over all surfaces is written without the failed job, and again in the whole run
            yield f"{name}, {tuple(kill)}", failed + differing(lambda path: "/" in path)
        kills.run(kills.study(name), killed)
        yield f"{name}, the whole run", differing(bool)
    config = killed / "one.yaml"
    text = config.read_text(encoding="utf-8")
    for changed in (f"{text}patches: {{r_patch: 5.0}}\n", text):
        config.write_text(changed, encoding="utf-8")
        kills.run(kills.study("one"), killed)
    yield (
        "one, another config and back",
        different(*(kills.content(root / "results" / "one") for root in (known, killed)), bool),
    )


def calls(folder: Path) -> Iterator[tuple[str, list[str]]]:
    """Yield each kill of a call of the command line, with the files that differ after the same call again."""
    for k, (command, places) in enumerate(OF_CALLS.items()):
        call = ["call.py", *command.split()]
        kills.run(call, known := inputs(folder / f"call {k}"))
        for n, kill in enumerate(places):
            killed = inputs(folder / f"call {k} kill {n}")
            kills.run(call, killed, kill, known)
            kills.run(call, killed)
            files = kills.content(known), kills.content(killed)
            # the hidden folder in which the killed call wrote its result stays
            yield (
                f"{command}, {tuple(kill)}",
                different(*files, lambda path: not path.startswith(".sparsurf-")),
            )


def inputs(folder: Path) -> Path:
    """Write the structures that the calls read; return the folder."""
    (folder / "set").mkdir(parents=True)
    (folder / "call.py").write_text(CALL, encoding="utf-8")
    models = [peptide(kills.SEQUENCE, origin=(0, k / 10, 0)) for k in range(35)]
    for k in range(5):
        write(folder / "set" / f"p{k}.pdb", models[k] + "END\n")
    text = "".join(f"MODEL {k:8}\n{model}ENDMDL\n" for k, model in enumerate(models, 1))
    write(folder / "models.pdb", text + "END\n")
    return folder


def different(known: dict[str, bytes], found: dict[str, bytes], kept: Callable[[str], bool]) -> list[str]:
    """Return the files that differ, are gone or are new, of those whose path is kept."""
    return [path for path in sorted({*known, *found}) if known.get(path) != found.get(path) and kept(path)]


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as own:
        sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else own)))
