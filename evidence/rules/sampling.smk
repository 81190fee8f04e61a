# docs/sampling.md: why sampling by roughness does not pay.

OF_EXPONENTS = config["exponents"] | {"seed": config["seed"]}

exponents = chains.add(
    "exponents",
    OF_EXPONENTS | {"structures": NAMES["exponents"]},
    scripts=["measure_exponents.py", "tabulate_exponents.py"],
    tables=["exponents", "exponents_means", "exponents_best", "exponents_cpu"],
)


rule measure_exponents:
    input:
        structure=structure,
    output:
        table=f"{OUT}/exponents/{{protein}}.csv",
    log:
        f"{LOGS}/exponents/{{protein}}/measure_exponents.log",
    params:
        **chains.made_by("measure_exponents.py", OF_EXPONENTS),
    message:
        "Dots denser where {wildcards.protein} is rough"
    script:
        "../measure_exponents.py"


rule tabulate_exponents:
    input:
        tables=expand(f"{OUT}/exponents/{{protein}}.csv", protein=NAMES["exponents"]),
    output:
        touch(exponents.mark),
        **exponents.tables,
    log:
        f"{LOGS}/tabulate_exponents.log",
    localrule: True
    params:
        **chains.made_by("tabulate_exponents.py"),
        logs=f"{LOGS}/exponents",
    message:
        "Tables of the exponent"
    script:
        "../tabulate_exponents.py"


drawn_exponents = chains.add(
    "exponents_figure", {}, scripts=["draw_exponents.py"], figures=["exponents"], of=[exponents]
)


rule draw_exponents:
    input:
        **{name: ancient(path) for name, path in exponents.tables.items()},
    output:
        touch(drawn_exponents.mark),
        **drawn_exponents.figures,
    log:
        f"{LOGS}/draw_exponents.log",
    localrule: True
    params:
        **chains.made_by("draw_exponents.py"),
    message:
        "Figure of the exponent"
    script:
        "../draw_exponents.py"
