# The studies that the evidence rests on, each an import of the workflow that users run (../../Snakefile). Study NAME
# writes results/evidence_NAME: many proteins, once with the dots as they are, once with the surface recovered, once without
# the grid, once for each variant; the default study and the paper's.

import copy

from snakemake.common.configfile import load_configfile
from snakemake.utils import update_config


def study_config(name, proteins, *changes, hydrogens=config["proteins"]["hydrogens"]):
    """Config of a study of the first models of some proteins, with changes to the default study."""
    study = {
        "run": f"{Path(RESULTS).name}_{name}",
        "seed": config["seed"],
        "proteins": {
            protein: protein_entry(STRUCTURES[protein], DATA, model=1, hydrogens=hydrogens)
            for protein in proteins
            if protein not in MISSING
        },
    }
    for change in changes:
        update_config(study, copy.deepcopy(change))
    return study


def study_from_file(name, path):
    """Config in a file, with its own run; proteins that are among the structures are taken from there."""
    study = load_configfile(HOME / path) | {"run": f"{Path(RESULTS).name}_{name}"}
    known = {key: protein_entry(STRUCTURES[key], DATA) for key in study["proteins"] if key in STRUCTURES}
    return study | {"proteins": study["proteins"] | known}


def proteins_of_variant(variant):
    """Names of the proteins that are studied under a variant."""
    if variant == "hydrogens kept":
        return names_in_set(STRUCTURES, "hydrogens")
    names = names_in_set(STRUCTURES, "varied")
    if variant == "as it is":  # the reference of both sets
        names = list(dict.fromkeys([*names, *names_in_set(STRUCTURES, "hydrogens")]))
    return names


MANY_PROTEINS = names_in_set(STRUCTURES, "proteins")
RECOVERED_GRID = names_in_set(STRUCTURES, "recovered")
RECOVERED_WHOLE_GRID = names_in_set(STRUCTURES, "whole")
# Variant: name of its study. quick.yaml switches variants off by null
VARIANTS = {
    variant: "variant_" + re.sub("[^A-Za-z0-9]+", "_", variant)
    for variant, change in config["proteins"]["variants"].items()
    if change is not None
}

STUDIES = {
    "proteins": study_config("proteins", MANY_PROTEINS, config["proteins"]["study"]),
    "recovered": study_config(
        "recovered",
        RECOVERED_GRID,
        config["proteins"]["recovered"],
        config["proteins"]["thinned"],
    ),
    "whole": study_config("whole", RECOVERED_WHOLE_GRID, config["proteins"]["recovered"]),
    "required": study_config("required", MANY_PROTEINS, {"sampling": False}),
    "default": study_from_file("default", config["studies"]["default"]),
    "paper": study_from_file("paper", config["studies"]["paper"]),
}
for variant, study in VARIANTS.items():
    STUDIES[study] = study_config(
        study,
        proteins_of_variant(variant),
        config["proteins"]["varied"],
        config["proteins"]["thinned"],
        config["proteins"]["variants"][variant],
        hydrogens="keep" if variant == "hydrogens kept" else config["proteins"]["hydrogens"],
    )

for study, config_of_study in STUDIES.items():
    prefix = f"{study}_"

    module:
        name: prefix
        snakefile:
            "../../Snakefile"
        config:
            config_of_study

    use rule * from prefix as prefix*
