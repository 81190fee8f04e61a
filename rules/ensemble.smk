# One combination over all frames of a trajectory, where `ensemble` asks for it.

JOBS = config["ensemble"]["jobs"]  # that share the frames of a trajectory
ENSEMBLE = inside(PROTEIN, table="ensemble.csv", over_time="residues_over_time.csv", residues="residues.csv")


wildcard_constraints:
    k="[0-9]+",


rule follow_frames:  # some of the frames; one job does them all unless ensemble.jobs says otherwise
    input:
        unpack(files.molecule),
        **KERNELS,
    output:
        rows=temp(f"{PROTEIN}/ensemble/{{k}}of{JOBS}.csv"),
    log:
        f"{PROTEIN_LOGS}/follow_frames_{{k}}of{JOBS}.log",
    wildcard_constraints:
        protein=one_of(files.molecules),
    threads: THREADS
    resources:
        **needs("follow_frames", files.megabytes(config["ensemble"]["stride"]), 1 / JOBS),
    params:
        **made_by(
            "follow_frames.py", "surface", "patches", *defects, "evaluation.readings", "ensemble", "seed"
        ),
        molecule_options=lambda wildcards: files.protein(wildcards).molecule_options,
        contents=files.contents,
        protein=lambda wildcards: wildcards.protein,
        part=lambda wildcards: (int(wildcards.k), JOBS),
        path_to_part=lambda wildcards, output: f"{output.rows}.part",  # outlives a killed job
    message:
        f"n_S and d of one combination over the frames of {{wildcards.protein}}, part {{wildcards.k}} of {JOBS}"
    script:
        "../scripts/follow_frames.py"


rule follow_ensemble:
    input:
        unpack(files.molecule),
        rows=[f"{PROTEIN}/ensemble/{k}of{JOBS}.csv" for k in range(1, JOBS + 1)],
    output:
        **ENSEMBLE,
    log:
        f"{PROTEIN_LOGS}/follow_ensemble.log",
    wildcard_constraints:
        protein=one_of(files.molecules),
    localrule: JOBS == 1  # else the rows of many frames
    params:
        **made_by("follow_ensemble.py"),
        molecule_options=lambda wildcards: files.protein(wildcards).molecule_options,
        contents=files.contents,
    message:
        "All frames of {wildcards.protein} in one table"
    script:
        "../scripts/follow_ensemble.py"


rule draw_ensemble:
    input:
        **ENSEMBLE,
    output:
        **figure(f"{PROTEIN}/figures/ensemble", "n_S and d over time", "ensemble"),
        residues=shown(f"{PROTEIN}/figures/residues.png", "Residues over time", "residues_over_time"),
        residues_svg=f"{PROTEIN}/figures/residues.svg",
        page=f"{PROTEIN}/ensemble.html",
    log:
        f"{PROTEIN_LOGS}/draw_ensemble.log",
    wildcard_constraints:
        protein=one_of(files.molecules),
    localrule: True
    params:
        **made_by("draw_ensemble.py", "ensemble"),
    message:
        "Figure of {wildcards.protein} over time"
    script:
        "../scripts/draw_ensemble.py"
