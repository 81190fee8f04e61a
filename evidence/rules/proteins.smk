# docs/proteins.md: what holds over many proteins, from studies of them.

OF_STUDY = [  # choose_frames.py counts by what it writes, see read_structures.py
    *("../scripts/make_surface.py", "../scripts/measure_roughness.py", "../scripts/measure_floors.py"),
    *("../scripts/evaluate_grid.py", "../scripts/tabulate_best.py"),
    *("../scripts/compare_samplers.py", "../scripts/summarise_run.py"),
]
proteins = chains.add(
    "proteins",
    {study: STUDIES[study] for study in ("proteins", "recovered", "whole")},
    scripts=[*OF_STUDY, "tabulate_proteins.py"],
    tables=["proteins_d", "proteins_plateaus", "proteins_enough", "proteins_enough_means"]
    + ["proteins_needed_means", "proteins_by_n_s", "proteins_correlations", "proteins_power"]
    + ["proteins_coverage", "proteins_recovered", "proteins_recovered_whole", "proteins_cpu"],
)
RECOMMENDATION = {
    key: f"{config['recommendation']}/{key}.csv.gz" for key in ("summary", "relation", "surfaces")
}


rule tabulate_proteins:
    input:
        outcome("proteins", ["summary.csv", "relation.csv", "surfaces.csv"], COMPARED),
        outcome("recovered", [], COMPARED[:-1]),
        outcome("whole", [], COMPARED[:-1]),
    output:
        touch(proteins.mark),
        **proteins.tables,
        **RECOMMENDATION,
    log:
        f"{LOGS}/tabulate_proteins.log",
    params:
        **chains.made_by("tabulate_proteins.py"),
        runs={study: place(study) for study in ("proteins", "recovered", "whole")},
        hydrogens=HYDROGENS,
    message:
        "Tables over many proteins"
    script:
        "../tabulate_proteins.py"


variants = chains.add(
    "variants",
    {study: STUDIES[study] for study in OF_VARIANTS.values()},
    scripts=[*OF_STUDY, "tabulate_variants.py"],
    tables=["proteins_variants", "variants_cpu"],
)


rule tabulate_variants:
    input:
        [outcome(study, [], COMPARED) for study in OF_VARIANTS.values()],
    output:
        touch(variants.mark),
        **variants.tables,
    log:
        f"{LOGS}/tabulate_variants.log",
    params:
        **chains.made_by("tabulate_variants.py"),
        runs={variant: place(study) for variant, study in OF_VARIANTS.items()},
    message:
        "Which claim rests on which rule"
    script:
        "../tabulate_variants.py"


drawn_proteins = chains.add(
    "proteins_figures",
    {},
    scripts=["draw_proteins.py"],
    figures=["proteins_d", "proteins_roughness", "proteins_enough", "proteins_needed"],
    of=[proteins],
)


rule draw_proteins:
    input:
        **{name: ancient(path) for name, path in (proteins.tables | RECOMMENDATION).items()},
    output:
        touch(drawn_proteins.mark),
        **drawn_proteins.figures,
    log:
        f"{LOGS}/draw_proteins.log",
    localrule: True
    params:
        **chains.made_by("draw_proteins.py"),
    message:
        "Figures over many proteins"
    script:
        "../draw_proteins.py"
