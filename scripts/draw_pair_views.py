"""A page to look at each partner of a pair, with the binding propensity of its dots."""

from pathlib import Path

import pandas as pd

from sparsurf.molecules.read_molecule import residue_names
from sparsurf.report.viewer.page import MOST_DOTS, Values, page
from sparsurf.sampling.samplers import farthest
from sparsurf.study.evaluator import Evaluator
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import run
from sparsurf.workflow.partner_files import SIDES


def main(inputs, outputs, settings, name):
    """Write view_1.html and view_2.html."""
    dots = pd.read_csv(inputs["dots"], low_memory=False)
    for side in SIDES:
        surface, own = read_npz(inputs[f"surface_{side}"]), dots[dots["partner"] == int(side)]
        evaluator = Evaluator.from_settings(surface, settings, None, f"{name}/{side}", 1)
        order = farthest(evaluator, min(len(surface), MOST_DOTS), evaluator.stream("view"))
        values = [
            Values(
                "binding propensity", "propensity", "",
                own["propensity_smoothed"].to_numpy(), "good match", "poor match",
            ),
            Values("distance to the partner", "gap", " Å", own["gap"].to_numpy(), "touching", "far"),
        ]  # fmt: skip
        text = page(
            f"{name}, partner {side}",
            surface,
            evaluator.roughness,
            evaluator.cover,
            evaluator.r_patch,
            {"farthest": order},
            residues=residue_names(inputs.get(f"structure_{side}")),
            values=values,
            opens=("all", 1),
        )
        Path(outputs[f"view_{side}"]).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    run(main, snakemake)
