"""Draw a site and its clearest hits, side by side."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf.molecules.read_molecule import read_study_structure, residue_labels
from sparsurf.report.figures import layout
from sparsurf.report.figures.site_figures import carried, distance_from, facing, site_figure
from sparsurf.report.numbers import p_value, short_names
from sparsurf.report.site_page import by_rarity, is_found, residue_text
from sparsurf.report.viewer.page import Values, coloured_page
from sparsurf.sites.describing import load_sites, numbered_residues, places_of_residues
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import job

MAX_HITS = 3  # that are drawn


def main(
    query: str,
    structure: str,
    surfaces: list[str],
    structures: list[str],
    hits: str,
    poses: str,
    png: str,
    view_1: str,
    view_2: str,
    site: dict,
    patches: dict,
    seed: int,
    name: str,
) -> None:
    """Write the figure, and viewer pages of the site and of its clearest hit.

    Parameters
    ----------
    query, structure : described places and structure of the conformation with the site
    surfaces, structures : of the query and of all targets; paths that end in <protein>/<conformation>/<file>
    hits, poses : tables of the search
    site : dict, the entry of `sites` in the config
    patches : dict, the section `patches` of the config
    name : of the site
    """
    path_of_surface, path_of_structure = (_by_conformation(paths) for paths in (surfaces, structures))
    all_hits = pd.read_csv(hits, keep_default_na=False)
    best_hits = by_rarity(all_hits).head(MAX_HITS)
    best_poses = pd.read_csv(poses).drop(columns=["rank", "target"]).loc[best_hits.index].to_numpy()
    places = load_sites(query)
    dots = {target: read_npz(path_of_surface[target]) for target in (places.name, *best_hits["target"])}
    query_dots, molecule = dots[places.name], read_study_structure(structure)
    labels = places.labels.iloc[places_of_residues(places, site["residues"])].drop_duplicates()
    residues = molecule.residues[numbered_residues(molecule.residues, labels) >= 0]
    residue_of_dot = numbered_residues(molecule.labels(query_dots.atom), residues)
    on_site = residue_of_dot >= 0
    short = short_names(path.split("/") for path in path_of_surface)
    panels = [(f"the site on {short[places.name]}", query_dots.points, query_dots.normals, residue_of_dot)]
    found = is_found(all_hits)
    for index, row, numbers in zip(best_hits.index, best_hits.to_dict("records"), best_poses, strict=True):
        pose = numbers[:9].reshape(3, 3), numbers[9:]
        points, normals, residue = carried(dots[row["target"]], (query_dots.points, residue_of_dot), pose)
        p = f"p {p_value(float(row['p']))}"
        if found[index]:
            panels.append((f"found on {short[row['target']]}, {p}", points, normals, residue))
        else:  # a hit by chance is not painted as one
            panels.append(
                (f"not found on {short[row['target']]}, {p}", points, normals, np.full_like(residue, -1))
            )
    rotation = facing(query_dots.points, query_dots.normals, on_site).T
    shown = (places.name, view_1), (best_hits["target"].iloc[0], view_2)
    for side, ((conformation, view), panel) in enumerate(zip(shown, panels, strict=False), 1):
        _, points, normals, residue = panel
        surface = replace(dots[conformation], points=points @ rotation, normals=normals @ rotation)
        distance = distance_from(points, residue >= 0)
        values = [Values("distance from the site", "distance", " Å", distance, "on it", "or more")]
        names_of_atoms = residue_labels(path_of_structure.get(conformation))
        page = coloured_page(
            f"{name}, {short[conformation]}", f"{name}/{side}", surface, patches, seed, values, names_of_atoms
        )
        Path(view).write_text(page, encoding="utf-8")
    names = [residue_text(*row) for row in residues[["chain", "residue_name", "residue"]].to_numpy()]
    head = layout.headed(name, f"found on {found.sum()} of {len(found)} surfaces")
    layout.save(site_figure(head, panels, names), png)


def _by_conformation(paths: list[str]) -> dict[str, str]:
    """Map protein/conformation to the path of a file in its folder."""
    return {"/".join(Path(path).parts[-3:-1]): path for path in paths}


if __name__ == "__main__":
    with job(snakemake):
        main(
            query=snakemake.input.query,
            structure=snakemake.input.structure,
            surfaces=list(snakemake.input.surfaces),
            structures=list(snakemake.input.structures),
            hits=snakemake.input.hits,
            poses=snakemake.input.poses,
            png=snakemake.output.png,
            view_1=snakemake.output.view_1,
            view_2=snakemake.output.view_2,
            site=snakemake.params.site,
            patches=snakemake.params.patches,
            seed=snakemake.params.seed,
            name=snakemake.wildcards.site,
        )
