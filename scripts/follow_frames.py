"""n_S and d of one combination over some of the frames of a trajectory."""

from pathlib import Path

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.study.ensemble import follow
from sparsurf.workflow.jobs import reporter, run


def main(inputs, outputs, molecule_options, settings, protein, part, threads, path_to_part, code):
    """Write the rows of a part of the frames; what an interrupted run has done is taken from the file beside it."""
    molecule = read_molecule(
        inputs["structure"],
        inputs.get("trajectory"),
        stride=settings["ensemble"]["stride"],
        **molecule_options,
    )
    tell = reporter(f"{protein}, part {part[0]} of {part[1]}", "frames")
    text = follow(molecule, settings, protein, threads, path_to_part, code, tell, part)
    Path(outputs["rows"]).write_text(text, encoding="utf-8")
    Path(path_to_part).unlink()


if __name__ == "__main__":
    run(main, snakemake)
