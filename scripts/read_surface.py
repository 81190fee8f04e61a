"""Read the surface of another program into the study."""

from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.workflow.jobs import job


def main(path: str, surface: str) -> None:
    """Check a surface and store it as npz, dots in the order of the file."""
    write_npz(surface, read_surface(path))


if __name__ == "__main__":
    with job(snakemake):
        main(path=snakemake.input.surface, surface=snakemake.output.surface)
