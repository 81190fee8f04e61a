"""The figure of recovering: the dots of the embedded example, a tenth of them, and the surface recovered from these."""

from measures import recovery
from measures.molecules import atoms_of
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.recovery.recovering import recover
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.streams import Streams
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.surface import Surface
from sparsurf.views import layout
from sparsurf_study.report.figures import subsets
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    atoms = atoms_of(snakemake.input.structure)
    prepared = PreparedSurface(
        molecular_surface(*atoms), streams=Streams(1, "example"), threads=snakemake.threads
    )
    dots = SAMPLERS["farthest"](prepared, len(prepared.points) // 10, prepared.stream("figure"))
    subset = prepared.points[dots], prepared.normals[dots]
    recovered = recover(*subset, threads=snakemake.threads)
    distance = recovery.distances(recovered[0], recovery.truth(*atoms))
    figure = subsets.figure(
        Surface(prepared.points, prepared.normals),
        [("a tenth of them, with normals", Surface(*subset), layout.DARK)],
        ("the surface reconstructed from these", Surface(*recovered), distance),
    )
    figure.savefig(snakemake.output.figure, dpi=200, metadata={"Software": None})
