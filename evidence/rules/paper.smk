# docs/paper.md and README.md: the paper's tables and figures compared with ours, on all its surfaces; what few dots cost; which
# wrong rules the test of Table I detects.

# quick.yaml switches surfaces off by null
FRAGMENTS = {name: entry for name, entry in config["fragments"]["surfaces"].items() if entry}


def fragment(wildcards):
    """Path of the structure or of the dots of a surface."""
    return structure_file(FRAGMENTS[wildcards.surface]["structure"])


rule store_paper:
    input:
        rows=f"{RESULTS}_paper/paper_rows.csv",
        places=f"{RESULTS}_paper/paper_places.csv",
        tests=f"{RESULTS}_paper/paper_tests.csv",
        required=f"{RESULTS}_default/{config['example']}/figures/required_dots.png",
        table1=f"{RESULTS}_paper/table1.png",
    output:
        rows=f"{TABLES}/paper_rows.csv",
        places=f"{TABLES}/paper_places.csv",
        tests=f"{TABLES}/paper_tests.csv",
        required=f"{FIGURES}/required_dots.png",
        table1=f"{FIGURES}/table1.png",
    log:
        f"{RESULTS}/logs/store_paper.log",
    localrule: True
    message:
        "Tables and figures of the default study and of the paper's"
    shell:
        "cp {input.rows} {output.rows}; cp {input.places} {output.places}; cp {input.tests} {output.tests}; "
        "cp {input.required} {output.required}; cp {input.table1} {output.table1}"


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


rule measure_fragment:
    input:
        structure=ancient(fragment),
    output:
        rows=f"{RESULTS}/fragments/{{surface}}/rows.csv",
        choices=f"{RESULTS}/fragments/{{surface}}/choices.csv",
        gathering=f"{RESULTS}/fragments/{{surface}}/gathering.csv",
    log:
        f"{RESULTS}/logs/fragments/{{surface}}/measure_fragment.log",
    wildcard_constraints:
        surface=one_of(FRAGMENTS),
    threads: 2
    params:
        dots=lambda wildcards: FRAGMENTS[wildcards.surface]["dots"],
        surface=config["power"]["surface"],
        patches=config["power"]["patches"],
        sampling=config["power"]["sampling"],
        rows_evaluation=config["fragments"]["rows"],
        grid_evaluation=config["fragments"]["grid"],
        seed=config["seed"],
    message:
        "Table I on {wildcards.surface}"
    script:
        "../measure_fragment.py"


rule repeat_table1:
    input:
        structure=ancient(structure_file(FRAGMENTS[config["fragments"]["repeated"]]["structure"])),
    output:
        runs=f"{RESULTS}/fragments/repeated.csv",
    log:
        f"{RESULTS}/logs/fragments/repeat_table1.log",
    threads: 2
    params:
        dots=FRAGMENTS[config["fragments"]["repeated"]]["dots"],
        surface=config["power"]["surface"],
        patches=config["power"]["patches"],
        sampling=config["power"]["sampling"],
        runs=config["fragments"]["runs"],
        seed=config["seed"],
    message:
        "Table I as published, {params.runs} times"
    script:
        "../repeat_table1.py"


rule tabulate_fragments:
    input:
        rows=expand(f"{RESULTS}/fragments/{{surface}}/rows.csv", surface=FRAGMENTS),
        choices=expand(f"{RESULTS}/fragments/{{surface}}/choices.csv", surface=FRAGMENTS),
        gathering=f"{RESULTS}/fragments/{config['fragments']['repeated']}/gathering.csv",
        repeated=f"{RESULTS}/fragments/repeated.csv",
        runs=f"{RESULTS}_paper/paper_as_published.csv",
        paper_rows=f"{RESULTS}_paper/paper_rows.csv",
    output:
        rows=f"{TABLES}/fragments_rows.csv",
        table1=f"{TABLES}/fragments_table1.csv",
        inside=f"{TABLES}/fragments_inside.csv",
        choices=f"{TABLES}/fragments_choices.csv",
        surfaces=f"{TABLES}/fragments_surfaces.csv",
        places=f"{TABLES}/fragments_places.csv",
        tests=f"{TABLES}/fragments_tests.csv",
        gathering=f"{TABLES}/paper_gathering.csv",
        size=f"{TABLES}/paper_size.csv",
        cpu=f"{TABLES}/fragments_cpu.csv",
    log:
        f"{RESULTS}/logs/tabulate_fragments.log",
    localrule: True
    params:
        logs=f"{RESULTS}/logs/fragments",
    message:
        "Table I on all surfaces of the paper"
    script:
        "../tabulate_fragments.py"


rule tabulate_figures:
    input:
        grid=f"{RESULTS}_paper/A1/c1/grid.csv",
        best=f"{RESULTS}_paper/A1/c1/best.json",
        roughness=f"{RESULTS}_paper/A1/c1/roughness.csv",
        bins=f"{RESULTS}_paper/A1/c1/rough_and_flat.csv",
        ranges=f"{RESULTS}_paper/A1/c1/ranges.csv",
        gathering=f"{TABLES}/paper_gathering.csv",
        figures=expand(
            f"{RESULTS}_paper/A1/c1/figures/{{figure}}.png",
            figure=["roughness", "number_of_dots", "d_over_grid", "rough_and_flat"],
        ),
    output:
        table=f"{TABLES}/paper_figures.csv",
        bins=f"{TABLES}/paper_bins.csv",
        ranges=f"{TABLES}/paper_ranges.csv",
        figures=expand(f"{FIGURES}/paper_figure_{{number}}.png", number=[1, 2, 3, 4]),
    log:
        f"{RESULTS}/logs/tabulate_figures.log",
    localrule: True
    message:
        "The paper's Figures 1 to 4 and the numbers of its statements"
    script:
        "../tabulate_figures.py"


rule draw_gathering:
    input:
        structure=ancient(structure_file(FRAGMENTS[config["fragments"]["drawn"]]["structure"])),
    output:
        figure=f"{FIGURES}/paper_figure_5.png",
    log:
        f"{RESULTS}/logs/draw_gathering.log",
    params:
        dots=FRAGMENTS[config["fragments"]["drawn"]]["dots"],
        surface=config["power"]["surface"],
        patches=config["power"]["patches"],
        seed=config["seed"],
    message:
        "Figure 5 of the paper"
    script:
        "../draw_gathering.py"


rule measure_thinned_costs:
    input:
        structure=ancient(structure_file(config["thinned_costs"]["surface"])),
        partners=[ancient(structure_file(name)) for name in COMPLEXES[config["thinned_costs"]["pair"]]],
    output:
        table=f"{TABLES}/paper_costs.csv",
    log:
        f"{RESULTS}/logs/measure_thinned_costs.log",
    params:
        percents=config["thinned_costs"]["percents"],
        samplers=config["thinned_costs"]["samplers"],
        surface=config["power"]["surface"],
        seed=config["seed"],
    message:
        "Cost and error of analyses of few dots"
    script:
        "../measure_thinned_costs.py"
