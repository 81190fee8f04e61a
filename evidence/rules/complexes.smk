# docs/proteins.md: how well complementarity finds the interface of many complexes.


rule measure_complexes:
    input:
        partners=ancient(lambda wildcards: [structure_file(name) for name in COMPLEXES[wildcards.pair]]),
    output:
        areas=f"{RESULTS}/complexes/{{pair}}.csv",
    log:
        f"{RESULTS}/logs/complexes/{{pair}}/measure_complex.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        descriptors=config["complexes"]["descriptors"],
        patches=config["complexes"]["patches"],
    message:
        "Complementarity of {wildcards.pair}"
    script:
        "../measure.py"


rule tabulate_complexes:
    input:
        areas=expand(f"{RESULTS}/complexes/{{pair}}.csv", pair=COMPLEXES),
    output:
        complexes=f"{TABLES}/complexes.csv",
        complexes_means=f"{TABLES}/complexes_means.csv",
        figure=f"{FIGURES}/complexes.png",
    log:
        f"{RESULTS}/logs/tabulate_complexes.log",
    localrule: True
    conda:
        "../../envs/evidence.yaml"
    message:
        "Tables and figure over many complexes"
    script:
        "../measure.py"
