# docs/paper.md and README.md: the paper's tables compared with ours, and which wrong rules the test of Table I detects.


rule store_paper:
    input:
        rows=f"{RESULTS}_paper/paper_rows.csv",
        places=f"{RESULTS}_paper/paper_places.csv",
        tests=f"{RESULTS}_paper/paper_tests.csv",
        ranges=f"{RESULTS}_default/{config['example']}/ranges.csv",
        required=f"{RESULTS}_default/{config['example']}/figures/required_dots.png",
        table1=f"{RESULTS}_paper/table1.png",
    output:
        rows=f"{TABLES}/paper_rows.csv",
        places=f"{TABLES}/paper_places.csv",
        tests=f"{TABLES}/paper_tests.csv",
        ranges=f"{TABLES}/default_ranges.csv",
        required=f"{FIGURES}/required_dots.png",
        table1=f"{FIGURES}/table1.png",
    log:
        f"{RESULTS}/logs/store_paper.log",
    localrule: True
    message:
        "Tables and figures of the default study and of the paper's"
    shell:
        "cp {input.rows} {output.rows}; cp {input.places} {output.places}; cp {input.tests} {output.tests}; "
        "cp {input.ranges} {output.ranges}; cp {input.required} {output.required}; cp {input.table1} {output.table1}"


rule measure_power:
    input:
        structure=ancient(structure_file(config["power"]["a1"])),
    output:
        table=f"{RESULTS}/power/{{variant}}.csv",
    log:
        f"{RESULTS}/logs/power/{{variant}}.log",
    wildcard_constraints:
        variant=one_of([config["power"]["reference"], *config["power"]["rules"]]),
    threads: 2
    params:
        surface=config["power"]["surface"],
        patches=config["power"]["patches"],
        sampling=config["power"]["sampling"],
        rules=lambda wildcards: config["power"]["rules"].get(wildcards.variant, {}),
        runs=lambda wildcards: (
            config["power"]["reference_runs"]
            if wildcards.variant == config["power"]["reference"]
            else config["power"]["runs"]
        ),
        seed=config["seed"],
    message:
        "Table I with {wildcards.variant}"
    script:
        "../measure_power.py"


rule tabulate_power:
    input:
        reference=f"{RESULTS}/power/{config['power']['reference']}.csv",
        others=expand(f"{RESULTS}/power/{{variant}}.csv", variant=config["power"]["rules"]),
    output:
        power=f"{TABLES}/power.csv",
        power_cpu=f"{TABLES}/power_cpu.csv",
    log:
        f"{RESULTS}/logs/tabulate_power.log",
    localrule: True
    params:
        logs=f"{RESULTS}/logs/power",
    message:
        "Power of the test of Table I"
    script:
        "../tabulate_power.py"
