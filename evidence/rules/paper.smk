# docs/paper.md and README.md: the paper's tables and figures compared with ours, on all its surfaces.

# quick.yaml switches surfaces off by null
FRAGMENTS = {name: entry for name, entry in config["fragments"]["surfaces"].items() if entry}


rule measure_fragments:
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
    conda:
        "../../envs/evidence.yaml"
    threads: 2
    params:
        dots=lambda wildcards: FRAGMENTS[wildcards.surface]["dots"],
        surface=config["fragments"]["surface"],
        patches=config["fragments"]["patches"],
        sampling=config["fragments"]["sampling"],
        rows_evaluation=config["fragments"]["rows"],
        grid_evaluation=config["fragments"]["grid"],
        seed=config["seed"],
    message:
        "Table I on {wildcards.surface}"
    script:
        "../measure.py"


rule measure_repeated:
    input:
        structure=ancient(structure_file(FRAGMENTS[config["fragments"]["repeated"]]["structure"])),
    output:
        runs=f"{RESULTS}/fragments/repeated.csv",
    log:
        f"{RESULTS}/logs/fragments/repeat_table1.log",
    conda:
        "../../envs/evidence.yaml"
    threads: 2
    params:
        dots=FRAGMENTS[config["fragments"]["repeated"]]["dots"],
        surface=config["fragments"]["surface"],
        patches=config["fragments"]["patches"],
        sampling=config["fragments"]["sampling"],
        runs=config["fragments"]["runs"],
        seed=config["seed"],
    message:
        "Table I as published, {params.runs} times"
    script:
        "../measure.py"


rule measure_links:
    input:
        structure=ancient(structure),
    output:
        links=f"{RESULTS}/links/{{protein}}/links.csv",
    log:
        f"{RESULTS}/logs/links/{{protein}}/measure_links.log",
    conda:
        "../../envs/evidence.yaml"
    threads: 2
    params:
        dots="dms",
        surface=config["fragments"]["surface"],
        patches=config["fragments"]["patches"],
        links=config["links"]["distances"],
        test_dots=config["links"]["test_dots"],
        draws=config["links"]["draws"],
        seed=config["seed"],
    message:
        "Linking distances on {wildcards.protein}"
    script:
        "../measure.py"


rule tabulate_links:
    input:
        links=expand(f"{RESULTS}/links/{{protein}}/links.csv", protein=config["links"]["surfaces"]),
    output:
        table=f"{TABLES}/paper_links.csv",
        readings=f"{TABLES}/paper_readings.csv",
        figure=f"{FIGURES}/paper_links.png",
    log:
        f"{RESULTS}/logs/tabulate_links.log",
    localrule: True
    conda:
        "../../envs/evidence.yaml"
    message:
        "d against the linking distance"
    script:
        "../measure.py"


rule measure_rules:
    input:
        structure=ancient(structure_file(config["links"]["surfaces"][0])),
    output:
        table=f"{TABLES}/paper_rules.csv",
    log:
        f"{RESULTS}/logs/measure_rules.log",
    conda:
        "../../envs/evidence.yaml"
    threads: 2
    params:
        dots="dms",
        surface=config["fragments"]["surface"],
        patches=config["fragments"]["patches"],
        orders=config["links"]["orders"],
        test_dots=config["links"]["test_dots"],
        draws=config["links"]["draws"],
        seed=config["seed"],
    message:
        "Rules of the authors' code, one by one"
    script:
        "../measure.py"


rule tabulate_repeated:
    input:
        repeated=f"{RESULTS}/fragments/repeated.csv",
    output:
        places=f"{TABLES}/fragments_places.csv",
        verdict=f"{TABLES}/fragments_verdict.csv",
        tests=f"{TABLES}/fragments_tests.csv",
    log:
        f"{RESULTS}/logs/tabulate_repeated.log",
    localrule: True
    conda:
        "../../envs/evidence.yaml"
    message:
        "Places of the published values among runs made as published"
    script:
        "../measure.py"


rule tabulate_fragments:
    input:
        rows=expand(f"{RESULTS}/fragments/{{surface}}/rows.csv", surface=FRAGMENTS),
        choices=expand(f"{RESULTS}/fragments/{{surface}}/choices.csv", surface=FRAGMENTS),
        gathering=f"{RESULTS}/fragments/{config['fragments']['repeated']}/gathering.csv",
        places=rules.tabulate_repeated.output.places,
        paper_rows=f"{RESULTS}_paper/paper_rows.csv",
    output:
        rows=f"{TABLES}/fragments_rows.csv",
        table1=f"{TABLES}/fragments_table1.csv",
        inside=f"{TABLES}/fragments_inside.csv",
        choices=f"{TABLES}/fragments_choices.csv",
        surfaces=f"{TABLES}/fragments_surfaces.csv",
        gathering=f"{TABLES}/paper_gathering.csv",
        figure=f"{FIGURES}/table1.png",
    log:
        f"{RESULTS}/logs/tabulate_fragments.log",
    localrule: True
    conda:
        "../../envs/evidence.yaml"
    params:
        repeated=config["fragments"]["repeated"],
    message:
        "Table I on all surfaces of the paper"
    script:
        "../measure.py"


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
    conda:
        "../../envs/evidence.yaml"
    message:
        "The paper's Figures 1 to 4 and the numbers of its statements"
    script:
        "../measure.py"


rule draw_gathering:
    input:
        structure=ancient(structure_file(FRAGMENTS[config["fragments"]["drawn"]]["structure"])),
    output:
        figure=f"{FIGURES}/paper_figure_5.png",
    log:
        f"{RESULTS}/logs/draw_gathering.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        dots=FRAGMENTS[config["fragments"]["drawn"]]["dots"],
        surface=config["fragments"]["surface"],
        patches=config["fragments"]["patches"],
        seed=config["seed"],
    message:
        "Figure 5 of the paper"
    script:
        "../measure.py"


rule draw_edges:
    input:
        structure=ancient(structure_file(FRAGMENTS[config["fragments"]["drawn"]]["structure"])),
    output:
        figure=f"{FIGURES}/why_edges.png",
    log:
        f"{RESULTS}/logs/draw_edges.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        dots=FRAGMENTS[config["fragments"]["drawn"]]["dots"],
        surface=config["fragments"]["surface"],
        patches=config["fragments"]["patches"],
        seed=config["seed"],
    message:
        "Where in their patches dots are kept"
    script:
        "../measure.py"
