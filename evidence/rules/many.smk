# docs/study.md: what each of many structures costs when they are analysed in batches.

MANY = names_in_set(STRUCTURES, "chains")[:: config["many"]["every"]]


rule measure_batch:
    input:
        structures=ancient([structure_file(name) for name in MANY]),
        study=ancient(HOME / "studies" / "many.yaml"),
    output:
        table=f"{TABLES}/many.csv",
    log:
        f"{RESULTS}/logs/measure_batch.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        structures={name: structure_file(name) for name in MANY},
    message:
        "Costs of structures in a batch"
    script:
        "../measure.py"
