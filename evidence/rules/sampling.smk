# docs/sampling.md: why sampling by roughness does not pay.


rule measure_exponents:
    input:
        structure=ancient(structure),
    output:
        table=f"{RESULTS}/exponents/{{protein}}.csv",
    log:
        f"{RESULTS}/logs/exponents/{{protein}}/measure_exponents.log",
    params:
        exponents=config["exponents"]["exponents"],
        percents=config["exponents"]["percents"],
        test_dots=config["exponents"]["test_dots"],
        draws=config["exponents"]["draws"],
        seed=config["seed"],
    message:
        "Dots denser where {wildcards.protein} is rough"
    script:
        "../measure_exponents.py"


rule tabulate_exponents:
    input:
        tables=expand(f"{RESULTS}/exponents/{{protein}}.csv", protein=names_in_set(STRUCTURES, "exponents")),
    output:
        exponents=f"{TABLES}/exponents.csv",
        exponents_means=f"{TABLES}/exponents_means.csv",
        exponents_best=f"{TABLES}/exponents_best.csv",
        exponents_cpu=f"{TABLES}/exponents_cpu.csv",
    log:
        f"{RESULTS}/logs/tabulate_exponents.log",
    localrule: True
    params:
        logs=f"{RESULTS}/logs/exponents",
    message:
        "Tables of the exponent"
    script:
        "../tabulate_exponents.py"


rule draw_exponents:
    input:
        means=f"{TABLES}/exponents_means.csv",
    output:
        figure=f"{FIGURES}/exponents.png",
    log:
        f"{RESULTS}/logs/draw_exponents.log",
    localrule: True
    message:
        "Figure of the exponent"
    script:
        "../draw_exponents.py"


rule measure_centres:
    input:
        surface=f"{RESULTS}_{{study}}/{{protein}}/c1/surface.npz",
        roughness=f"{RESULTS}_{{study}}/{{protein}}/c1/roughness.csv",
        grid=f"{RESULTS}_{{study}}/{{protein}}/c1/grid.csv",
        ranges=f"{RESULTS}_{{study}}/{{protein}}/c1/ranges.csv",
    output:
        table=f"{RESULTS}/centres/{{study}}/{{protein}}.csv",
    log:
        f"{RESULTS}/logs/centres/{{study}}/{{protein}}/measure_centres.log",
    wildcard_constraints:
        study=one_of(config["centres"]),
    params:
        readings=lambda wildcards: config["centres"][wildcards.study]["readings"],
        test_dots=lambda wildcards: config["centres"][wildcards.study]["test_dots"],
        draws=lambda wildcards: config["centres"][wildcards.study]["draws"],
        seed=config["seed"],
    message:
        "Contribution of the patch centres on {wildcards.protein}, {wildcards.study}"
    script:
        "../measure_centres.py"


rule tabulate_centres:
    input:
        tables=expand(
            f"{RESULTS}/centres/{{study}}/{{protein}}.csv",
            study=config["centres"],
            protein=names_in_set(STRUCTURES, "coverage"),
        ),
    output:
        centres=f"{TABLES}/centres.csv",
        centres_means=f"{TABLES}/centres_means.csv",
        centres_cpu=f"{TABLES}/centres_cpu.csv",
    log:
        f"{RESULTS}/logs/tabulate_centres.log",
    localrule: True
    params:
        logs=f"{RESULTS}/logs/centres",
    message:
        "Tables of the centres"
    script:
        "../tabulate_centres.py"


rule draw_centres:
    input:
        means=f"{TABLES}/centres_means.csv",
    output:
        figure=f"{FIGURES}/centres.png",
    log:
        f"{RESULTS}/logs/draw_centres.log",
    localrule: True
    message:
        "Figure of the centres"
    script:
        "../draw_centres.py"
