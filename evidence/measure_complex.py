"""AUC of the maps of one complex and of protrusion, with each descriptor."""

import pandas as pd

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.settings import Patches, Settings
from sparsurf.surfaces.molecular_surface import roll_frame
from sparsurf.surfaces.radii import radii
from sparsurf_study.pairs.matching import agreement, maps, match
from sparsurf_study.pairs.partners import partner_of, select_centres
from sparsurf_study.workflow.jobs import job

SEED = 0
SCORES = ("propensity_smoothed", "protrusion")

with job(snakemake):
    name, threads = snakemake.wildcards.pair, snakemake.threads
    settings, patches = Settings(), Settings().patches
    pair = []
    for side, path in enumerate(snakemake.input.partners, 1):
        molecule = read_molecule(path)
        rolled = roll_frame(molecule, 0, radii(molecule, settings.surface.radii), settings.surface)
        dots, _ = rolled.surface_for_d_link(settings.surface.density, patches.d_link, f"{name} {side}")
        pair.append(partner_of(dots, molecule, f"{name} {side}", patches.d_link))
    wanted = {"sampler": "farthest", "n_dots": snakemake.params.patches}
    centres = [select_centres(partner, wanted, settings, SEED, threads) for partner in pair]
    tables = []
    for descriptor in snakemake.params.descriptors:
        described = Patches(descriptor=descriptor)
        found = match(*pair, centres, patches=described, threads=threads)
        for side in (0, 1):
            areas = agreement(found, side, maps(found, side, threads=threads), seed=SEED, threads=threads)
            tables.append(areas.assign(complex=name, partner=side + 1, descriptor=descriptor))
    table = pd.concat(tables)
    table[table["score"].isin(SCORES)].to_csv(snakemake.output.areas, index=False)
