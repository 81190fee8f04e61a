"""A site and its best hits, side by side."""

from pathlib import Path

import pandas as pd

from sparsurf.molecules.read_molecule import read_own
from sparsurf.report.figures import layout
from sparsurf.report.figures.site_figures import carried, site_figure
from sparsurf.report.site_page import p_value, residue_text
from sparsurf.sites.describing import load_sites, numbered_residues, places_of_residues
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import run

PICTURES = 3  # hits that are shown


def main(inputs, outputs, site, name):
    """Draw and save the picture."""
    surfaces = {"/".join(Path(path).parts[-3:-1]): path for path in inputs["surfaces"]}
    hits = pd.read_csv(inputs["hits"], keep_default_na=False, nrows=PICTURES)
    poses = pd.read_csv(inputs["poses"], nrows=PICTURES).drop(columns=["rank", "target"]).to_numpy()
    query = load_sites(inputs["query"])
    residues = query.labels.iloc[places_of_residues(query, site["residues"])].drop_duplicates()
    own, molecule = read_npz(surfaces[query.name]), read_own(inputs["structure"])
    residue = numbered_residues(molecule.labels(own.atom), residues)
    panels = [(f"the site on {query.name}", own.points, own.normals, residue)]
    dots = own.points[residue >= 0], residue[residue >= 0]
    for row, pose in zip(hits.itertuples(), poses, strict=True):
        pose = pose[:9].reshape(3, 3), pose[9:]
        title = f"hit {row.rank}: {row.target}, p {p_value(float(row.p))}"
        panels.append((title, *carried(read_npz(surfaces[row.target]), dots, pose)))
    names = [residue_text(*row) for row in residues[["chain", "residue_name", "residue"]].to_numpy()]
    layout.save(site_figure(name, panels, names), outputs["png"].removesuffix(".png"))


if __name__ == "__main__":
    run(main, snakemake)
