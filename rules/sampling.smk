# The paper's sampling over the grid of its parameters, and the best of it. `sampling: false` leaves all of this out,
# for the study or for one protein.


rule evaluate_grid:
    input:
        surface="results/{run}/{protein}/{conformation}/surface.npz",
        roughness="results/{run}/{protein}/{conformation}/roughness.csv",
    output:
        grid="results/{run}/{protein}/{conformation}/grid.csv",
        distances="results/{run}/{protein}/{conformation}/distances.npz",
    log:
        "results/{run}/logs/{protein}/{conformation}/evaluate_grid.log",
    priority: 2  # It runs before what only follows from it.
    conda:
        "../envs/study.yaml"
    threads: GRID_THREADS
    resources:
        mem_mb=lambda wildcards, input, attempt: attempt * (1000 + 1.5 * GRID_MB + 200 * input.size_mb),
        runtime=lambda wildcards, input, attempt: attempt * (10 + 5 * input.size_mb),
    params:
        patches=config["patches"],
        sampling=config["sampling"],
        evaluation=config["evaluation"],
        seed=config["seed"],
        code=CODE["numbers"],
    message:
        "Sampling and comparing {wildcards.protein}/{wildcards.conformation} over the grid"
    script:
        "../scripts/evaluate_grid.py"


rule tabulate_best:
    input:
        surface="results/{run}/{protein}/{conformation}/surface.npz",
        roughness="results/{run}/{protein}/{conformation}/roughness.csv",
        grid="results/{run}/{protein}/{conformation}/grid.csv",
        distances="results/{run}/{protein}/{conformation}/distances.npz",
        floors="results/{run}/{protein}/{conformation}/floors.csv",
    output:
        ranges=in_report("results/{run}/{protein}/{conformation}/ranges.csv"),
        best="results/{run}/{protein}/{conformation}/best.json",
        winners="results/{run}/{protein}/{conformation}/winners.npz",
    log:
        "results/{run}/logs/{protein}/{conformation}/tabulate_best.log",
    conda:
        "../envs/study.yaml"
    resources:
        mem_mb=lambda wildcards, input, attempt: attempt * (1000 + 1.5 * GRID_MB),
    params:
        patches=config["patches"],
        sampling=config["sampling"],
        evaluation=config["evaluation"],
        seed=config["seed"],
        ranges=config["tables"]["ranges"],
        max_n_s_percent=config["tables"]["max_n_S_percent"],
        code=CODE["numbers"],
    message:
        "Best combinations of {wildcards.protein}/{wildcards.conformation}"
    script:
        "../scripts/tabulate_best.py"


rule draw_figures:
    input:
        surface="results/{run}/{protein}/{conformation}/surface.npz",
        roughness="results/{run}/{protein}/{conformation}/roughness.csv",
        grid="results/{run}/{protein}/{conformation}/grid.csv",
        best="results/{run}/{protein}/{conformation}/best.json",
        minimal="results/{run}/{protein}/{conformation}/minimal.csv",
        recovered="results/{run}/{protein}/{conformation}/recovered.csv",
        reconstructed="results/{run}/{protein}/{conformation}/reconstructed.npz",
    output:
        required_dots=in_report("results/{run}/{protein}/{conformation}/figures/required_dots.png"),
        number_of_dots=in_report("results/{run}/{protein}/{conformation}/figures/number_of_dots.png"),
        d_over_grid=in_report("results/{run}/{protein}/{conformation}/figures/d_over_grid.png"),
        rough_and_flat=in_report("results/{run}/{protein}/{conformation}/figures/rough_and_flat.png"),
        subsets=in_report("results/{run}/{protein}/{conformation}/figures/subsets.png"),
        number_of_dots_svg="results/{run}/{protein}/{conformation}/figures/number_of_dots.svg",
        required_dots_svg="results/{run}/{protein}/{conformation}/figures/required_dots.svg",
        d_over_grid_svg="results/{run}/{protein}/{conformation}/figures/d_over_grid.svg",
        rough_and_flat_svg="results/{run}/{protein}/{conformation}/figures/rough_and_flat.svg",
        subsets_svg="results/{run}/{protein}/{conformation}/figures/subsets.svg",
        picture_sampled="results/{run}/{protein}/{conformation}/pictures/sampled.png",
        picture_minimal="results/{run}/{protein}/{conformation}/pictures/minimal.png",
        bins="results/{run}/{protein}/{conformation}/rough_and_flat.csv",
    log:
        "results/{run}/logs/{protein}/{conformation}/draw_figures.log",
    conda:
        "../envs/study.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 1500,
    params:
        patches=config["patches"],
        sampling=part_of("sampling", *RULES_OF_SAMPLING),
        evaluation=part_of("evaluation", "test_dots"),
        minimal=config["minimal"],
        seed=config["seed"],
        code=CODE["pages"],
    message:
        "Figures of {wildcards.protein}/{wildcards.conformation}"
    script:
        "../scripts/draw_figures.py"


rule summarise_best:
    input:
        ranges=every_conformation("ranges.csv", SAMPLED),
        best=every_conformation("best.json", SAMPLED),
        grid=every_conformation("grid.csv", SAMPLED),
        surfaces=every_conformation("surface.npz", SAMPLED),
        roughness=every_conformation("roughness.csv", SAMPLED),
    output:
        summary=in_report("results/{run}/summary.csv"),
        relation="results/{run}/relation.csv",
    log:
        "results/{run}/logs/summarise_best.log",
    conda:
        "../envs/study.yaml"
    resources:
        mem_mb=lambda wildcards, input, attempt: attempt * (1000 + 10 * input.size_mb),
    params:
        seed=config["seed"],
        code=CODE["pages"],
    message:
        "Best parameters of all surfaces"
    script:
        "../scripts/summarise_best.py"
