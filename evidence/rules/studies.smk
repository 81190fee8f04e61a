# The studies that the evidence rests on, each an import of the workflow that users run: many proteins, once as they are,
# once with the grid recovered, once for each rule that is changed; the default study; the paper's.

import copy
import re

from snakemake.utils import update_config

HYDROGENS = config["proteins"]["hydrogens"]
VARIANTS = {name: own for name, own in config["proteins"]["variants"].items() if own is not None}
COMPARED = ("grid.csv", "ranges.csv", "best.json", "floors.csv", "compare.csv")


def study_of(run, names, *changes, hydrogens=HYDROGENS):
    """Config of a study: these proteins, first models, with changes on the default study."""
    own = {
        "run": f"{Path(OUT).name}_{run}",
        "seed": config["seed"],
        "proteins": {name: source.protein(name, model=1, hydrogens=hydrogens) for name in names},
    }
    for change in changes:
        update_config(own, copy.deepcopy(change))
    return own


def run_of(variant):
    """Name of the run of a variant."""
    return "variant_" + re.sub("[^A-Za-z0-9]+", "_", variant)


kept = {"hydrogens kept": ("hydrogens", "keep")}  # has proteins of its own
STUDIES = {
    "proteins": study_of("proteins", NAMES["proteins"], config["proteins"]["study"]),
    "recovered": study_of(
        "recovered", NAMES["recovered"], config["proteins"]["recovered"], config["proteins"]["thinned"]
    ),
    "whole": study_of("whole", NAMES["whole"], config["proteins"]["recovered"]),
}
OF_VARIANTS = {}
for variant, change in VARIANTS.items():
    kind, hydrogens = kept.get(variant, ("varied", HYDROGENS))
    names = NAMES[kind]
    if variant == "as it is":
        names = list(dict.fromkeys([*NAMES["varied"], *NAMES["hydrogens"]]))
    OF_VARIANTS[variant] = run_of(variant)
    STUDIES[OF_VARIANTS[variant]] = study_of(
        OF_VARIANTS[variant],
        names,
        config["proteins"]["varied"],
        config["proteins"]["thinned"],
        change,
        hydrogens=hydrogens,
    )

STUDIES |= {
    name: plan.study_file(own, name, Path(OUT).name, source) for name, own in config["studies"].items()
}

for study, of_study in STUDIES.items():
    study = f"{study}_"

    module:
        name: study
        snakefile:
            "../../Snakefile"
        config:
            of_study

    use rule * from study as study*


def place(study):
    """Folder and proteins of a run."""
    return f"results/{STUDIES[study]['run']}", list(STUDIES[study]["proteins"])


def outcome(study, of_run, of_protein):
    """Files of a run and of each of its proteins."""
    folder, names = place(study)
    found = [f"{folder}/{file}" for file in of_run]
    return found + [f"{folder}/{name}/c1/{file}" for name in names for file in of_protein]
