"""Measure the local roughness of every dot of a surface."""

from pathlib import Path

from sparsurf_study.workflow.jobs import job
from sparsurf.patches.index import build_index
from sparsurf.patches.roughness import roughness_of_patches
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.spacing import refuse_sparse

with job(snakemake) as s:
    dots, patches = read_npz(s.input.surface), s.params.patches
    index = build_index(dots.points, dots.normals, patches["d_link"])
    refuse_sparse(dots.points, patches["d_link"], s.place)
    values = roughness_of_patches(index, patches["r_patch"], s.threads, patches["roughness"])
    # without pandas, whose import would take longer than the measurement
    Path(s.output.roughness).write_text(
        "\n".join(["roughness", *map(str, values.tolist()), ""]), encoding="utf-8"
    )
