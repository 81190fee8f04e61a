"""Tables of other ways to store a surface over all structures: means with intervals, and pairs."""

import pandas as pd

from measures import opponents, recovery
from measures.rebuilding import rebuilders
from measures.tables import read_tables, write_tables
from sparsurf_study.workflow.jobs import job

COMPARED = (opponents.UNIFORM, opponents.MESH, opponents.CORNERS, *rebuilders())
PAIRED = ("Z", "distance", "distance_99", "largest", "back_most", "angle")

with job(snakemake):
    rows = read_tables(snakemake.input.opponents)
    common = opponents.in_common(rows)
    atoms = rows[rows["sampler"] == opponents.ATOMS].assign(percent=0)  # another share on each structure
    measured = set(common["sampler"])
    pairs = [recovery.paired(common, way, opponents.KEPT, PAIRED) for way in COMPARED if way in measured]
    write_tables(
        {
            snakemake.output.recover_opponents: rows,
            snakemake.output.recover_opponents_means: recovery.means(
                pd.concat([common, atoms]), opponents.MEASURES
            ),
            snakemake.output.recover_opponents_pairs: pd.concat(pairs, ignore_index=True),
        }
    )
