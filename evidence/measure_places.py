"""How well stored places of sites tell on which structures a site fits, and what that costs."""

import tempfile
import time
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.batches.analysis import Structure, place_dots
from sparsurf.batches.places import pack_places, settings_of_places
from sparsurf.batches.search import list_groups, rank_structures
from sparsurf.batches.tables import write_parquet
from sparsurf.sites.describing import Sites, describe_surface
from sparsurf.sites.finding import find_site
from sparsurf.streams import stream
from sparsurf.workflow.config import check_config
from sparsurf.workflow.jobs import job
from sparsurf.workflow.yaml_file import read_config

N_BEST = 10  # structures of the exact search that the stored places should name
NAMED = (10, 15, 20)  # structures that they name


def main(
    structures: dict[str, str],
    study: str,
    table: str,
    n_targets: int,
    n_queries: int,
    n_places: int,
    seed: int,
    threads: int,
) -> None:
    """Search sites of some structures on all others, exactly and by the stored places, and write a row.

    Parameters
    ----------
    structures : paths by name, of which n_targets are drawn; those that cannot be read are left out
    study : config of a study with `batch`
    table : CSV: structures, places (of all), bytes (on disk, of a place), describing_cpu_s (of a structure), queries,
        site_places, seconds (median, of a search), recall_<n> (share of the N_BEST structures of the exact search that are
        among the n named ones)
    n_queries, n_places : number of sites, and of places of each
    """
    rng, home = stream(seed, "places"), Path(__file__).resolve().parents[1]
    config = check_config(read_config(study), home=home)
    names = sorted(rng.choice(sorted(structures), min(n_targets, len(structures)), replace=False).tolist())
    start = time.process_time()
    parts, targets = [], []
    for name in names:
        entry = Structure(name, structures[name], None, {"model": 1})
        try:
            molecule, dots, _ = place_dots(entry, config["surface"], config["patches"]["D_link"])
        except InputError:  # a structure that a run lists as failed
            continue
        targets.append(describe_surface(dots, molecule, name, threads=threads))
        parts.append(pack_places(targets[-1], molecule).assign(protein=name))
    describing = time.process_time() - start
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "places", "0001.parquet")
        path.parent.mkdir()
        write_parquet(path, "places", pd.concat(parts), settings=settings_of_places(config))
        groups, _ = list_groups(Path(folder))
        chosen = rng.permutation(len(targets))[:n_queries]
        found = [_search(_site(targets[k], n_places, rng), k, targets, groups) for k in chosen.tolist()]
        n_bytes = path.stat().st_size
    seconds, recalls = zip(*found, strict=True)
    row = {
        "structures": len(targets),
        "places": sum(map(len, targets)),
        "bytes": n_bytes / sum(map(len, targets)),
        "describing_cpu_s": describing / len(targets),
        "queries": len(found),
        "site_places": n_places,
        "seconds": np.median(seconds),
    } | {f"recall_{n}": np.mean([recall[n] for recall in recalls]) for n in NAMED}
    pd.DataFrame([row]).to_csv(table, index=False, float_format="%.4g")


def _site(sites: Sites, n: int, rng: np.random.Generator) -> Sites:
    """Return the n places nearest to a random one."""
    distance = np.linalg.norm(sites.points - sites.points[rng.integers(len(sites))], axis=1)
    return sites.take(np.argsort(distance, kind="stable")[:n])


def _search(site: Sites, k: int, targets: list[Sites], groups: list) -> tuple[float, dict[int, float]]:
    """Return the seconds of a search by stored places, and its recalls; the site's own structure, number k, does not count."""
    others = [target for target in targets if target is not targets[k]]
    exact = set(find_site(site, others, N_BEST).table["target"])
    start = time.perf_counter()
    ranked = rank_structures(groups, site, max(NAMED) + 1)
    seconds = time.perf_counter() - start
    named = [name for name in ranked if name != targets[k].name]
    return seconds, {n: len(exact & set(named[:n])) / len(exact) for n in NAMED}


if __name__ == "__main__":
    with job(snakemake):
        main(
            structures=snakemake.params.structures,
            study=snakemake.input.study,
            table=snakemake.output.table,
            n_targets=snakemake.params.targets,
            n_queries=snakemake.params.queries,
            n_places=snakemake.params.places,
            seed=snakemake.params.seed,
            threads=snakemake.threads,
        )
