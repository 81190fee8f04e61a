"""The figure of recovering: the embedded example, and the surface recovered from a tenth of its dots."""

from measures import recovery
from measures.molecules import atoms_of
from sparsurf.recovery.recovering import recover
from sparsurf.report.figures import layout, subsets
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.surface import Surface
from sparsurf.workflow.jobs import job


def main(structure: str, figure_path: str, threads: int) -> None:
    """Draw the dots, a tenth of them, and the recovered surface with its distance from the true one."""
    atoms = atoms_of(structure)
    prepared = PreparedSurface(molecular_surface(*atoms), seed=1, name="example", threads=threads)
    dots = SAMPLERS["farthest"](prepared, len(prepared.points) // 10, prepared.stream("figure"))
    subset = prepared.points[dots], prepared.normals[dots]
    recovered = recover(*subset, threads=threads)
    distance = recovery.distances(recovered[0], recovery.truth(*atoms))
    whole = Surface(prepared.points, prepared.normals)
    figure = subsets.figure(
        whole,
        [("a tenth of them, with normals", Surface(*subset), layout.SAMPLED)],
        ("the surface recovered from these", Surface(*recovered), distance),
    )
    figure.savefig(figure_path, dpi=200, metadata={"Software": None})


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            figure_path=snakemake.output.figure,
            threads=snakemake.threads,
        )
