# Samplers side by side at equal n_S, where `compare` or `make compare` asks for it.


rule compare_samplers:
    input:
        **(ROUGH_SURFACE | GRID | RANGES | FLOORS),
        structure=files.structure,
    output:
        **inside(CONFORMATION, table="compare.csv", page="compare.html", pairs="compare_pairs.csv"),
        **inside(CONFORMATION, fewer="compare_fewer.csv", alone="compare_alone.csv"),
        **inside(CONFORMATION, needed="needed.csv", centres="centres.csv"),
        **figure(f"{CONFORMATION}/figures/compare", "Samplers compared", "compare"),
    log:
        f"{CONFORMATION_LOGS}/compare_samplers.log",
    threads: THREADS
    resources:
        **needs("compare_samplers", files.dots),
    params:
        **made_by("compare_samplers.py", "surface", "patches", "sampling", "evaluation", "compare", "seed"),
    message:
        "Comparing samplers on {wildcards.protein}/{wildcards.conformation}"
    script:
        "../scripts/compare_samplers.py"


rule summarise_comparison:
    input:
        tables=files.every("compare.csv"),
    output:
        **inside(RUN, table="compare.csv", needed="compare_needed.csv", page="compare.html"),
        **figure(f"{RUN}/compare", "Over all proteins", "compare", "Samplers compared"),
    log:
        f"{LOGS}/summarise_comparison.log",
    localrule: True
    params:
        **made_by("summarise_comparison.py"),
    message:
        "Comparing samplers over all conformations and proteins"
    script:
        "../scripts/summarise_comparison.py"
