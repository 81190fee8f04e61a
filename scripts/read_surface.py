"""A ready surface enters the study."""

from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.workflow.jobs import run


def main(inputs, outputs):
    """Check a surface and store it in the project's own form, dots in the order of the file."""
    write_npz(outputs["surface"], read_surface(inputs["surface"]))


if __name__ == "__main__":
    run(main, snakemake)
