# docs/proteins.md: what holds over many proteins, from studies of them (studies.smk).

FILES = ["grid.csv", "ranges.csv", "best.json", "floors.csv"]  # of each protein


rule tabulate_proteins:
    input:
        summary=f"{RESULTS}_proteins/summary.csv",
        relation=f"{RESULTS}_proteins/relation.csv",
        surfaces=f"{RESULTS}_proteins/surfaces.csv",
        grids=expand(f"{RESULTS}_proteins/{{protein}}/c1/{{file}}", protein=MANY_PROTEINS, file=FILES),
        recovered=expand(f"{RESULTS}_recovered/{{protein}}/c1/{{file}}", protein=SOME_PROTEINS, file=FILES),
        compared=expand(f"{RESULTS}_proteins/{{protein}}/c1/compare.csv", protein=SOME_PROTEINS),
    output:
        d=f"{TABLES}/proteins_d.csv",
        plateaus=f"{TABLES}/proteins_plateaus.csv",
        needed_means=f"{TABLES}/proteins_needed_means.csv",
        by_n_s=f"{TABLES}/proteins_by_n_s.csv",
        correlations=f"{TABLES}/proteins_correlations.csv",
        power=f"{TABLES}/proteins_power.csv",
        recovered=f"{TABLES}/proteins_recovered.csv",
        summary=f"{TABLES}/proteins_summary.csv.gz",
        relation=f"{TABLES}/proteins_relation.csv",
        surfaces=f"{TABLES}/proteins_surfaces.csv.gz",
        figure_d=f"{FIGURES}/proteins_d.png",
        figure_needed=f"{FIGURES}/proteins_needed.png",
    log:
        f"{RESULTS}/logs/tabulate_proteins.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        proteins=MANY_PROTEINS,
        recovered=SOME_PROTEINS,
        hydrogens=config["proteins"]["hydrogens"],
    message:
        "Tables and figures over many proteins"
    script:
        "../measure.py"
