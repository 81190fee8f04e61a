"""Which claim of the study over many proteins rests on which rule."""

from measures.protein_variants import table
from measures.studies import measured
from measures.tables import of_logs, store
from sparsurf.workflow.jobs import run


def main(outputs, runs):
    """Write the claims under every rule; `runs` names the folder and the proteins of each."""
    found = {variant: measured(*each) for variant, each in runs.items()}
    logs = [f"{folder}/logs" for folder, _ in runs.values()]
    store({"proteins_variants": table(found), "variants_cpu": of_logs(*logs)}, outputs)


if __name__ == "__main__":
    run(main, snakemake)
