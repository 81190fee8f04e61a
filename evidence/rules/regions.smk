# docs/reference/tables.md: regions of enclosed surface beside five known sites.

SITES = config["regions"]["sites"]


rule measure_regions:
    input:
        structures=ancient([structure_file(name) for _, name, _ in SITES]),
    output:
        table=f"{TABLES}/regions.csv",
    log:
        f"{RESULTS}/logs/measure_regions.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        sites=[[protein, structure_file(name), ligand] for protein, name, ligand in SITES],
        above=config["regions"]["above"],
    message:
        "Regions of enclosed surface at known sites"
    script:
        "../measure.py"
