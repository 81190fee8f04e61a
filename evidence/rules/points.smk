# docs/learning.md: points as surface networks make them and ours, and how many an interface needs.

CHAINS = names_in_set(STRUCTURES, "chains")


rule measure_points:
    input:
        structures=ancient([structure_file(name) for name in CHAINS]),
    output:
        table=f"{RESULTS}/points/{{protocol}}.csv",
    log:
        f"{RESULTS}/logs/points/{{protocol}}.log",
    wildcard_constraints:
        protocol=one_of(config["points"]["protocols"]),
    conda:
        "../../envs/evidence.yaml"
    params:
        structures={name: structure_file(name) for name in CHAINS},
        every=config["points"]["every"],
        every_of=config["points"]["every_of"],
        again=config["points"]["again"],
    message:
        "Points by {wildcards.protocol}"
    script:
        "../measure.py"


rule tabulate_points:
    input:
        tables=expand(f"{RESULTS}/points/{{protocol}}.csv", protocol=config["points"]["protocols"]),
    output:
        protocols=f"{TABLES}/points_protocols.csv",
    log:
        f"{RESULTS}/logs/tabulate_points.log",
    localrule: True
    conda:
        "../../envs/evidence.yaml"
    message:
        "Table of protocols for points"
    script:
        "../measure.py"


POTENTIAL = config["potential"]["structures"]


rule measure_potential:
    input:
        structures=ancient([structure_file(name) for name in POTENTIAL]),
    output:
        table=f"{TABLES}/points_potential.csv",
    log:
        f"{RESULTS}/logs/measure_potential.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        structures={name: structure_file(name) for name in POTENTIAL},
    message:
        "Our potential and that of APBS"
    script:
        "../measure.py"


rule measure_interfaces:
    input:
        partners=ancient([structure_file(name) for pair in COMPLEXES.values() for name in pair]),
    output:
        table=f"{TABLES}/points_interfaces.csv",
    log:
        f"{RESULTS}/logs/measure_interfaces.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        complexes={pair: [structure_file(name) for name in names] for pair, names in COMPLEXES.items()},
        densities=config["points"]["densities"],
        seed=config["seed"],
    message:
        "Interface residues from points, by their density"
    script:
        "../measure.py"
