# The studies that the evidence rests on, each an import of the workflow that users run (../../Snakefile). Study NAME
# writes results/evidence_NAME: many proteins with the dots as they are, some with the surface recovered, and
# the paper's.

import copy

from snakemake.common.configfile import load_configfile
from snakemake.utils import update_config


def study_config(name, changes):
    """Config of a study of the first models of many proteins, with changes to the default study."""
    study = {
        "run": f"{Path(RESULTS).name}_{name}",
        "seed": config["seed"],
        "proteins": {
            protein: protein_entry(
                STRUCTURES[protein], DATA, model=1, hydrogens=config["proteins"]["hydrogens"]
            )
            for protein in MANY_PROTEINS
            if protein not in MISSING
        },
    }
    update_config(study, copy.deepcopy(changes))
    return study


def study_from_file(name, path):
    """Config in a file, with its own run; proteins that are among the structures are taken from there."""
    study = load_configfile(HOME / path) | {"run": f"{Path(RESULTS).name}_{name}"}
    known = {key: protein_entry(STRUCTURES[key], DATA) for key in study["proteins"] if key in STRUCTURES}
    return study | {"proteins": study["proteins"] | known}


MANY_PROTEINS = names_in_set(STRUCTURES, "proteins")
SOME_PROTEINS = MANY_PROTEINS[:: config["proteins"]["every"]]
STUDIES = {
    "proteins": study_config("proteins", config["proteins"]["study"]),
    "recovered": study_config("recovered", config["proteins"]["recovered"]),
    "paper": study_from_file("paper", config["paper"]),
}

for study, config_of_study in STUDIES.items():
    prefix = f"{study}_"

    module:
        name: prefix
        snakefile:
            "../../Snakefile"
        config:
            config_of_study

    use rule * from prefix as prefix*
