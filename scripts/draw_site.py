"""A site and its clearest hits, side by side."""

from dataclasses import replace
from pathlib import Path

import pandas as pd

from sparsurf.molecules.read_molecule import read_own, residue_names
from sparsurf.report.figures import layout
from sparsurf.report.figures.site_figures import carried, distance_from, facing, site_figure
from sparsurf.report.site_page import by_rarity, p_value, residue_text
from sparsurf.report.viewer.page import Values, coloured_page
from sparsurf.sites.describing import load_sites, numbered_residues, places_of_residues
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import run
from sparsurf.workflow.partner_files import SIDES

PICTURES = 3  # hits that are shown


def main(inputs, outputs, settings, site, name):
    """Draw and save the picture, and a page of the site and of its clearest hit to look at."""
    surfaces, structures = (
        {"/".join(Path(path).parts[-3:-1]): path for path in inputs[key]}
        for key in ("surfaces", "structures")
    )
    hits = by_rarity(pd.read_csv(inputs["hits"], keep_default_na=False)).head(PICTURES)
    poses = pd.read_csv(inputs["poses"]).drop(columns=["rank", "target"]).loc[hits.index].to_numpy()
    query = load_sites(inputs["query"])
    loaded = {place: read_npz(surfaces[place]) for place in (query.name, *hits["target"])}
    own, molecule = loaded[query.name], read_own(inputs["structure"])
    wanted = query.labels.iloc[places_of_residues(query, site["residues"])].drop_duplicates()
    residues = molecule.residues[numbered_residues(molecule.residues, wanted) >= 0]
    residue = numbered_residues(molecule.labels(own.atom), residues)
    panels = [(f"the site on {query.name}", own.points, own.normals, residue)]
    dots = own.points[residue >= 0], residue[residue >= 0]
    for row, pose in zip(hits.itertuples(), poses, strict=True):
        pose = pose[:9].reshape(3, 3), pose[9:]
        title = f"hit {row.rank}: {row.target}, p {p_value(float(row.p))}"
        panels.append((title, *carried(loaded[row.target], dots, pose)))
    names = [residue_text(*row) for row in residues[["chain", "residue_name", "residue"]].to_numpy()]
    turn = facing(own.points, own.normals, residue >= 0).T
    for side, place, panel in zip(SIDES, (query.name, hits["target"].iloc[0]), panels, strict=False):
        _, points, normals, on_site = panel
        surface = replace(loaded[place], points=points @ turn, normals=normals @ turn)
        gap = distance_from(points, on_site >= 0)
        values = [Values("distance from the site", "distance", " Å", gap, "on it", "far")]
        atoms = residue_names(structures.get(place))
        text = coloured_page(f"{name}, {place}", f"{name}/{side}", surface, settings, values, atoms)
        Path(outputs[f"view_{side}"]).write_text(text, encoding="utf-8")
    layout.save(site_figure(name, panels, names), outputs["png"].removesuffix(".png"))


if __name__ == "__main__":
    run(main, snakemake)
