"""Tables over many complexes, of every descriptor."""

from measures.complex_tables import tables_of
from measures.tables import joined, of_logs, store
from sparsurf.workflow.jobs import run


def main(inputs, outputs, logs, chosen_on):
    """Write every table."""
    contacts = joined(inputs["contacts"])
    parts = joined(inputs["areas"]), contacts[contacts["form"] == "bound"], joined(inputs["control"])
    store(tables_of(*parts, chosen_on) | {"complexes_cpu": of_logs(logs)}, outputs, "%.4f")


if __name__ == "__main__":
    run(main, snakemake)
