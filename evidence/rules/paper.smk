# docs/paper.md, and the README's figures: the paper's tables beside ours, and which wrong rules the test of its Table I would notice.

OF_PAPER = {
    f"paper_{key}": f"results/{STUDIES['paper']['run']}/paper_{key}.csv"
    for key in ("rows", "places", "tests")
}
OF_PAPER["default_ranges"] = f"results/{STUDIES['default']['run']}/{config['example']}/ranges.csv"
PICTURES = {
    "enough": f"results/{STUDIES['default']['run']}/{config['example']}/figures/enough.png",
    "table1": f"results/{STUDIES['paper']['run']}/table1.png",
}

paper = chains.add(
    "paper",
    {study: STUDIES[study] for study in ("paper", "default")},
    scripts=[*OF_STUDY, "../scripts/reproduce_paper.py"],
    tables=list(OF_PAPER),
    figures=list(PICTURES),
)


rule store_paper:
    input:
        **{f"of_{name}": path for name, path in (OF_PAPER | PICTURES).items()},
    output:
        touch(paper.mark),
        **paper.tables,
        **paper.figures,
    log:
        f"{LOGS}/store_paper.log",
    localrule: True
    message:
        "Tables and the two figures of the README, of the default study and of the paper's"
    shell:
        "; ".join(f"cp {{input.of_{name}}} {{output.{name}}}" for name in OF_PAPER | PICTURES)


POWER = config["power"]
OF_RUNS = {key: POWER[key] for key in ("surface", "patches", "sampling")} | {"seed": config["seed"]}
RULES = POWER["rules"]

power = chains.add(
    "power",
    POWER,
    scripts=["measure_power.py", "tabulate_power.py"],
    tables=["power", "power_cpu"],
)


rule measure_power:
    input:
        structure=source.path(POWER["a1"]),
    output:
        table=f"{OUT}/power/{{variant}}.csv",
    log:
        f"{LOGS}/power/{{variant}}.log",
    wildcard_constraints:
        variant=one_of([POWER["reference"], *RULES]),
    threads: 2
    params:
        **chains.made_by("measure_power.py"),
        settings=lambda wildcards: OF_RUNS
        | {
            "rules": RULES.get(wildcards.variant, {}),
            "runs": POWER["runs" if wildcards.variant in RULES else "reference_runs"],
        },
        variant="{variant}",
    message:
        "Table I with {wildcards.variant}"
    script:
        "../measure_power.py"


rule tabulate_power:
    input:
        reference=f"{OUT}/power/{POWER['reference']}.csv",
        others=expand(f"{OUT}/power/{{variant}}.csv", variant=RULES),
    output:
        touch(power.mark),
        **power.tables,
    log:
        f"{LOGS}/tabulate_power.log",
    localrule: True
    params:
        **chains.made_by("tabulate_power.py"),
        logs=f"{LOGS}/power",
    message:
        "What the test of Table I can notice"
    script:
        "../tabulate_power.py"
