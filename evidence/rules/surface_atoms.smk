# docs/paper_spheres.md: the atoms that determine a surface exactly.

SURFACE_ATOMS = config["surface_atoms"]
SURFACE_ATOMS_CHAINS = names_in_set(STRUCTURES, "chains")[
    SURFACE_ATOMS["chains"]["first"] :: SURFACE_ATOMS["chains"]["every"]
]
# Of a part: its group, and the number of copies of each structure
SURFACE_ATOMS_PARTS = {
    "chains": ("chains", dict.fromkeys(SURFACE_ATOMS_CHAINS, 1)),
    "others": ("others", {name: n for name, n in SURFACE_ATOMS["others"].items() if name in STRUCTURES}),
}


rule measure_surface_atoms:
    input:
        structures=lambda wildcards: ancient(
            [structure_file(name) for name in SURFACE_ATOMS_PARTS[wildcards.part][1]]
        ),
    output:
        table=f"{RESULTS}/surface_atoms/{{part}}.csv",
    log:
        f"{RESULTS}/logs/surface_atoms/{{part}}.log",
    wildcard_constraints:
        part=one_of(SURFACE_ATOMS_PARTS),
    conda:
        "../../envs/evidence.yaml"
    params:
        structures=lambda wildcards: {
            name: (structure_file(name), n) for name, n in SURFACE_ATOMS_PARTS[wildcards.part][1].items()
        },
        group=lambda wildcards: SURFACE_ATOMS_PARTS[wildcards.part][0],
        probes=lambda wildcards: SURFACE_ATOMS["probes"] if wildcards.part == "others" else [1.4],
    message:
        "Atoms that determine a surface: {wildcards.part}"
    script:
        "../measure.py"


rule tabulate_surface_atoms:
    input:
        tables=expand(f"{RESULTS}/surface_atoms/{{part}}.csv", part=SURFACE_ATOMS_PARTS),
    output:
        table=f"{TABLES}/surface_atoms.csv.gz",
        means=f"{TABLES}/surface_atoms_means.csv",
    log:
        f"{RESULTS}/logs/tabulate_surface_atoms.log",
    localrule: True
    conda:
        "../../envs/evidence.yaml"
    message:
        "Tables of the atoms that determine a surface"
    script:
        "../measure.py"


rule measure_stored_atoms:
    input:
        structures=ancient([structure_file(name) for name in SURFACE_ATOMS["stored"]]),
    output:
        changes=f"{TABLES}/surface_atoms_changes.csv",
        changes_means=f"{TABLES}/surface_atoms_changes_means.csv",
        ways=f"{TABLES}/surface_atoms_ways.csv",
        ways_means=f"{TABLES}/surface_atoms_ways_means.csv",
    log:
        f"{RESULTS}/logs/measure_stored_atoms.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        structures={name: structure_file(name) for name in SURFACE_ATOMS["stored"]},
        left_out=SURFACE_ATOMS["left_out"],
        larger=SURFACE_ATOMS["larger"],
    message:
        "Atoms of a surface and other ways to store it"
    script:
        "../measure.py"
