# A structure becomes a trajectory, by GROMACS, where `simulate` of its protein asks for it.

from sparsurf.simulation.protocol import STAGES

SIMULATION = f"{PROTEIN}/simulation"


wildcard_constraints:
    stage=one_of(STAGES),


rule prepare_system:  # hydrogens, a box of water, ions
    input:
        unpack(files.given),
    output:
        system=directory(f"{SIMULATION}/system"),
        contents=f"{SIMULATION}/system.json",
    log:
        f"{PROTEIN_LOGS}/prepare_system.log",
    wildcard_constraints:
        protein=one_of(files.simulated),
    params:
        **made_by("prepare_system.py", "seed"),
        contents=files.contents,
        chosen=lambda wildcards: files.protein(wildcards).chosen,
        simulate=lambda wildcards: files.protein(wildcards).simulate,
    message:
        "Putting {wildcards.protein} into water"
    script:
        "../scripts/prepare_system.py"


rule simulate_stage:  # minimise, nvt, npt, production: each begins where the one before ended
    input:
        unpack(files.stage_before),
        system=f"{SIMULATION}/system",
    output:
        folder=directory(f"{SIMULATION}/{{stage}}"),
    log:
        f"{PROTEIN_LOGS}/simulate_{{stage}}.log",
    wildcard_constraints:
        protein=one_of(files.simulated),
    threads: THREADS
    resources:
        **needs("simulate_stage", files.nanoseconds),
    params:
        **made_by("simulate_stage.py", "seed"),
        simulate=lambda wildcards: files.protein(wildcards).simulate,
        stage="{stage}",
        work=f"{SIMULATION}/.running/{{stage}}",  # outlives a killed job: checkpoints
    message:
        "Simulating {wildcards.protein}: {wildcards.stage}"
    script:
        "../scripts/simulate_stage.py"


rule judge_simulation:
    input:
        **{stage: f"{SIMULATION}/{stage}" for stage in STAGES},
        system=f"{SIMULATION}/system",
    output:
        **inside(SIMULATION, topology="topology.pdb", trajectory="trajectory.xtc"),
        **inside(SIMULATION, energies="energies.csv", motion="motion.csv", quality="quality.csv"),
        **figure(f"{PROTEIN}/figures/simulation", "Simulation", "simulation"),
    log:
        f"{PROTEIN_LOGS}/judge_simulation.log",
    wildcard_constraints:
        protein=one_of(files.simulated),
    params:
        **made_by("judge_simulation.py"),
        simulate=lambda wildcards: files.protein(wildcards).simulate,
    message:
        "Quality of the simulation of {wildcards.protein}"
    script:
        "../scripts/judge_simulation.py"
