"""The figure of recovering: the embedded example, and what a tenth of its dots gives back."""

from pathlib import Path

from measures import recovery
from measures.molecules import atoms_of
from sparsurf.recovery.recovering import recover
from sparsurf.report.figures import layout, subsets
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.study.evaluator import Evaluator
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.surface import Surface
from sparsurf.workflow.jobs import run

EXAMPLE = Path(__file__).parents[1] / "data" / "tdp43" / "topology.pdb"


def main(outputs, threads):
    """Draw the dots, a tenth of them, and the recovered surface with its distance from the true one."""
    atoms = atoms_of(EXAMPLE)
    evaluator = Evaluator(molecular_surface(*atoms), seed=1, name="example", threads=threads)
    dots = SAMPLERS["farthest"](evaluator, len(evaluator.points) // 10, evaluator.stream("figure"))
    kept = evaluator.points[dots], evaluator.normals[dots]
    dense = recover(*kept, threads=threads)
    gap = recovery.distances(dense[0], recovery.truth(*atoms))
    whole = Surface(evaluator.points, evaluator.normals)
    figure = subsets.figure(
        whole, [("a tenth of them, with normals", Surface(*kept), layout.SAMPLED)],
        ("the surface recovered from these", Surface(*dense), gap),
    )  # fmt: skip
    figure.savefig(outputs["recover"], dpi=200, metadata={"Software": None})


if __name__ == "__main__":
    run(main, snakemake)
