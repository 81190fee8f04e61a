"""A structure from the network enters the study."""

from sparsurf.workflow.download import fetch
from sparsurf.workflow.jobs import run


def main(outputs, url, sha256, name):
    """Fetch and verify a structure."""
    fetch(url, sha256, outputs["structure"], outputs["record"], name)


if __name__ == "__main__":
    run(main, snakemake)
