# docs/proteins.md: what holds over many proteins, from studies of them (studies.smk).


rule tabulate_proteins:
    input:
        summary=f"{RESULTS}_proteins/summary.csv",
        relation=f"{RESULTS}_proteins/relation.csv",
        surfaces=f"{RESULTS}_proteins/surfaces.csv",
        grids=expand(f"{RESULTS}_proteins/{{protein}}/c1/grid.csv", protein=MANY_PROTEINS),
        ranges=expand(f"{RESULTS}_proteins/{{protein}}/c1/ranges.csv", protein=MANY_PROTEINS),
        best=expand(f"{RESULTS}_proteins/{{protein}}/c1/best.json", protein=MANY_PROTEINS),
        floors=expand(f"{RESULTS}_proteins/{{protein}}/c1/floors.csv", protein=MANY_PROTEINS),
        compared=expand(f"{RESULTS}_proteins/{{protein}}/c1/compare.csv", protein=MANY_PROTEINS),
        recovered=expand(
            f"{RESULTS}_recovered/{{protein}}/c1/{{file}}",
            protein=RECOVERED_GRID,
            file=["grid.csv", "ranges.csv", "best.json", "floors.csv"],
        ),
        recovered_whole=expand(
            f"{RESULTS}_whole/{{protein}}/c1/{{file}}",
            protein=RECOVERED_WHOLE_GRID,
            file=["grid.csv", "ranges.csv", "best.json", "floors.csv"],
        ),
    output:
        d=f"{TABLES}/proteins_d.csv",
        plateaus=f"{TABLES}/proteins_plateaus.csv",
        needed_means=f"{TABLES}/proteins_needed_means.csv",
        by_n_s=f"{TABLES}/proteins_by_n_s.csv",
        correlations=f"{TABLES}/proteins_correlations.csv",
        power=f"{TABLES}/proteins_power.csv",
        coverage=f"{TABLES}/proteins_coverage.csv",
        recovered=f"{TABLES}/proteins_recovered.csv",
        recovered_whole=f"{TABLES}/proteins_recovered_whole.csv",
        cpu=f"{TABLES}/proteins_cpu.csv",
        summary=f"{TABLES}/proteins_summary.csv.gz",
        relation=f"{TABLES}/proteins_relation.csv",
        surfaces=f"{TABLES}/proteins_surfaces.csv.gz",
    log:
        f"{RESULTS}/logs/tabulate_proteins.log",
    params:
        run=f"{RESULTS}_proteins",
        proteins=MANY_PROTEINS,
        run_recovered=f"{RESULTS}_recovered",
        proteins_recovered=RECOVERED_GRID,
        run_whole=f"{RESULTS}_whole",
        proteins_whole=RECOVERED_WHOLE_GRID,
        hydrogens=config["proteins"]["hydrogens"],
    message:
        "Tables over many proteins"
    script:
        "../tabulate_proteins.py"


rule tabulate_required:
    input:
        tables=expand(f"{RESULTS}_required/{{protein}}/c1/required_dots.csv", protein=MANY_PROTEINS),
    output:
        required=f"{TABLES}/proteins_required_dots.csv",
        required_means=f"{TABLES}/proteins_required_means.csv",
        cpu=f"{TABLES}/required_cpu.csv",
    log:
        f"{RESULTS}/logs/tabulate_required.log",
    localrule: True
    params:
        proteins=MANY_PROTEINS,
        logs=f"{RESULTS}_required/logs",
    message:
        "How many dots are enough on many proteins"
    script:
        "../tabulate_required.py"


rule tabulate_variants:
    input:
        [
            f"{RESULTS}_{study}/{protein}/c1/{file}"
            for variant, study in VARIANTS.items()
            for protein in proteins_of_variant(variant)
            for file in ["grid.csv", "ranges.csv", "best.json", "floors.csv", "compare.csv"]
        ],
    output:
        variants=f"{TABLES}/proteins_variants.csv",
        cpu=f"{TABLES}/variants_cpu.csv",
    log:
        f"{RESULTS}/logs/tabulate_variants.log",
    params:
        runs={variant: f"{RESULTS}_{study}" for variant, study in VARIANTS.items()},
        proteins={variant: proteins_of_variant(variant) for variant in VARIANTS},
    message:
        "The claims under each variant"
    script:
        "../tabulate_variants.py"


rule draw_proteins:
    input:
        d=f"{TABLES}/proteins_d.csv",
        required=f"{TABLES}/proteins_required_dots.csv",
        by_n_s=f"{TABLES}/proteins_by_n_s.csv",
        power=f"{TABLES}/proteins_power.csv",
        recovered=f"{TABLES}/proteins_recovered.csv",
        summary=f"{TABLES}/proteins_summary.csv.gz",
        relation=f"{TABLES}/proteins_relation.csv",
        surfaces=f"{TABLES}/proteins_surfaces.csv.gz",
    output:
        d=f"{FIGURES}/proteins_d.png",
        roughness=f"{FIGURES}/proteins_roughness.png",
        required=f"{FIGURES}/proteins_required_dots.png",
        needed=f"{FIGURES}/proteins_needed.png",
    log:
        f"{RESULTS}/logs/draw_proteins.log",
    localrule: True
    message:
        "Figures over many proteins"
    script:
        "../draw_proteins.py"
