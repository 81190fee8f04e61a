# docs/partners.md: areas beside those of other programs; docs/reference/tables.md: triangles and handles beside theirs.

AREAS = config["areas"]["structures"]
MESHES = config["meshes"]["structures"]
HANDLES = names_in_set(STRUCTURES, "chains")


rule measure_areas:
    input:
        structures=ancient([structure_file(name) for name in AREAS]),
    output:
        table=f"{TABLES}/areas.csv",
        means=f"{TABLES}/areas_means.csv",
    log:
        f"{RESULTS}/logs/measure_areas.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        structures={name: structure_file(name) for name in AREAS},
    message:
        "Areas of atoms beside those of other programs"
    script:
        "../measure.py"


rule measure_meshes:
    input:
        structures=ancient([structure_file(name) for name in MESHES]),
    output:
        table=f"{TABLES}/meshes.csv",
        means=f"{TABLES}/meshes_means.csv",
        figure=f"{FIGURES}/meshes.png",
    log:
        f"{RESULTS}/logs/measure_meshes.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        structures={name: structure_file(name) for name in MESHES},
        settings=config["meshes"]["settings"],
        drawn=config["meshes"]["drawn"],
    message:
        "Triangles beside those of other programs"
    script:
        "../measure.py"


rule measure_handles:
    input:
        structures=ancient([structure_file(name) for name in HANDLES]),
    output:
        table=f"{TABLES}/handles.csv",
        means=f"{TABLES}/handles_means.csv",
    log:
        f"{RESULTS}/logs/measure_handles.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        structures={name: structure_file(name) for name in HANDLES},
        steps=config["handles"]["steps"],
        density=config["handles"]["density"],
    message:
        "Handles and volumes, exactly and by other ways"
    script:
        "../measure.py"
