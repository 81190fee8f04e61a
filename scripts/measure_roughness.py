"""Local roughness of every dot of a surface, as a table and as colour."""

import pandas as pd

from sparsurf.exports import write_ply
from sparsurf.patches import build_index, refuse_sparse
from sparsurf.roughness import roughness
from sparsurf.surface import read_surface
from sparsurf.workflow import job


def main(path_to_surface, path_to_roughness, path_to_ply, patches, name, threads):
    """Write R_i of every dot, and the surface coloured by it."""
    surface = read_surface(path_to_surface)
    index = build_index(surface.points, surface.normals, patches["D_link"])
    refuse_sparse(index, patches["D_link"], name)
    values = roughness(index, patches["R_patch"], threads)
    pd.DataFrame({"roughness": values}).to_csv(path_to_roughness, index=False)
    write_ply(path_to_ply, surface, values, "roughness")


if __name__ == "__main__":
    with job(snakemake) as output:
        main(
            path_to_surface=snakemake.input.surface,
            path_to_roughness=output["roughness"],
            path_to_ply=output["ply"],
            patches=snakemake.params.patches,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            threads=snakemake.threads,
        )
