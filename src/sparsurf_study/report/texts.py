"""Fixed sentences of the first page: what stands above its tables and below its figures."""

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
    "recovered.csv": "how far the surface recovered from the minimal subset is from the true one",
    "fields.csv": "how well few dots recover each field",
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
FILES_OF_ALL = {
    "surfaces.csv": "every surface",
    "summary.csv": "every range of every surface",
    "relation.csv": "the best parameters against mean roughness",
    "compare.csv": "samplers compared",
}
TEXT = {
    name: _joined(text)
    for name, text in {
        "sampling": """The paper (Grassmann et al., 2022) keeps a dot j in the patch of a centre i with a probability that depends
            on how rough the patch is:""",
        "d": """d compares the dots kept with a uniform subset, as many dots drawn at random: above 0 the paper's
            sampling is better.""",
        "readings": """The paper removes points that are not connected with the rest of their patch. Its authors' code does so
            {first}; the text can also be read as {last}.""",
        "ranges": """d is cross-validated, with its 95 % interval in brackets. Link / spacing is the linking distance divided by
            the spacing of the kept dots. A subset is fragmented where less than half of the kept dots of the median patch are
            left in its island.""",
        "most": "‡: it keeps the most dots; the authors' script leaves it out of the last range.",
        "over_all": "All {n} surfaces: best on average, and d of each surface's own best.",
        "relation": """{related} of {tested} tests find that the best combination follows the mean roughness (p < 0.05).""",
        "dots": """The minimal subset is the smallest from which the surface can be recovered as closely as asked for, by default
            to 0.02 Å on average, from the positions and normals of its dots alone.""",
        "changes": """Shape and hydropathy were measured around every tenth point and averaged per residue, over 10 Å: neighbours
            of a changed residue also appear to change.""",
        "floors_of_changes": """Each change is compared with two floors: other dots on the same form, and its atoms moved at
            random by 0.3 Å, as in a fair crystal structure. 5 % of the residues lie above a floor by chance.""",
        "most_changed": """What changes most, by change over the larger floor. The last two columns are the second form minus the
            first.""",
        "pairs": """Each patch of one partner is compared with those of the other; the maps are smoothed over the dots around. The
            partners are placed as in the files, and nothing was docked.""",
        "auc": """Protrusion: few heavy atoms within 10 Å. Neighbouring dots are alike, so the interval of a partner comes from
            drawing whole blocks about 10 Å across. Means are over pairs, whose two partners are averaged first.""",
        "frames": """One combination over {n} frames, each with its own dots, test dots and draws. Consecutive frames are alike,
            so they are worth fewer independent frames.""",
        "surfaces": """Pictures: roughness, dark: rough, yellow: flat; the bar is 10 Å long. Click one to enlarge it, a name to
            turn the surface.""",
        "masked": """{masked:,} of {total:,} residues of {models:,} predicted models are left out, since their pLDDT is below the
            bound of the study.""",
        "unusual": "Distance from the median of the run, in robust standard deviations, in the measure where it is largest.",
    }.items()
}
