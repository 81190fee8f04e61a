# docs/proteins.md: how often the intervals of a study contain the truth, on surfaces of the study of many proteins.

COVERED = names_in_set(STRUCTURES, "coverage")


rule pool_coverage:
    input:
        surface=f"{RESULTS}_proteins/{{protein}}/c1/surface.npz",
        roughness=f"{RESULTS}_proteins/{{protein}}/c1/roughness.csv",
        grid=f"{RESULTS}_proteins/{{protein}}/c1/grid.csv",
    output:
        pool=f"{RESULTS}/coverage/{{protein}}/pool.npz",
    log:
        f"{RESULTS}/logs/coverage/{{protein}}/pool_draws.log",
    conda:
        "../../envs/evidence.yaml"
    threads: 2
    params:
        draws=config["coverage"]["pool"]["draws"],
        test_dots=config["coverage"]["pool"]["test_dots"],
    message:
        "Many draws of the best combinations on {wildcards.protein}"
    script:
        "../measure.py"


rule measure_coverage:
    input:
        pool=f"{RESULTS}/coverage/{{protein}}/pool.npz",
    output:
        table=f"{RESULTS}/coverage/{{protein}}/coverage.csv",
    log:
        f"{RESULTS}/logs/coverage/{{protein}}/measure_coverage.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        replicates=config["coverage"]["replicates"],
        designs=config["coverage"]["designs"],
        default=config["coverage"]["default"],
    message:
        "How often intervals contain the truth on {wildcards.protein}"
    script:
        "../measure.py"


rule tabulate_coverage:
    input:
        tables=expand(f"{RESULTS}/coverage/{{protein}}/coverage.csv", protein=COVERED),
    output:
        coverage=f"{TABLES}/coverage.csv",
        coverage_surfaces=f"{TABLES}/coverage_surfaces.csv",
        coverage_designs=f"{TABLES}/coverage_designs.csv",
        coverage_means=f"{TABLES}/coverage_means.csv",
    log:
        f"{RESULTS}/logs/tabulate_coverage.log",
    localrule: True
    conda:
        "../../envs/evidence.yaml"
    params:
        numbers=config["coverage"]["numbers"],
        replicates=config["coverage"]["replicates_of_means"],
        seed=config["seed"],
    message:
        "Tables of coverage"
    script:
        "../measure.py"
