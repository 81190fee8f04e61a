# docs/descriptors.md: how far position and dots move each descriptor, and what each makes of the paper's tables.

DESCRIBED = ("changes", "linked", "orders", "rows", "samplers", "grid")
OF_DESCRIPTORS = config["descriptors"] | {"seed": config["seed"]}

described = chains.add(
    "descriptors",
    OF_DESCRIPTORS | {"structures": NAMES["descriptors"]},
    scripts=["measure_descriptors.py", "tabulate_descriptors.py"],
    tables=[
        f"descriptors_{key}"
        for key in (*DESCRIBED, "cpu", *(f"{each}_means" for each in ("changes", "linked", "orders", "grid")))
    ],
)


rule measure_descriptors:
    input:
        structure=structure,
    output:
        **{key: f"{OUT}/descriptors/{{protein}}/{key}.csv" for key in DESCRIBED},
    log:
        f"{LOGS}/descriptors/{{protein}}/measure_descriptors.log",
    params:
        **chains.made_by("measure_descriptors.py", OF_DESCRIPTORS),
    message:
        "Descriptors of {wildcards.protein}, turned and with fresh dots"
    script:
        "../measure_descriptors.py"


rule tabulate_descriptors:
    input:
        **{
            key: expand(f"{OUT}/descriptors/{{protein}}/{key}.csv", protein=NAMES["descriptors"])
            for key in DESCRIBED
        },
    output:
        touch(described.mark),
        **described.tables,
    log:
        f"{LOGS}/tabulate_descriptors.log",
    localrule: True
    params:
        **chains.made_by("tabulate_descriptors.py"),
        logs=f"{LOGS}/descriptors",
    message:
        "Tables of the descriptors"
    script:
        "../tabulate_descriptors.py"


drawn_descriptors = chains.add(
    "descriptors_figures",
    {},
    scripts=["draw_descriptors.py"],
    figures=["descriptors_steadiness", "descriptors_samplers"],
    of=[described],
)


rule draw_descriptors:
    input:
        **{name: ancient(path) for name, path in described.tables.items()},
    output:
        touch(drawn_descriptors.mark),
        **drawn_descriptors.figures,
    log:
        f"{LOGS}/draw_descriptors.log",
    localrule: True
    params:
        **chains.made_by("draw_descriptors.py"),
    message:
        "Figures of the descriptors"
    script:
        "../draw_descriptors.py"
