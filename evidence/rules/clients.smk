# docs/msms.md: programs that call MSMS, unchanged, with MSMS and with sparsurf-msms.

PROTEINS_OF_CLIENTS = config["clients"]["structures"]


rule measure_clients:
    input:
        structures=ancient([structure_file(name) for name in PROTEINS_OF_CLIENTS]),
    output:
        table=f"{TABLES}/clients.csv",
        means=f"{TABLES}/clients_means.csv",
    log:
        f"{RESULTS}/logs/measure_clients.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        structures={name: structure_file(name) for name in PROTEINS_OF_CLIENTS},
    message:
        "Clients of MSMS with sparsurf-msms"
    script:
        "../measure.py"
