"""Find a site of one conformation on others."""

from dataclasses import replace
from pathlib import Path

import pandas as pd

from sparsurf import InputError
from sparsurf.molecules.read_molecule import read_study_structure
from sparsurf.report.page import write
from sparsurf.report.site_page import TEMPLATE, site_page, superposed_file
from sparsurf.rounding import write_table
from sparsurf.sites.describing import load_sites, places_of_residues
from sparsurf.sites.finding import find_site, matched
from sparsurf.workflow.conformations import require_conformation
from sparsurf.workflow.jobs import job

MAX_SUPERPOSED = 10  # hits that the query is superposed onto
POSE_COLUMNS = [
    f"{name}_{axis}" for name in ("rotation_1", "rotation_2", "rotation_3", "shift") for axis in "xyz"
]


def main(
    query: str | None,
    structure: str | None,
    targets: list[str],
    hits: str,
    matches: str,
    poses: str,
    superposed: str,
    page: str,
    site: dict,
    name: str,
) -> None:
    """Write the hits, the places that match, the poses, the page, and the query superposed onto the best hits.

    Parameters
    ----------
    query, targets : described places of the conformation with the site and of those to search
    structure : of the conformation with the site
    query, structure : None where the study does not have a conformation that the site names
    site : dict, the entry of `sites` in the config
    name : of the site
    """
    query_places = load_sites(require_conformation(query, name))
    target_places = [load_sites(path) for path in targets]
    if not target_places or query_places.name in {places.name for places in target_places}:
        raise InputError(
            f"sites.{name}: {query_places.name} is all that would be searched; name other targets."
        )
    site_places = query_places.take(places_of_residues(query_places, site["residues"]))
    hits_found = find_site(site_places, target_places, len(target_places))
    write_table(hits, hits_found.table)
    match_table = matched(hits_found, target_places)
    match_table.to_csv(matches, index=False, float_format="%.3f")
    numbers = pd.DataFrame(
        [[*pose.rotation.ravel(), *pose.shift] for pose in hits_found.poses], columns=POSE_COLUMNS
    )
    pose_table = pd.concat([hits_found.table[["rank", "target"]], numbers], axis=1)
    pose_table.to_csv(poses, index=False, float_format="%.6f")
    Path(superposed).mkdir()
    molecule = read_study_structure(require_conformation(structure, name))
    best = hits_found.table.head(MAX_SUPERPOSED)[["rank", "target", "places"]].to_numpy()
    for (rank, target, n_places), pose in zip(best, hits_found.poses, strict=False):
        if n_places:  # else nothing agrees and there is no pose
            moved = replace(molecule, xyz=molecule.xyz @ pose.rotation + pose.shift)
            moved.write_pdb(Path(superposed, superposed_file(rank, target)))
    facts = site_page(name, site, query_places.name, hits_found.table, match_table, len(hits_found.places))
    write(page, TEMPLATE, **facts)


if __name__ == "__main__":
    with job(snakemake):
        main(
            query=snakemake.input.get("query"),
            structure=snakemake.input.get("structure"),
            targets=list(snakemake.input.get("targets", [])),
            hits=snakemake.output.hits,
            matches=snakemake.output.matches,
            poses=snakemake.output.poses,
            superposed=snakemake.output.superposed,
            page=snakemake.output.page,
            site=snakemake.params.site,
            name=snakemake.wildcards.site,
        )
