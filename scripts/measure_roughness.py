"""Local roughness of every dot of a surface."""

import pandas as pd

from sparsurf.patches.index import build_index
from sparsurf.patches.roughness import roughness
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.spacing import refuse_sparse
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, name, threads):
    """Write R_i of every dot."""
    surface, patches = read_npz(inputs["surface"]), settings["patches"]
    index = build_index(surface.points, surface.normals, patches["D_link"])
    refuse_sparse(surface.points, patches["D_link"], name)
    values = roughness(index, patches["R_patch"], threads, patches["roughness"])
    pd.DataFrame({"roughness": values}).to_csv(outputs["roughness"], index=False)


if __name__ == "__main__":
    run(main, snakemake)
