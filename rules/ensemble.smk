# One combination over all frames of a trajectory, where `ensemble` asks for it.


scattergather:
    frames=1,  # The frames are divided among so many jobs: `--set-scatter frames=100`.


N_PARTS = len(gather.frames("{scatteritem}"))


rule follow_frames:
    input:
        unpack(molecule_files),
    output:
        rows=temp("results/{run}/{protein}/ensemble/{scatteritem}.csv"),
    log:
        "results/{run}/logs/{protein}/follow_frames_{scatteritem}.log",
    wildcard_constraints:
        protein=any_of(MOLECULES),
    conda:
        "../envs/study.yaml"
    threads: 8
    resources:
        mem_mb=lambda wildcards, input, attempt: attempt * (1000 + 40 * input.size_mb),
        runtime=lambda wildcards, input, attempt: attempt
        * (10 + 4 * input.size_mb / config["ensemble"]["stride"] / N_PARTS),
    params:
        surface=config["surface"],
        patches=config["patches"],
        sampling=part_of("sampling", *RULES_OF_SAMPLING),
        evaluation=part_of("evaluation", "readings"),
        ensemble=part_of("ensemble", "combination", "test_dots", "stride"),
        seed=config["seed"],
        molecule_options=of_protein("molecule_options"),
        inputs=stamps_of(molecule_files),
        code=CODE["numbers"],
    message:
        "n_S and d of one combination over the frames of {wildcards.protein}, part {wildcards.scatteritem}"
    script:
        "../scripts/follow_frames.py"


rule follow_ensemble:
    input:
        unpack(molecule_files),
        rows=gather.frames("results/{{run}}/{{protein}}/ensemble/{scatteritem}.csv"),
    output:
        table="results/{run}/{protein}/ensemble.csv",
        over_time="results/{run}/{protein}/residues_over_time.csv",
        residues="results/{run}/{protein}/residues.csv",
    log:
        "results/{run}/logs/{protein}/follow_ensemble.log",
    wildcard_constraints:
        protein=any_of(MOLECULES),
    conda:
        "../envs/study.yaml"
    params:
        molecule_options=of_protein("molecule_options"),
        inputs=stamps_of(molecule_files),
        code=CODE["numbers"],
    message:
        "All frames of {wildcards.protein} in one table"
    script:
        "../scripts/follow_ensemble.py"


rule draw_ensemble:
    input:
        table="results/{run}/{protein}/ensemble.csv",
        over_time="results/{run}/{protein}/residues_over_time.csv",
        residues="results/{run}/{protein}/residues.csv",
    output:
        png=in_report("results/{run}/{protein}/figures/ensemble.png"),
        residues_png=in_report("results/{run}/{protein}/figures/residues.png"),
    log:
        "results/{run}/logs/{protein}/draw_ensemble.log",
    localrule: True
    conda:
        "../envs/study.yaml"
    params:
        combination=config["ensemble"]["combination"],
        code=CODE["pages"],
    message:
        "Figure of {wildcards.protein} over time"
    script:
        "../scripts/draw_ensemble.py"
