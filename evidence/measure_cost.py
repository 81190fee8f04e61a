"""What a million dots recovered from a tenth of those of copies of one structure cost."""

import pandas as pd

from measures import recovery
from measures.molecules import atoms_of
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings):
    """Write CPU seconds for a million dots and bytes for each; this process did nothing before."""
    dots = recovery.copies_of_a_tenth(*atoms_of(inputs["structure"]), settings["dots"])
    pd.DataFrame([recovery.cost(*dots)]).to_csv(outputs["table"], index=False)


if __name__ == "__main__":
    run(main, snakemake)
