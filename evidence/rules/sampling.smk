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


OF_CENTRES = config["centres"] | {"seed": config["seed"]}
centres = chains.add(
    "centres",
    OF_CENTRES | {"structures": NAMES["coverage"]},
    scripts=["measure_centres.py", "tabulate_centres.py"],
    tables=["centres", "centres_means", "centres_cpu"],
)


rule measure_centres:
    input:
        **{key: f"{POOLED}/{key}.csv" for key in ("roughness", "grid", "ranges")},
        surface=f"{POOLED}/surface.npz",
    output:
        table=f"{OUT}/centres/{{protein}}.csv",
    log:
        f"{LOGS}/centres/{{protein}}/measure_centres.log",
    params:
        **chains.made_by("measure_centres.py", OF_CENTRES),
    message:
        "What the centres of patches give on {wildcards.protein}"
    script:
        "../measure_centres.py"


rule tabulate_centres:
    input:
        tables=expand(f"{OUT}/centres/{{protein}}.csv", protein=NAMES["coverage"]),
    output:
        touch(centres.mark),
        **centres.tables,
    log:
        f"{LOGS}/tabulate_centres.log",
    localrule: True
    params:
        **chains.made_by("tabulate_centres.py"),
        logs=f"{LOGS}/centres",
    message:
        "Tables of the centres"
    script:
        "../tabulate_centres.py"


drawn_centres = chains.add(
    "centres_figure", {}, scripts=["draw_centres.py"], figures=["centres"], of=[centres]
)


rule draw_centres:
    input:
        **{name: ancient(path) for name, path in centres.tables.items()},
    output:
        touch(drawn_centres.mark),
        **drawn_centres.figures,
    log:
        f"{LOGS}/draw_centres.log",
    localrule: True
    params:
        **chains.made_by("draw_centres.py"),
    message:
        "Figure of the centres"
    script:
        "../draw_centres.py"
