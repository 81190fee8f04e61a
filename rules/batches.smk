# Thousands of structures, where `sampling: false` leaves out the grid: a job for each batch, tables and one page for the run.


rule analyse_batch:
    input:
        files_of_batch,
    output:
        surfaces="results/{run}/surfaces/{batch}.parquet",
        residues="results/{run}/residues/{batch}.parquet",
        dots="results/{run}/dots/{batch}.parquet",
        failures="results/{run}/failures/{batch}.parquet",
        warnings="results/{run}/warnings/{batch}.parquet",
    log:
        "results/{run}/logs/analyse_batch_{batch}.log",
    conda:
        "../envs/study.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 1000,
        runtime=lambda wildcards, input, attempt: attempt * (20 + len(input)),
    params:
        structures=structures_of_batch,
        surface=config["surface"],
        patches=config["patches"],
        sampling=part_of("sampling", *RULES_OF_SAMPLING),
        evaluation=part_of("evaluation", "test_dots"),
        minimal=config["minimal"],
        fields=config["fields"],
        seed=config["seed"],
        inputs=stamps_of(files_of_batch),
        code=CODE["numbers"],
    message:
        "Batch {wildcards.batch} of structures"
    script:
        "../scripts/analyse_batch.py"


rule summarise_batches:
    input:
        tables=expand(rules.analyse_batch.output, batch=BATCHES, allow_missing=True),
        studied=results_before_pages,
    output:
        page="results/{run}/index.html",
        failures="results/{run}/failures.csv",
        warnings="results/{run}/warnings.csv",
        checks="results/{run}/checks.csv",
        png="results/{run}/distributions.png",
        crate="results/{run}/ro-crate-metadata.json",
        sums="results/{run}/SHA256SUMS",
    log:
        "results/{run}/logs/summarise_batches.log",
    localrule: True
    conda:
        "../envs/study.yaml"
    params:
        exclude=config["exclude"],
        lengths=LENGTHS_OF_GLOSSARY,
        minimal=config["minimal"],
        jobs=log_names(workflow.rules),
        catalogue=catalogue.checksum(),
        code=CODE["pages"],
    message:
        "First page of the run"
    script:
        "../scripts/summarise_batches.py"
