# Samplers compared at equal n_S, where `compare` or `make compare` asks for it.


rule compare_samplers:
    input:
        surface="results/{run}/{protein}/{conformation}/surface.npz",
        roughness="results/{run}/{protein}/{conformation}/roughness.csv",
        ranges="results/{run}/{protein}/{conformation}/ranges.csv",
        floors="results/{run}/{protein}/{conformation}/floors.csv",
        structure=structure_of_conformation,
    output:
        table="results/{run}/{protein}/{conformation}/compare.csv",
        png=in_report("results/{run}/{protein}/{conformation}/figures/compare.png"),
    log:
        "results/{run}/logs/{protein}/{conformation}/compare_samplers.log",
    conda:
        "../envs/study.yaml"
    threads: 8
    resources:
        mem_mb=lambda wildcards, input, attempt: attempt * (1000 + 50 * input.size_mb),
        runtime=lambda wildcards, input, attempt: attempt * (10 + 6 * input.size_mb),
    params:
        surface=part_of("surface", "probe_radius", "radii", "reentrant", "cavities"),
        patches=config["patches"],
        sampling=part_of("sampling", *RULES_OF_SAMPLING),
        evaluation=config["evaluation"],
        percents=config["compare"]["percents"],
        samplers=config["compare"].get("samplers"),
        seed=config["seed"],
        title=title_of_page,
        code=CODE["pages"],
    message:
        "Comparing samplers on {wildcards.protein}/{wildcards.conformation}"
    script:
        "../scripts/compare_samplers.py"


rule summarise_comparison:
    input:
        tables=every_conformation("compare.csv", SAMPLED),
    output:
        table="results/{run}/compare.csv",
        png=in_report("results/{run}/compare.png"),
    log:
        "results/{run}/logs/summarise_comparison.log",
    localrule: True
    conda:
        "../envs/study.yaml"
    params:
        code=CODE["pages"],
    message:
        "Comparing samplers over all conformations and proteins"
    script:
        "../scripts/summarise_comparison.py"
