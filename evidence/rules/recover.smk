# docs/recover.md: what a surface recovered from few dots is worth, and other ways to keep it in as many bytes.

RECOVER = f"{OUT}/recover/{{protein}}"
OF_RECOVER = {key: config["recover"][key] for key in ("test_dots", "percents")} | {"seed": config["seed"]}
RECOVERED = list(dict.fromkeys([*NAMES["recover"], config["recover"]["a1"]]))

recover = chains.add(
    "recover",
    OF_RECOVER | {"dots": config["recover"]["dots"], "structures": RECOVERED},
    scripts=["measure_recovery.py", "measure_cost.py", "tabulate_recovery.py"],
    tables=["recover", "recover_floors", "recover_means", "recover_pairs", "recover_a1", "recover_cpu"],
)
OF_OPPONENTS = OF_RECOVER | {"percents": config["recover"]["opponents"]}
opponents = chains.add(
    "opponents",
    OF_OPPONENTS | {"structures": NAMES["opponents"]},
    scripts=["measure_opponents.py", "tabulate_opponents.py"],
    tables=["recover_opponents", "recover_opponents_means", "recover_opponents_pairs"]
    + ["recover_atoms_means", "recover_where", "recover_where_means", "opponents_cpu"],
)
OF_DENSE = config["recover"]["dense"] | {"seed": config["seed"]}
dense = chains.add(
    "dense",
    OF_DENSE | {"structures": NAMES["dense"]},
    scripts=["measure_dense.py", "tabulate_dense.py"],
    tables=["recover_dense", "recover_dense_means", "dense_cpu"],
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
        f"{LOGS}/opponents/{{protein}}/measure_opponents.log",
    params:
        **chains.made_by("measure_opponents.py", OF_OPPONENTS),
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
        f"{LOGS}/dense/{{protein}}/measure_dense.log",
    params:
        **chains.made_by("measure_dense.py", OF_DENSE),
    message:
        "Subsets of {wildcards.protein} at several densities"
    script:
        "../measure_dense.py"


rule tabulate_recovery:
    input:
        subsets=expand(f"{RECOVER}/subsets.csv", protein=RECOVERED),
        floors=expand(f"{RECOVER}/floors.csv", protein=RECOVERED),
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


rule tabulate_opponents:
    input:
        opponents=expand(f"{RECOVER}/opponents.csv", protein=NAMES["opponents"]),
        where=expand(f"{RECOVER}/where.csv", protein=NAMES["opponents"]),
    output:
        touch(opponents.mark),
        **opponents.tables,
    log:
        f"{LOGS}/tabulate_opponents.log",
    localrule: True
    params:
        **chains.made_by("tabulate_opponents.py"),
        logs=f"{LOGS}/opponents",
    message:
        "Tables of other ways to keep a surface"
    script:
        "../tabulate_opponents.py"


rule tabulate_dense:
    input:
        tables=expand(f"{RECOVER}/dense.csv", protein=NAMES["dense"]),
    output:
        touch(dense.mark),
        **dense.tables,
    log:
        f"{LOGS}/tabulate_dense.log",
    localrule: True
    params:
        **chains.made_by("tabulate_dense.py"),
        logs=f"{LOGS}/dense",
    message:
        "Tables of dense surfaces"
    script:
        "../tabulate_dense.py"


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
