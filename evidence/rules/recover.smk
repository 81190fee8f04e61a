# docs/recover.md: the quality of surfaces recovered from few dots, and other ways to store a surface in as many bytes.

A1 = config["recover"]["a1"]
RECOVERED = list(dict.fromkeys([*names_in_set(STRUCTURES, "recover"), A1]))


rule measure_recovery:
    input:
        structure=ancient(structure),
    output:
        subsets=f"{RESULTS}/recover/{{protein}}/subsets.csv",
        floors=f"{RESULTS}/recover/{{protein}}/floors.csv",
    log:
        f"{RESULTS}/logs/recover/{{protein}}/measure_recovery.log",
    params:
        percents=config["recover"]["percents"],
        test_dots=config["recover"]["test_dots"],
        seed=config["seed"],
    message:
        "Surfaces recovered from subsets of {wildcards.protein}"
    script:
        "../measure_recovery.py"


rule measure_cost:
    input:
        structure=ancient(structure),
    output:
        table=f"{RESULTS}/recover/{{protein}}/cost.csv",
    log:
        f"{RESULTS}/logs/recover/{{protein}}/measure_cost.log",
    params:
        dots=config["recover"]["dots"],
    message:
        "Time and memory of recovering"
    script:
        "../measure_cost.py"


rule tabulate_recovery:
    input:
        subsets=expand(f"{RESULTS}/recover/{{protein}}/subsets.csv", protein=RECOVERED),
        floors=expand(f"{RESULTS}/recover/{{protein}}/floors.csv", protein=RECOVERED),
        cost=f"{RESULTS}/recover/{A1}/cost.csv",
    output:
        recover=f"{TABLES}/recover.csv",
        recover_floors=f"{TABLES}/recover_floors.csv",
        recover_means=f"{TABLES}/recover_means.csv",
        recover_pairs=f"{TABLES}/recover_pairs.csv",
        recover_a1=f"{TABLES}/recover_a1.csv",
        recover_cpu=f"{TABLES}/recover_cpu.csv",
    log:
        f"{RESULTS}/logs/tabulate_recovery.log",
    localrule: True
    params:
        a1=A1,
        logs=f"{RESULTS}/logs/recover",
    message:
        "Tables of recovered surfaces"
    script:
        "../tabulate_recovery.py"


rule draw_recovery:
    input:
        structure=ancient("data/tdp43/topology.pdb"),
    output:
        figure=f"{FIGURES}/recover.png",
    log:
        f"{RESULTS}/logs/draw_recovery.log",
    localrule: True
    message:
        "Figure of a recovered surface"
    script:
        "../draw_recovery.py"


rule measure_opponents:
    input:
        structure=ancient(structure),
    output:
        table=f"{RESULTS}/recover/{{protein}}/opponents.csv",
        where=f"{RESULTS}/recover/{{protein}}/where.csv",
    log:
        f"{RESULTS}/logs/opponents/{{protein}}/measure_opponents.log",
    params:
        percents=config["recover"]["opponents"],
        test_dots=config["recover"]["test_dots"],
        seed=config["seed"],
    message:
        "Other ways to store {wildcards.protein} in as many bytes"
    script:
        "../measure_opponents.py"


rule tabulate_opponents:
    input:
        opponents=expand(
            f"{RESULTS}/recover/{{protein}}/opponents.csv",
            protein=names_in_set(STRUCTURES, "opponents"),
        ),
        where=expand(
            f"{RESULTS}/recover/{{protein}}/where.csv",
            protein=names_in_set(STRUCTURES, "opponents"),
        ),
    output:
        recover_opponents=f"{TABLES}/recover_opponents.csv",
        recover_opponents_means=f"{TABLES}/recover_opponents_means.csv",
        recover_opponents_pairs=f"{TABLES}/recover_opponents_pairs.csv",
        recover_atoms_means=f"{TABLES}/recover_atoms_means.csv",
        recover_where=f"{TABLES}/recover_where.csv",
        recover_where_means=f"{TABLES}/recover_where_means.csv",
        opponents_cpu=f"{TABLES}/opponents_cpu.csv",
    log:
        f"{RESULTS}/logs/tabulate_opponents.log",
    localrule: True
    params:
        logs=f"{RESULTS}/logs/opponents",
    message:
        "Tables of other ways to store a surface"
    script:
        "../tabulate_opponents.py"


rule measure_dense:
    input:
        structure=ancient(structure),
    output:
        table=f"{RESULTS}/recover/{{protein}}/dense.csv",
    log:
        f"{RESULTS}/logs/dense/{{protein}}/measure_dense.log",
    params:
        densities=config["recover"]["dense"]["densities"],
        test_dots=config["recover"]["dense"]["test_dots"],
        seed=config["seed"],
    message:
        "Minimal subsets of {wildcards.protein} at several densities"
    script:
        "../measure_dense.py"


rule tabulate_dense:
    input:
        tables=expand(
            f"{RESULTS}/recover/{{protein}}/dense.csv",
            protein=names_in_set(STRUCTURES, "dense"),
        ),
    output:
        recover_dense=f"{TABLES}/recover_dense.csv",
        recover_dense_means=f"{TABLES}/recover_dense_means.csv",
        dense_cpu=f"{TABLES}/dense_cpu.csv",
    log:
        f"{RESULTS}/logs/tabulate_dense.log",
    localrule: True
    params:
        logs=f"{RESULTS}/logs/dense",
    message:
        "Tables of dense surfaces"
    script:
        "../tabulate_dense.py"
