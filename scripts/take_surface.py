"""A ready surface enters the study."""

from sparsurf.surface import read_surface, write_npz
from sparsurf.workflow import job


def main(path_to_input, path_to_surface):
    """Check a surface and store it in the project's own form, dots in the order of the file."""
    write_npz(path_to_surface, read_surface(path_to_input))


if __name__ == "__main__":
    with job(snakemake) as output:
        main(snakemake.input[0], output["surface"])
