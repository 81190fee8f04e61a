"""Local roughness of every dot of a surface, as a table and as colour."""

import pandas as pd

from sparsurf.patches.index import build_index
from sparsurf.patches.roughness import roughness
from sparsurf.surfaces.components import FIELD
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.formats.ply import write_ply
from sparsurf.surfaces.spacing import refuse_sparse
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, name, threads):
    """Write R_i of every dot, and the surface coloured by it."""
    surface, patches = read_npz(inputs["surface"]), settings["patches"]
    index = build_index(surface.points, surface.normals, patches["D_link"])
    refuse_sparse(surface.points, patches["D_link"], name)
    values = roughness(index, patches["R_patch"], threads, patches["roughness"])
    pd.DataFrame({"roughness": values}).to_csv(outputs["roughness"], index=False)
    parts = {key: each.astype(int) for key, each in surface.fields.items() if key == FIELD}
    write_ply(outputs["ply"], surface, values, "roughness", parts)


if __name__ == "__main__":
    run(main, snakemake)
