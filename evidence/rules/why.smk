# docs/why.md: why the sampling gains where it does, what roughness contributes, and how many dots an error needs.


rule measure_curve:
    input:
        structure=ancient(structure),
    output:
        curve=f"{RESULTS}/why/{{protein}}/curve.csv",
    log:
        f"{RESULTS}/logs/why/{{protein}}/measure_curve.log",
    threads: 2
    params:
        dots="dms",
        surface=config["fragments"]["surface"],
        patches=config["fragments"]["patches"],
        links=config["why"]["links"],
        test_dots=config["links"]["test_dots"],
        draws=config["links"]["draws"],
        seed=config["seed"],
    message:
        "d over link / spacing on {wildcards.protein}"
    script:
        "../measure_curve.py"


rule tabulate_curve:
    input:
        curves=expand(f"{RESULTS}/why/{{protein}}/curve.csv", protein=config["links"]["surfaces"]),
    output:
        table=f"{TABLES}/why_curve.csv",
        numbers=f"{TABLES}/why_curve_numbers.csv",
        shares=f"{TABLES}/why_curve_shares.csv",
        signs=f"{TABLES}/why_curve_signs.csv",
        figure=f"{FIGURES}/why_curve.png",
    log:
        f"{RESULTS}/logs/tabulate_curve.log",
    localrule: True
    params:
        marked=config["links"]["surfaces"][0],
    message:
        "d over link / spacing"
    script:
        "../tabulate_curve.py"


PAPERS = config["links"]["surfaces"][0]  # the paper's protein: hydrogens and dots as published
OTHERS = [name for name in MANY_PROTEINS if name != PAPERS][:: config["why"]["proteins_every"]]


rule measure_null_result:
    input:
        structure=ancient(structure),
    output:
        table=f"{RESULTS}/why/{{protein}}/null_result.csv",
    log:
        f"{RESULTS}/logs/why/{{protein}}/measure_null_result.log",
    threads: 2
    params:
        surface=lambda wildcards: config["fragments"]["surface"] if wildcards.protein == PAPERS else {},
        hydrogens=lambda wildcards: "keep" if wildcards.protein == PAPERS else config["proteins"]["hydrogens"],
        patches=config["fragments"]["patches"],
        test_dots=config["why"]["null_result"]["test_dots"],
        draws=config["why"]["null_result"]["draws"],
        seed=config["seed"],
    message:
        "Other values in the place of R on {wildcards.protein}"
    script:
        "../measure_null_result.py"


rule tabulate_null_result:
    input:
        tables=expand(f"{RESULTS}/why/{{protein}}/null_result.csv", protein=[PAPERS, *OTHERS]),
    output:
        table=f"{TABLES}/why_roughness.csv.gz",
        means=f"{TABLES}/why_roughness_means.csv",
        figure=f"{FIGURES}/why_roughness.png",
    log:
        f"{RESULTS}/logs/tabulate_null_result.log",
    localrule: True
    params:
        paper=PAPERS,
    message:
        "What roughness contributes to d"
    script:
        "../tabulate_null_result.py"


LAW_CHAINS = names_in_set(STRUCTURES, "chains")[:: config["why"]["every"]]
LAW_PARTS = {f"chains_{k}": LAW_CHAINS[k :: config["why"]["parts"]] for k in range(config["why"]["parts"])}
LAW_PARTS |= {part: config["why"]["with_hydrogens"] for part in ("with_hydrogens", "hydrogens_removed")}
LAW_GROUPS = {"with_hydrogens": "with hydrogens", "hydrogens_removed": "the same without hydrogens"}


rule measure_law:
    input:
        structures=lambda wildcards: ancient([structure_file(name) for name in LAW_PARTS[wildcards.part]]),
    output:
        errors=f"{RESULTS}/why/law/{{part}}.csv",
    log:
        f"{RESULTS}/logs/why/law/{{part}}.log",
    wildcard_constraints:
        part=one_of(LAW_PARTS),
    params:
        structures=lambda wildcards: {name: structure_file(name) for name in LAW_PARTS[wildcards.part]},
        group=lambda wildcards: LAW_GROUPS.get(wildcards.part, "chains"),
        hydrogens=lambda wildcards: "remove" if wildcards.part == "hydrogens_removed" else "keep",
        densities=config["why"]["densities"],
        seed=config["seed"],
    message:
        "Errors of reconstructed surfaces by density: {wildcards.part}"
    script:
        "../measure_law.py"


rule tabulate_law:
    input:
        errors=expand(f"{RESULTS}/why/law/{{part}}.csv", part=LAW_PARTS),
    output:
        table=f"{TABLES}/why_law.csv",
        fits=f"{TABLES}/why_law_fits.csv",
        by_density=f"{TABLES}/why_law_by_density.csv",
        required=f"{TABLES}/why_law_required.csv",
        figure=f"{FIGURES}/why_law.png",
    log:
        f"{RESULTS}/logs/tabulate_law.log",
    localrule: True
    message:
        "The law of the error by density"
    script:
        "../tabulate_law.py"
