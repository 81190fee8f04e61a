# docs/recover.md: the quality of surfaces recovered from few dots, and other ways to store a surface in as many bytes.


rule measure_opponents:
    input:
        structure=ancient(structure),
    output:
        table=f"{RESULTS}/recover/{{protein}}/opponents.csv",
    log:
        f"{RESULTS}/logs/opponents/{{protein}}/measure_opponents.log",
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
    message:
        "Figure of a recovered surface"
    script:
        "../measure.py"
