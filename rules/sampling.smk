# The paper's sampling over the grid of its parameters, and the best of it, where `sampling` is not false.

# The figures of a conformation: src/sparsurf/report/figures/<name>.py, captioned in src/sparsurf/report/captions/<name>.rst
FIGURES = {
    "enough": "How many dots are enough",
    "roughness": "Fig. 1, roughness",
    "number_of_dots": "Fig. 2, number of dots",
    "number_of_dots_panels": "Fig. 2, all panels",
    "d_over_grid": "Fig. 3, d over the grid",
    "rough_and_flat": "Fig. 4, rough and flat patches",
    "subsets": "Fig. 5, surfaces",
}
OF_FIGURES = ["patches", *defects, "evaluation.test_dots", "minimal", "seed"]
DISTANCES = inside(CONFORMATION, distances="distances.npz")


rule evaluate_grid:
    input:
        **ROUGH_SURFACE,
    output:
        **(GRID | DISTANCES),
    log:
        f"{CONFORMATION_LOGS}/evaluate_grid.log",
    priority: 2  # before what only follows from them
    threads: files.side_by_side(THREADS, workflow.resource_settings.cores if HERE else None)
    resources:
        **needs("evaluate_grid", files.dots, besides=files.distances),
    params:
        **made_by("evaluate_grid.py", "patches", "sampling", "evaluation", "seed"),
    message:
        "Sampling and comparing {wildcards.protein}/{wildcards.conformation} over the grid"
    script:
        "../scripts/evaluate_grid.py"


rule tabulate_best:
    input:
        **(GRID | DISTANCES | FLOORS),
    output:
        **inside(CONFORMATION, best="best.json", markdown="ranges.md", page="ranges.html"),
        ranges=of_each(f"{CONFORMATION}/ranges.csv", "Best combination per range of n_S", "ranges"),
    log:
        f"{CONFORMATION_LOGS}/tabulate_best.log",
    resources:
        **needs("tabulate_best", files.dots, besides=files.distances),
    params:
        **made_by("tabulate_best.py", "tables"),
    message:
        "Best combinations of {wildcards.protein}/{wildcards.conformation}"
    script:
        "../scripts/tabulate_best.py"


rule draw_figures:
    input:
        **(ROUGH_SURFACE | GRID | BEST | FLOORS | ENOUGH | MINIMAL),
    output:
        **{name: of_each(f"{CONFORMATION}/figures/{name}.png", FIGURES[name], name) for name in FIGURES},
        **inside(CONFORMATION, bins="rough_and_flat.csv"),
        svgs=[f"{CONFORMATION}/figures/{name}.svg" for name in FIGURES],
    log:
        f"{CONFORMATION_LOGS}/draw_figures.log",
    resources:
        **needs("draw_figures", files.dots),
    params:
        **made_by("draw_figures.py", *OF_FIGURES, figures=FIGURES),
    message:
        "Figures of {wildcards.protein}/{wildcards.conformation}"
    script:
        "../scripts/draw_figures.py"
