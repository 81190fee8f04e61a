# docs/recover.md: what a surface recovered from few dots is worth, and other ways to keep it in as many bytes.

RECOVER = f"{OUT}/recover/{{protein}}"
OF_RECOVER = {key: config["recover"][key] for key in ("test_dots", "percents")} | {"seed": config["seed"]}
RECOVERED = list(dict.fromkeys([*NAMES["recover"], config["recover"]["a1"]]))

recover = chains.add(
    "recover",
    config["recover"] | {"structures": [RECOVERED, NAMES["dense"]]},
    scripts=[f"measure_{each}.py" for each in ("recovery", "opponents", "cost", "dense")]
    + ["tabulate_recovery.py"],
    tables=["recover", "recover_floors", "recover_means", "recover_pairs", "recover_opponents"]
    + ["recover_opponents_means", "recover_atoms_means", "recover_where", "recover_where_means"]
    + ["recover_dense", "recover_dense_means", "recover_a1", "recover_cpu"],
)


rule measure_recovery:
    input:
        structure=structure,
    output:
        subsets=f"{RECOVER}/subsets.csv",
        floors=f"{RECOVER}/floors.csv",
    log:
        f"{LOGS}/recover/{{protein}}/measure_recovery.log",
    params:
        **chains.made_by("measure_recovery.py", OF_RECOVER),
    message:
        "Surfaces recovered from subsets of {wildcards.protein}"
    script:
        "../measure_recovery.py"


rule measure_opponents:
    input:
        structure=structure,
    output:
        table=f"{RECOVER}/opponents.csv",
        where=f"{RECOVER}/where.csv",
    log:
        f"{LOGS}/recover/{{protein}}/measure_opponents.log",
    params:
        **chains.made_by("measure_opponents.py", OF_RECOVER | {"percents": config["recover"]["opponents"]}),
    message:
        "Other ways to keep {wildcards.protein} in as many bytes"
    script:
        "../measure_opponents.py"


rule measure_cost:
    input:
        structure=structure,
    output:
        table=f"{RECOVER}/cost.csv",
    log:
        f"{LOGS}/recover/{{protein}}/measure_cost.log",
    params:
        **chains.made_by("measure_cost.py", {"dots": config["recover"]["dots"]}),
    message:
        "Time and memory of recovering"
    script:
        "../measure_cost.py"


rule measure_dense:
    input:
        structure=structure,
    output:
        table=f"{RECOVER}/dense.csv",
    log:
        f"{LOGS}/recover/{{protein}}/measure_dense.log",
    params:
        **chains.made_by("measure_dense.py", config["recover"]["dense"] | {"seed": config["seed"]}),
    message:
        "Subsets of {wildcards.protein} at several densities"
    script:
        "../measure_dense.py"


rule tabulate_recovery:
    input:
        subsets=expand(f"{RECOVER}/subsets.csv", protein=RECOVERED),
        floors=expand(f"{RECOVER}/floors.csv", protein=RECOVERED),
        opponents=expand(f"{RECOVER}/opponents.csv", protein=RECOVERED),
        where=expand(f"{RECOVER}/where.csv", protein=RECOVERED),
        dense=expand(f"{RECOVER}/dense.csv", protein=NAMES["dense"]),
        cost=f"{RECOVER}/cost.csv".format(protein=config["recover"]["a1"]),
    output:
        touch(recover.mark),
        **recover.tables,
    log:
        f"{LOGS}/tabulate_recovery.log",
    localrule: True
    params:
        **chains.made_by("tabulate_recovery.py"),
        a1=config["recover"]["a1"],
        logs=f"{LOGS}/recover",
    message:
        "Tables of recovering"
    script:
        "../tabulate_recovery.py"


drawing = chains.add("recover_figure", {}, scripts=["draw_recovery.py"], figures=["recover"], of=[recover])


rule draw_recovery:
    output:
        touch(drawing.mark),
        **drawing.figures,
    log:
        f"{LOGS}/draw_recovery.log",
    localrule: True
    params:
        **chains.made_by("draw_recovery.py"),
    message:
        "Figure of recovering"
    script:
        "../draw_recovery.py"
