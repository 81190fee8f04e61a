# docs/proteins.md: how far position and dots change each descriptor.

DESCRIBED = names_in_set(STRUCTURES, "descriptors")


rule measure_descriptors:
    input:
        structure=ancient(structure),
    output:
        changes=f"{RESULTS}/descriptors/{{protein}}/changes.csv",
    log:
        f"{RESULTS}/logs/descriptors/{{protein}}/measure_descriptors.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        test_dots=config["descriptors"]["test_dots"],
        densities=config["descriptors"]["densities"],
        seed=config["seed"],
    message:
        "Descriptors of {wildcards.protein}, rotated and with fresh dots"
    script:
        "../measure.py"


rule tabulate_descriptors:
    input:
        changes=expand(f"{RESULTS}/descriptors/{{protein}}/changes.csv", protein=DESCRIBED),
    output:
        changes=f"{TABLES}/descriptors_changes.csv",
        changes_means=f"{TABLES}/descriptors_changes_means.csv",
        figure=f"{FIGURES}/descriptors_steadiness.png",
    log:
        f"{RESULTS}/logs/tabulate_descriptors.log",
    localrule: True
    conda:
        "../../envs/evidence.yaml"
    message:
        "Table and figure of the descriptors"
    script:
        "../measure.py"
