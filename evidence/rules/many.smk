# docs/many.md: what each of many structures costs when they are analysed in batches.

MANY = [name for name in names_in_set(STRUCTURES, "proteins") if name not in MISSING]
# Structures whose places are stored: the chains, or the many proteins where the folder of chains is missing
STORED = (
    {path.name.removesuffix(".pdb.gz"): str(path) for path in Path(DATA, "chains").glob("*.pdb.gz")}
    if DATA and SITES["unrelated"]["chains"]
    else {}
) or {name: structure_file(name) for name in MANY}


rule measure_batch:
    input:
        structures=ancient([structure_file(name) for name in MANY]),
        study=ancient(HOME / "studies" / "many.yaml"),
    output:
        table=f"{TABLES}/many.csv",
    log:
        f"{RESULTS}/logs/measure_batch.log",
    params:
        structures={name: structure_file(name) for name in MANY},
    message:
        "Costs of structures in a batch"
    script:
        "../measure_batch.py"


rule measure_places:
    input:
        structures=ancient(sorted(STORED.values())),
        study=ancient(HOME / "studies" / "many.yaml"),
    output:
        table=f"{TABLES}/many_places.csv",
    log:
        f"{RESULTS}/logs/measure_places.log",
    threads: 2
    params:
        structures=STORED,
        targets=config["many"]["targets"],
        queries=config["many"]["queries"],
        places=config["many"]["places"],
        seed=config["seed"],
    message:
        "Sites searched by stored places"
    script:
        "../measure_places.py"
