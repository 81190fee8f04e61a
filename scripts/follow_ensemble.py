"""What all frames of a trajectory gave, as one table, and R_i of the residues over them."""

from pathlib import Path

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.study.ensemble import apart, gathered
from sparsurf.study.residues import over_frames
from sparsurf.workflow.jobs import run

FIRST_ONLY = 10**9  # a stride that leaves one frame: the residues are the same in all


def main(inputs, outputs, molecule_options):
    """Write ensemble.csv, and R_i of the residues in every frame and over all."""
    residues = read_molecule(
        inputs["structure"], inputs.get("trajectory"), stride=FIRST_ONLY, **molecule_options
    ).residues
    table, over_time = apart(
        gathered(Path(path).read_text(encoding="utf-8") for path in inputs["rows"]), residues
    )
    table.to_csv(outputs["table"], index=False)
    over_time.to_csv(outputs["over_time"], index=False)
    over_frames(residues, over_time.to_numpy(float)[:, 2:]).to_csv(outputs["residues"], index=False)
    rows = [Path(path) for path in inputs["rows"]]
    for left in set(rows[0].parent.glob("*of*.csv*")) - set(rows):
        left.unlink()  # by a run that was killed when other parts shared the frames


if __name__ == "__main__":
    run(main, snakemake)
