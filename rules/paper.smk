# The tables of the paper next to ours, where `paper` names the protein that is its A1.


rule reproduce_paper:
    input:
        surface=f"results/{{run}}/{config['paper']}/c1/surface.npz",
        roughness=f"results/{{run}}/{config['paper']}/c1/roughness.csv",
        grid=f"results/{{run}}/{config['paper']}/c1/grid.csv",
        ranges=f"results/{{run}}/{config['paper']}/c1/ranges.csv",
        best=f"results/{{run}}/{config['paper']}/c1/best.json",
        recovered=f"results/{{run}}/{config['paper']}/c1/recovered.csv",
        bins=f"results/{{run}}/{config['paper']}/c1/rough_and_flat.csv",
    output:
        page=in_report("results/{run}/verdict.html"),
        runs="results/{run}/paper_as_published.csv",
        places="results/{run}/paper_places.csv",
        tests="results/{run}/paper_tests.csv",
        rows=in_report("results/{run}/paper_rows.csv"),
        links="results/{run}/paper_links.csv",
        defects="results/{run}/paper_defects.csv",
        family="results/{run}/paper_family.csv",
        png=in_report("results/{run}/table1.png"),
        svg="results/{run}/table1.svg",
    log:
        "results/{run}/logs/reproduce_paper.log",
    conda:
        "../envs/study.yaml"
    threads: 8
    params:
        surface=config["surface"],
        patches=config["patches"],
        sampling=config["sampling"],
        evaluation=config["evaluation"],
        seed=config["seed"],
        lengths=LENGTHS_OF_GLOSSARY,
        a1=f"{config['paper']}/c1",
        path_to_surface=PROTEINS[config["paper"]].surface,
        code=CODE["pages"],
    message:
        "Comparing with the paper"
    script:
        "../scripts/reproduce_paper.py"
