# What is read from the structures. The other chains count as older once it changes, not once the code that reads does.

read = chains.add(
    "structures",
    {"structures": list(source.known)},
    scripts=["read_structures.py", "../scripts/choose_frames.py"],
    tables=["structures_read"],
    reads=True,
)


rule read_structures:
    input:
        structures=[source.path(name) for name in source.known],
        topology=HOME / "data" / "tdp43" / "topology.pdb",
        trajectory=HOME / "data" / "tdp43" / "trajectory.xtc",
        chooses=HOME / "scripts" / "choose_frames.py",
    output:
        touch(read.mark),
        structures_read=update(read.tables["structures_read"]),
    log:
        f"{LOGS}/read_structures.log",
    params:
        code=read.code,
        names=list(source.known),
        studied=lambda wildcards: sorted({name for study in STUDIES.values() for name in study["proteins"]}),
    message:
        "Checksums of what is read from the structures"
    script:
        "../read_structures.py"
