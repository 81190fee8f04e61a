# docs/few_dots.md: the errors of surfaces reconstructed from few dots, and other ways to store a surface in as many bytes.


rule measure_opponents:
    input:
        structure=ancient(structure),
    output:
        table=f"{RESULTS}/recover/{{protein}}/opponents.csv",
    log:
        f"{RESULTS}/logs/opponents/{{protein}}/measure_opponents.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        percents=config["recover"]["percents"],
        test_dots=config["recover"]["test_dots"],
        seed=config["seed"],
    message:
        "Other ways to store {wildcards.protein} in as many bytes"
    script:
        "../measure.py"


rule tabulate_opponents:
    input:
        opponents=expand(
            f"{RESULTS}/recover/{{protein}}/opponents.csv",
            protein=names_in_set(STRUCTURES, "opponents"),
        ),
    output:
        recover_opponents=f"{TABLES}/recover_opponents.csv",
        recover_opponents_means=f"{TABLES}/recover_opponents_means.csv",
        recover_opponents_pairs=f"{TABLES}/recover_opponents_pairs.csv",
    log:
        f"{RESULTS}/logs/tabulate_opponents.log",
    localrule: True
    conda:
        "../../envs/evidence.yaml"
    message:
        "Tables of other ways to store a surface"
    script:
        "../measure.py"


rule measure_enough:
    input:
        structure=ancient(structure),
    output:
        table=f"{RESULTS}/enough/{{protein}}/enough.csv",
        coverage=f"{RESULTS}/enough/{{protein}}/coverage.csv",
    log:
        f"{RESULTS}/logs/enough/{{protein}}/measure_enough.log",
    conda:
        "../../envs/evidence.yaml"
    threads: 2
    params:
        dots=config["enough"]["dots"],
        surface=config["enough"]["surface"],
        patches=config["fragments"]["patches"],
        error=config["enough"]["error"],
        seeds=config["enough"]["seeds"],
        seed=config["seed"],
    message:
        "How many dots of {wildcards.protein} are enough"
    script:
        "../measure.py"


rule tabulate_enough:
    input:
        tables=expand(f"{RESULTS}/enough/{{protein}}/enough.csv", protein=config["enough"]["surfaces"]),
        coverage=expand(f"{RESULTS}/enough/{{protein}}/coverage.csv", protein=config["enough"]["surfaces"]),
    output:
        table=f"{TABLES}/recover_enough.csv",
        coverage=f"{TABLES}/recover_enough_coverage.csv",
    log:
        f"{RESULTS}/logs/tabulate_enough.log",
    localrule: True
    conda:
        "../../envs/evidence.yaml"
    message:
        "Tables of how many dots are enough"
    script:
        "../measure.py"


rule draw_recovery:
    input:
        structure=ancient("data/tdp43/topology.pdb"),
    output:
        figure=f"{FIGURES}/recover.png",
    log:
        f"{RESULTS}/logs/draw_recovery.log",
    localrule: True
    conda:
        "../../envs/evidence.yaml"
    message:
        "Figure of a recovered surface"
    script:
        "../measure.py"


SPHERES_GROUPS = {
    "chains": config["spheres"]["chains"],
    "with hydrogens": config["spheres"]["with_hydrogens"],
    "all chains": names_in_set(STRUCTURES, "chains")[
        config["spheres"]["all"]["first"] :: config["spheres"]["all"]["every"]
    ],
    "others": config["spheres"]["others"],
}
SPHERES_MEASURED_MORE = {
    "chains": config["spheres"]["chains"][:: config["spheres"]["more"]["every"]],
    "with hydrogens": config["spheres"]["with_hydrogens"],
    "all chains": [],
    "others": [],
}
SPHERES_PARTS = {
    f"{group.replace(' ', '_')}_{k}": (group, names[k :: config["spheres"]["parts"]])
    for group, names in SPHERES_GROUPS.items()
    for k in range(min(config["spheres"]["parts"], len(names)))
}


rule measure_spheres:
    input:
        structures=lambda wildcards: ancient(
            [structure_file(name) for name in SPHERES_PARTS[wildcards.part][1]]
        ),
    output:
        errors=f"{RESULTS}/spheres/{{part}}.csv",
    log:
        f"{RESULTS}/logs/spheres/{{part}}.log",
    wildcard_constraints:
        part=one_of(SPHERES_PARTS),
    conda:
        "../../envs/evidence.yaml"
    params:
        structures=lambda wildcards: {name: structure_file(name) for name in SPHERES_PARTS[wildcards.part][1]},
        group=spheres_group,
        hydrogens="keep",
        densities=lambda wildcards: config["spheres"]["densities"][spheres_group(wildcards)],
        more_densities=config["spheres"]["more"]["densities"],
        measured_more=lambda wildcards: SPHERES_MEASURED_MORE[spheres_group(wildcards)],
        of_cover=lambda wildcards: config["spheres"]["of_cover"][spheres_group(wildcards)],
        requested_errors=lambda wildcards: config["spheres"]["errors"][spheres_group(wildcards)],
        seed=config["seed"],
    message:
        "Errors of the interpolant and of the spheres: {wildcards.part}"
    script:
        "../measure.py"


OTHER_DOTS = config["other_dots"]["structures"]


rule measure_other_dots:
    input:
        structures=ancient([structure_file(name) for name in OTHER_DOTS]),
    output:
        table=f"{TABLES}/spheres_other_dots.csv",
        means=f"{TABLES}/spheres_other_dots_means.csv",
    log:
        f"{RESULTS}/logs/spheres/measure_other_dots.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        structures={name: structure_file(name) for name in OTHER_DOTS},
        densities=config["other_dots"]["densities"],
        seed=config["seed"],
    message:
        "Dots that do not lie on spheres"
    script:
        "../measure.py"


rule measure_spheres_z:
    input:
        structures=ancient([structure_file(name) for name in config["spheres"]["chains"]]),
    output:
        table=f"{TABLES}/spheres_z.csv",
        means=f"{TABLES}/spheres_z_means.csv",
    log:
        f"{RESULTS}/logs/spheres/measure_spheres_z.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        structures={name: structure_file(name) for name in config["spheres"]["chains"]},
        hydrogens="keep",
        densities=config["spheres"]["z"]["densities"],
        of_cover=config["spheres"]["of_cover"]["chains"],
        requested_errors=config["spheres"]["errors"]["chains"],
        test_dots=config["spheres"]["z"]["test_dots"],
        draws=config["spheres"]["z"]["draws"],
        seed=config["seed"],
    message:
        "Z of surfaces reconstructed from spheres"
    script:
        "../measure.py"


rule tabulate_spheres:
    input:
        errors=expand(f"{RESULTS}/spheres/{{part}}.csv", part=SPHERES_PARTS),
    output:
        table=f"{TABLES}/spheres.csv",
        means=f"{TABLES}/spheres_means.csv",
        predictions=f"{TABLES}/spheres_predictions.csv",
    log:
        f"{RESULTS}/logs/tabulate_spheres.log",
    localrule: True
    conda:
        "../../envs/evidence.yaml"
    message:
        "Errors of the interpolant and of the spheres"
    script:
        "../measure.py"
