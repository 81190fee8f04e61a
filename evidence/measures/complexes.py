"""How well complementarity and protrusion find the interface of a complex."""

import pandas as pd

from sparsurf_study.workflow.jobs import Job
from measures.tables import read_tables, write_tables
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.settings import PatchesSettings, Settings
from sparsurf.surfaces.molecular_surface import roll_frame
from sparsurf.surfaces.radii import radii
from sparsurf.views import layout
from sparsurf_study.pairs.matching import agreement, maps, match
from sparsurf_study.pairs.partners import partner_of, select_centres
from sparsurf_study.pairs.ranking import means_over_pairs
from sparsurf_study.report.figures.pair_figures import over_pairs

SEED = 0
SCORES = ("propensity_smoothed", "protrusion")
COLUMNS = ["complex", "partner", "descriptor", "score", "auc", "low", "high", "dots", "interface"]
NAMES = {"rotation_robust propensity_smoothed": "complementarity, rotation-robust"}  # in the figure


def measure_complexes(job: Job) -> None:
    """Measure the AUC of the maps of one complex and of protrusion, with each descriptor."""
    name, threads = job.wildcards.pair, job.threads
    settings, patches = Settings(), Settings().patches
    pair = []
    for side, path in enumerate(job.input.partners, 1):
        molecule = read_molecule(path)
        rolled = roll_frame(molecule.xyz[0], radii(molecule, settings.surface.radii), settings.surface)
        dots, _ = rolled.surface_for_d_link(settings.surface.density, patches.d_link, f"{name} {side}")
        pair.append(partner_of(dots, molecule, f"{name} {side}", patches.d_link))
    wanted = {"sampler": "farthest", "n_dots": job.params.patches}
    centres = [select_centres(partner, wanted, settings, SEED, threads) for partner in pair]
    tables = []
    for descriptor in job.params.descriptors:
        described = PatchesSettings(descriptor=descriptor)
        found = match(*pair, centres, patches=described, threads=threads)
        for side in (0, 1):
            areas = agreement(found, side, maps(found, side, threads=threads), seed=SEED, threads=threads)
            tables.append(areas.assign(complex=name, partner=side + 1, descriptor=descriptor))
    table = pd.concat(tables)
    table[table["score"].isin(SCORES)].to_csv(job.output.areas, index=False)


def tabulate_complexes(job: Job) -> None:
    """Tabulate and draw the AUC of complementarity and of protrusion over many complexes."""
    areas = read_tables(job.input.areas)[COLUMNS]
    areas["descriptor"] = areas["descriptor"].mask(areas["score"] == "protrusion", "-")
    areas = areas.drop_duplicates(COLUMNS[:4])
    means = means_over_pairs(areas, ["descriptor", "score"])
    tables = {job.output.complexes: areas, job.output.complexes_means: means}
    write_tables(tables, "%.4f")
    named = (areas["descriptor"] + " " + areas["score"]).map(NAMES).fillna(areas["score"])
    layout.save(over_pairs("complexes", areas.assign(score=named)), job.output.figure)
