"""Measure the local roughness of every dot of a surface."""

import pandas as pd

from sparsurf.patches.index import build_index
from sparsurf.patches.roughness import roughness as local_roughness
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.spacing import refuse_sparse
from sparsurf.workflow.jobs import job


def main(surface: str, roughness: str, patches: dict, name: str, threads: int = 1) -> None:
    """Write R_i of every dot.

    Parameters
    ----------
    patches : dict, the section `patches` of the config
    name : protein/conformation
    """
    dots = read_npz(surface)
    index = build_index(dots.points, dots.normals, patches["D_link"])
    refuse_sparse(dots.points, patches["D_link"], name)
    values = local_roughness(index, patches["R_patch"], threads, patches["roughness"])
    pd.DataFrame({"roughness": values}).to_csv(roughness, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface=snakemake.input.surface,
            roughness=snakemake.output.roughness,
            patches=snakemake.params.patches,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            threads=snakemake.threads,
        )
