# Two forms of a protein that are compared residue by residue, for each entry of `changes`.


rule compare_forms:
    input:
        unpack(compared_forms),
    output:
        changes="results/{run}/changes/{comparison}/changes.csv",
        pdb_1="results/{run}/changes/{comparison}/changed_1.pdb",
        pdb_2="results/{run}/changes/{comparison}/changed_2.pdb",
    log:
        "results/{run}/logs/changes/{comparison}/compare_forms.log",
    conda:
        "../envs/study.yaml"
    threads: 8
    params:
        forms=names_of_forms,
        surface=config["surface"],
        d_link=config["patches"]["d_link"],
        seed=config["seed"],
        code=CODE["numbers"],
    message:
        "Comparing the forms of {wildcards.comparison}"
    script:
        "../scripts/compare_forms.py"


rule draw_changes:
    input:
        unpack(compared_forms),
        changes="results/{run}/changes/{comparison}/changes.csv",
    output:
        png=in_report("results/{run}/changes/{comparison}/changes.png"),
        view_1=in_report("results/{run}/changes/{comparison}/view_1.html"),
        view_2=in_report("results/{run}/changes/{comparison}/view_2.html"),
    log:
        "results/{run}/logs/changes/{comparison}/draw_changes.log",
    conda:
        "../envs/study.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 1000,
    params:
        forms=names_of_forms,
        surface=part_of("surface", "probe_radius", "radii", "reentrant", "cavities"),
        patches=config["patches"],
        sampling=part_of("sampling", *RULES_OF_SAMPLING),
        seed=config["seed"],
        code=CODE["pages"],
    message:
        "Pictures of the changes of {wildcards.comparison}"
    script:
        "../scripts/draw_changes.py"
