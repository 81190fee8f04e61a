"""Figure 5 of the paper from A1: the surface, two combinations of the paper, and uniform subsets of the same size."""

from measures import fragments
from measures.pictures import reduce_figure
from sparsurf.paper.replication import GATHERED
from sparsurf.report.figures import layout, subsets
from sparsurf.sampling.combination import Combination
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.surface import Surface
from sparsurf.workflow.jobs import job


def main(
    structure: str,
    figure: str,
    dots: str,
    surface: dict,
    patches: dict[str, float],
    seed: int,
    threads: int,
) -> None:
    """Draw the five panels; `dots` as for `fragments.dots_of`."""
    settings = {key.lower(): value for key, value in patches.items()}
    whole = fragments.dots_of(structure, dots, surface)
    prepared = PreparedSurface(whole, **settings, seed=seed, name="gathering", threads=threads)
    cells = []
    for combination in GATHERED:
        name = str(Combination(*combination))
        sampled, uniform = (
            Surface(prepared.points[kept], prepared.normals[kept]) for kept in prepared.pair(combination, 0)
        )
        cells.append((f"the paper's sampling, {name}", sampled, layout.SAMPLED))
        cells.append(("uniform subset of the same size", uniform, layout.RANDOM))
    drawn = subsets.figure(Surface(prepared.points, prepared.normals), cells)
    drawn.savefig(figure, dpi=200, metadata={"Software": None})
    reduce_figure(figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            figure=snakemake.output.figure,
            dots=snakemake.params.dots,
            surface=snakemake.params.surface,
            patches=snakemake.params.patches,
            seed=snakemake.params.seed,
            threads=snakemake.threads,
        )
