"""Captions of figures, and what the files of a run contain."""

from __future__ import annotations

from pathlib import Path

CAPTIONS = Path(__file__).with_name("captions")


def caption(name: str) -> str:
    """Return the caption of a figure, as the first page and Snakemake's report show it: a file of captions/."""
    return _joined((CAPTIONS / f"{name}.rst").read_text(encoding="utf-8"))


def _joined(text: str) -> str:
    """Join the lines of a text."""
    return " ".join(text.split())


# Files of a surface and what they contain
DOWNLOADS = {
    "minimal.csv": "the minimal subset: positions, normals, weights",
    "minimal.ply": "the same for 3D programs",
    "surface.ply": "the whole surface with its roughness",
    "residues.csv": "area, roughness and fields of each residue",
    "structure_roughness.pdb": "the structure, roughness as B factors",
    "open.pml": "opens the structure and the minimal subset in PyMOL",
    "open.cxc": "opens the structure and the minimal subset in ChimeraX",
    "ranges.csv": "the best combination per range of n_S, with its confidence set",
    "best.json": "the best combination of all",
    "grid.csv": "Z and d of every combination",
    "floors.csv": "the noise floor",
    "recovered.csv": "the distance between the surface reconstructed from the minimal subset and the true one",
    "fields.csv": "how well each field is interpolated from few dots",
}
# Folders of Parquet files, one for each batch
BATCH_TABLES = {
    "surfaces": "each surface",
    "residues": "area, roughness and fields of each residue",
    "dots": "the minimal subset of each surface",
}
FILES_OF_CHANGES = {
    "view_1.html": "rotate the first form",
    "view_2.html": "rotate the second form",
    "changes.csv": "every residue",
    "changed_1.pdb": "the first form, the change as B factor",
    "changed_2.pdb": "the second form, superposed onto the first",
}
FILES_OF_PAIR = ("view.html", "propensity.csv", "best_pairs.csv", "residues.csv", "open.pml", "open.cxc")
FILES_OVER_TIME = {
    "ensemble.csv": "each frame",
    "residues_over_time.csv": "each residue in each frame",
    "residues.csv": "each residue over the frames",
}
FILES_OF_SIMULATION = {
    "simulation/quality.csv": "whether the simulation is at equilibrium",
    "simulation/energies.csv": "energy, temperature, pressure and density over time",
    "simulation/motion.csv": "deviation from the first frame and radius of gyration over time",
}
FILES_OF_ALL = {
    "surfaces.csv": "every surface",
    "summary.csv": "every range of every surface",
    "relation.csv": "the best parameters against mean roughness",
    "compare.csv": "samplers compared",
}
