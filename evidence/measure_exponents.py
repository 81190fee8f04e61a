"""Subsets of one structure that are denser where it is rough, or where it is flat."""

from measures.exponents import measure
from measures.molecules import atoms_of
from sparsurf.study.evaluator import Evaluator
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, name, threads):
    """Write Z for every exponent, n_S and sampler."""
    surface = molecular_surface(*atoms_of(inputs["structure"]))
    evaluator = Evaluator(surface, seed=settings["seed"], name=name, threads=threads)
    asked = (settings[key] for key in ("exponents", "percents", "test_dots", "draws"))
    measure(evaluator, *asked).assign(protein=name).to_csv(outputs["table"], index=False)


if __name__ == "__main__":
    run(main, snakemake)
