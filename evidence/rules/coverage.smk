# docs/coverage.md: how often the intervals of a study hold the truth, on surfaces of the study over many proteins.

COVER = config["coverage"]
POOLED = f"results/{STUDIES['proteins']['run']}/{{protein}}/c1"

covered = chains.add(
    "coverage",
    {key: COVER[key] for key in COVER if key != "drawn"} | {"structures": NAMES["coverage"]},
    scripts=["pool_draws.py", "measure_coverage.py", "tabulate_coverage.py"],
    tables=["coverage", "coverage_surfaces", "coverage_designs", "coverage_cpu"],
)


rule pool_draws:
    input:
        surface=f"{POOLED}/surface.npz",
        roughness=f"{POOLED}/roughness.csv",
        grid=f"{POOLED}/grid.csv",
    output:
        pool=f"{OUT}/coverage/{{protein}}/pool.npz",
    log:
        f"{LOGS}/coverage/{{protein}}/pool_draws.log",
    threads: 2
    params:
        **chains.made_by("pool_draws.py", COVER["pool"]),
    message:
        "Many draws of the best combinations on {wildcards.protein}"
    script:
        "../pool_draws.py"


rule measure_coverage:
    input:
        pool=f"{OUT}/coverage/{{protein}}/pool.npz",
    output:
        table=f"{OUT}/coverage/{{protein}}/coverage.csv",
    log:
        f"{LOGS}/coverage/{{protein}}/measure_coverage.log",
    params:
        **chains.made_by(
            "measure_coverage.py",
            {key: COVER[key] for key in ("replicates", "designs", "default")},
        ),
    message:
        "How often intervals hold the truth on {wildcards.protein}"
    script:
        "../measure_coverage.py"


rule tabulate_coverage:
    input:
        tables=expand(f"{OUT}/coverage/{{protein}}/coverage.csv", protein=NAMES["coverage"]),
    output:
        touch(covered.mark),
        **covered.tables,
    log:
        f"{LOGS}/tabulate_coverage.log",
    localrule: True
    params:
        **chains.made_by("tabulate_coverage.py"),
        logs=f"{LOGS}/coverage",
    message:
        "Tables of coverage"
    script:
        "../tabulate_coverage.py"


OF_INTERVALS = {"drawn": COVER["drawn"], "seed": config["seed"]}
intervals = chains.add(
    "intervals",
    OF_INTERVALS,
    scripts=["tabulate_intervals.py"],
    tables=["coverage_means"],
    of=[recover, proteins],
)


rule tabulate_intervals:
    input:
        recover=ancient(recover.tables["recover"]),
        enough=ancient(proteins.tables["proteins_enough"]),
    output:
        touch(intervals.mark),
        **intervals.tables,
    log:
        f"{LOGS}/tabulate_intervals.log",
    localrule: True
    params:
        **chains.made_by("tabulate_intervals.py", OF_INTERVALS),
    message:
        "How often intervals of means over few structures hold"
    script:
        "../tabulate_intervals.py"
