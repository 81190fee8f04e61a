"""Complementarity and reference scores of one complex, and against a partner of another complex."""

import numpy as np
import pandas as pd

from measures.partners import pair_of, unbound_pair
from sparsurf.pairs.complex_scores import centres_of, score_complex
from sparsurf.pairs.matching import Recipe, descriptors_at
from sparsurf.pairs.partners import Partner
from sparsurf.patches.descriptors import PUBLISHED
from sparsurf.workflow.jobs import job

RADII = (6.0, 12.0)  # Å, R_zernike; the first is the published one


def main(
    partners: list[str],
    bound: list[str],
    control: list[str],
    areas: str,
    contacts: str,
    control_table: str,
    pair: str,
    descriptor: str,
    patches: int,
    threads: int,
) -> None:
    """Write the areas of all scores, the patches in contact, and the control against another complex's partner.

    `partners` is the unbound form if the structures of the `bound` one are given, too.
    """
    recipes = [Recipe(descriptor, radius) for radius in (RADII if descriptor == PUBLISHED else RADII[:1])]
    name = pair.removesuffix("_u")
    labels, others = None, None
    if bound:
        both, labels = unbound_pair(partners, bound, name)
    else:
        both = pair_of(partners, name)
    if control:
        others = _descriptors(pair_of(control, "other"), recipes[0], patches, threads)
    table, touching, _, same = score_complex(
        both, others, labels, recipes, max_patches=patches, threads=threads
    )
    keys = {"complex": name, "form": "unbound" if bound else "bound"}
    table.assign(**keys).to_csv(areas, index=False)
    touching = pd.DataFrame() if touching is None else touching
    touching.assign(**keys, descriptor=descriptor).to_csv(contacts, index=False)
    correlations = {"correlation_1": same[0], "correlation_2": same[1], "descriptor": descriptor}
    pd.DataFrame([keys | correlations]).to_csv(control_table, index=False)


def _descriptors(
    pair: list[Partner], recipe: Recipe, patches: int, threads: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return 'up' descriptors of the first partner and 'down' descriptors of the second."""
    first, second = pair
    up, _ = descriptors_at(first, first.surface.points[centres_of(first, patches)], True, recipe, threads)
    down, _ = descriptors_at(
        second, second.surface.points[centres_of(second, patches)], False, recipe, threads
    )
    return up, down


if __name__ == "__main__":
    with job(snakemake):
        main(
            partners=snakemake.input.partners,
            bound=snakemake.input.bound,
            control=snakemake.input.control,
            areas=snakemake.output.areas,
            contacts=snakemake.output.contacts,
            control_table=snakemake.output.control,
            pair=snakemake.wildcards.pair,
            descriptor=snakemake.wildcards.descriptor,
            patches=snakemake.params.patches,
            threads=snakemake.threads,
        )
