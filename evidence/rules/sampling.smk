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


OF_CENTRES = {study: own | {"seed": config["seed"]} for study, own in config["centres"].items()}
centres = chains.add(
    "centres",
    OF_CENTRES | {"structures": NAMES["coverage"]},
    scripts=["measure_centres.py", "tabulate_centres.py"],
    tables=["centres", "centres_means", "centres_cpu"],
)


def of_surface(wildcards):
    """What a study made of a protein."""
    files = ("surface.npz", "roughness.csv", "grid.csv", "ranges.csv")
    run = STUDIES[wildcards.study]["run"]
    return {file.split(".")[0]: f"results/{run}/{wildcards.protein}/c1/{file}" for file in files}


rule measure_centres:
    input:
        unpack(of_surface),
    output:
        table=f"{OUT}/centres/{{study}}/{{protein}}.csv",
    log:
        f"{LOGS}/centres/{{study}}/{{protein}}/measure_centres.log",
    wildcard_constraints:
        study=one_of(OF_CENTRES),
    params:
        **chains.made_by("measure_centres.py"),
        settings=lambda wildcards: OF_CENTRES[wildcards.study],
    message:
        "What the centres of patches give on {wildcards.protein}, {wildcards.study}"
    script:
        "../measure_centres.py"


rule tabulate_centres:
    input:
        tables=expand(f"{OUT}/centres/{{study}}/{{protein}}.csv", study=OF_CENTRES, protein=NAMES["coverage"]),
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
