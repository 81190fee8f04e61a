# A structure becomes a trajectory by GROMACS, where `simulate` of its protein asks for it.


wildcard_constraints:
    stage="minimise|nvt|npt|production",


rule prepare_system:  # It adds hydrogens, a box of water and ions.
    input:
        structure=structure_file,
    output:
        system=directory("results/{run}/{protein}/simulation/system"),
        contents="results/{run}/{protein}/simulation/system.json",
    log:
        "results/{run}/logs/{protein}/prepare_system.log",
    wildcard_constraints:
        protein=any_of(SIMULATED),
    conda:
        "../envs/study.yaml"
    params:
        simulate=of_protein("simulate"),
        structure_options=of_protein("file_options"),
        seed=config["seed"],
        inputs=stamps_of(structure_file),
        code=CODE["simulation"],
    message:
        "Putting {wildcards.protein} into water"
    script:
        "../scripts/prepare_system.py"


rule simulate_stage:  # minimise, nvt, npt and production: each begins where the one before ended.
    input:
        before=stage_before,
        system="results/{run}/{protein}/simulation/system",
    output:
        folder=directory("results/{run}/{protein}/simulation/{stage}"),
    log:
        "results/{run}/logs/{protein}/simulate_{stage}.log",
    wildcard_constraints:
        protein=any_of(SIMULATED),
    conda:
        "../envs/study.yaml"
    threads: 8
    resources:
        mem_mb=lambda wildcards, attempt: attempt * 2000,
        runtime=lambda wildcards, attempt: attempt
        * (60 + 600 * PROTEINS[wildcards.protein].simulate.get("ns", 1)),
    params:
        simulate=of_protein("simulate"),
        stage="{stage}",
        # Checkpoints survive a killed job.
        unfinished="results/{run}/{protein}/simulation/.running/{stage}",
        seed=config["seed"],
        code=CODE["simulation"],
    message:
        "Simulating {wildcards.protein}: {wildcards.stage}"
    script:
        "../scripts/simulate_stage.py"


# It is not part of the rule of pages, after whose edits all that follows from the trajectory would be computed again.
rule extract_trajectory:
    input:
        system="results/{run}/{protein}/simulation/system",
        production="results/{run}/{protein}/simulation/production",
    output:
        topology="results/{run}/{protein}/simulation/topology.pdb",
        trajectory="results/{run}/{protein}/simulation/trajectory.xtc",
    log:
        "results/{run}/logs/{protein}/extract_trajectory.log",
    wildcard_constraints:
        protein=any_of(SIMULATED),
    conda:
        "../envs/study.yaml"
    params:
        code=CODE["numbers"],
    message:
        "Trajectory of {wildcards.protein}"
    script:
        "../scripts/extract_trajectory.py"


rule judge_simulation:
    input:
        minimise="results/{run}/{protein}/simulation/minimise",
        nvt="results/{run}/{protein}/simulation/nvt",
        npt="results/{run}/{protein}/simulation/npt",
        production="results/{run}/{protein}/simulation/production",
        topology="results/{run}/{protein}/simulation/topology.pdb",
        trajectory="results/{run}/{protein}/simulation/trajectory.xtc",
    output:
        energies="results/{run}/{protein}/simulation/energies.csv",
        motion="results/{run}/{protein}/simulation/motion.csv",
        quality="results/{run}/{protein}/simulation/quality.csv",
        png=in_report("results/{run}/{protein}/figures/simulation.png"),
    log:
        "results/{run}/logs/{protein}/judge_simulation.log",
    wildcard_constraints:
        protein=any_of(SIMULATED),
    conda:
        "../envs/study.yaml"
    params:
        simulate=of_protein("simulate"),
        code=CODE["pages"],
    message:
        "Quality of the simulation of {wildcards.protein}"
    script:
        "../scripts/judge_simulation.py"
