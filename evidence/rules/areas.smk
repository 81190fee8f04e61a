# docs/partners.md: accessible and excluded areas beside those of other programs.

AREAS = config["areas"]["structures"]


rule measure_areas:
    input:
        structures=ancient([structure_file(name) for name in AREAS]),
    output:
        table=f"{TABLES}/areas.csv",
        means=f"{TABLES}/areas_means.csv",
    log:
        f"{RESULTS}/logs/measure_areas.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        structures={name: structure_file(name) for name in AREAS},
    message:
        "Areas of atoms beside those of other programs"
    script:
        "../measure.py"
