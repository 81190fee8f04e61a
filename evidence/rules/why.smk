# docs/why.md: why the sampling gains where it does, what roughness contributes, and how many dots an error needs.


rule measure_curve:
    input:
        structure=ancient(structure),
    output:
        curve=f"{RESULTS}/why/{{protein}}/curve.csv",
    log:
        f"{RESULTS}/logs/why/{{protein}}/measure_curve.log",
    conda:
        "../../envs/evidence.yaml"
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
        "../measure.py"


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
    conda:
        "../../envs/evidence.yaml"
    params:
        marked=config["links"]["surfaces"][0],
    message:
        "d over link / spacing"
    script:
        "../measure.py"


PAPERS = config["links"]["surfaces"][0]  # the paper's protein: hydrogens and dots as published
OTHERS = [name for name in MANY_PROTEINS if name != PAPERS]
RECONSTRUCTED = [PAPERS, *OTHERS[:: config["why"]["reconstructed_every"]]]


rule measure_null_result:
    input:
        structure=ancient(structure),
    output:
        table=f"{RESULTS}/why/{{protein}}/null_result.csv",
    log:
        f"{RESULTS}/logs/why/{{protein}}/measure_null_result.log",
    conda:
        "../../envs/evidence.yaml"
    threads: 2
    params:
        surface=lambda wildcards: config["fragments"]["surface"] if wildcards.protein == PAPERS else {},
        hydrogens=lambda wildcards: "keep" if wildcards.protein == PAPERS else config["proteins"]["hydrogens"],
        readings=lambda wildcards: (
            ["kept", "full", "recovered"] if wildcards.protein in RECONSTRUCTED else ["kept", "full"]
        ),
        patches=config["fragments"]["patches"],
        test_dots=config["why"]["null_result"]["test_dots"],
        draws=config["why"]["null_result"]["draws"],
        seed=config["seed"],
    message:
        "Other values in the place of R on {wildcards.protein}"
    script:
        "../measure.py"


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
    conda:
        "../../envs/evidence.yaml"
    params:
        paper=PAPERS,
    message:
        "What roughness contributes to d"
    script:
        "../measure.py"


rule measure_full_weight:
    input:
        structure=ancient(structure),
    output:
        table=f"{RESULTS}/why/{{protein}}/full_weight.csv",
    log:
        f"{RESULTS}/logs/why/{{protein}}/measure_full_weight.log",
    conda:
        "../../envs/evidence.yaml"
    threads: 2
    params:
        surface=lambda wildcards: config["fragments"]["surface"] if wildcards.protein == PAPERS else {},
        hydrogens=lambda wildcards: "keep" if wildcards.protein == PAPERS else config["proteins"]["hydrogens"],
        patches=config["fragments"]["patches"],
        test_dots=config["why"]["null_result"]["test_dots"],
        draws=config["why"]["null_result"]["draws"],
        seed=config["seed"],
    message:
        "Roughness at full weight on {wildcards.protein}"
    script:
        "../measure.py"


rule tabulate_full_weight:
    input:
        tables=expand(f"{RESULTS}/why/{{protein}}/full_weight.csv", protein=[PAPERS, *OTHERS]),
    output:
        table=f"{TABLES}/why_full_weight.csv",
        means=f"{TABLES}/why_full_weight_means.csv",
    log:
        f"{RESULTS}/logs/tabulate_full_weight.log",
    localrule: True
    conda:
        "../../envs/evidence.yaml"
    message:
        "What roughness contributes at full weight"
    script:
        "../measure.py"


rule measure_denser:
    input:
        structure=ancient(structure),
    output:
        table=f"{RESULTS}/why/{{protein}}/denser.csv",
    log:
        f"{RESULTS}/logs/why/{{protein}}/measure_denser.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        hydrogens=config["proteins"]["hydrogens"],
        powers=config["why"]["denser"]["powers"],
        densities=config["why"]["denser"]["densities"],
        seed=config["seed"],
    message:
        "Dots that are denser where {wildcards.protein} is rough"
    script:
        "../measure.py"


rule tabulate_denser:
    input:
        tables=expand(f"{RESULTS}/why/{{protein}}/denser.csv", protein=MANY_PROTEINS),
    output:
        table=f"{TABLES}/why_denser.csv",
        means=f"{TABLES}/why_denser_means.csv",
    log:
        f"{RESULTS}/logs/tabulate_denser.log",
    localrule: True
    conda:
        "../../envs/evidence.yaml"
    message:
        "Errors of dots that are denser where the surface is rough"
    script:
        "../measure.py"


LAW_CHAINS = names_in_set(STRUCTURES, "chains")[:: config["why"]["every"]]
LAW_PARTS = {f"chains_{k}": LAW_CHAINS[k :: config["why"]["parts"]] for k in range(config["why"]["parts"])}
LAW_PARTS |= {part: config["why"]["with_hydrogens"] for part in ("with_hydrogens", "hydrogens_removed")}
LAW_GROUPS = {"with_hydrogens": "with hydrogens", "hydrogens_removed": "the same without hydrogens"}


rule measure_law:
    input:
        structures=lambda wildcards: ancient([structure_file(name) for name in LAW_PARTS[wildcards.part]]),
    output:
        errors=f"{RESULTS}/why/law/{{part}}.csv",
        parts=f"{RESULTS}/why/law/{{part}}_parts.csv",
    log:
        f"{RESULTS}/logs/why/law/{{part}}.log",
    wildcard_constraints:
        part=one_of(LAW_PARTS),
    conda:
        "../../envs/evidence.yaml"
    params:
        structures=lambda wildcards: {name: structure_file(name) for name in LAW_PARTS[wildcards.part]},
        group=lambda wildcards: LAW_GROUPS.get(wildcards.part, "chains"),
        hydrogens=lambda wildcards: "remove" if wildcards.part == "hydrogens_removed" else "keep",
        densities=config["why"]["densities"],
        seed=config["seed"],
    message:
        "Errors of reconstructed surfaces by density: {wildcards.part}"
    script:
        "../measure.py"


rule tabulate_law:
    input:
        errors=expand(f"{RESULTS}/why/law/{{part}}.csv", part=LAW_PARTS),
        parts=expand(f"{RESULTS}/why/law/{{part}}_parts.csv", part=LAW_PARTS),
    output:
        table=f"{TABLES}/why_law.csv",
        fits=f"{TABLES}/why_law_fits.csv",
        by_density=f"{TABLES}/why_law_by_density.csv",
        required=f"{TABLES}/why_law_required.csv",
        by_part=f"{TABLES}/why_law_by_part.csv",
        figure=f"{FIGURES}/why_law.png",
    log:
        f"{RESULTS}/logs/tabulate_law.log",
    localrule: True
    conda:
        "../../envs/evidence.yaml"
    message:
        "The law of the error by density"
    script:
        "../measure.py"


REASONS_CHAINS = LAW_CHAINS[:: config["why"]["reasons_every"]]


rule measure_reasons:
    input:
        errors=rules.tabulate_law.output.table,
        structures=ancient([structure_file(name) for name in REASONS_CHAINS]),
    output:
        table=f"{TABLES}/why_law_reasons.csv",
        fit=f"{TABLES}/why_law_reasons_fit.csv",
    log:
        f"{RESULTS}/logs/why/measure_reasons.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        structures={name: structure_file(name) for name in REASONS_CHAINS},
        density=config["why"]["densities"][-2],
    message:
        "Pieces, seams and creases"
    script:
        "../measure.py"


SURFACES_OF_CLUMPS, SURFACES_OF_HOLES, PROTEINS_OF_CENTRES = (
    structures_of([name for name in MANY_PROTEINS if name != PAPERS][:: config["why"][study]["every"]])
    for study in ("clumps", "holes", "centres")
)


rule measure_clumps:
    input:
        structures=ancient(SURFACES_OF_CLUMPS.values()),
    output:
        table=f"{TABLES}/why_clumps.csv",
        means=f"{TABLES}/why_clumps_means.csv",
    log:
        f"{RESULTS}/logs/why/measure_clumps.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        structures=SURFACES_OF_CLUMPS,
        paper=PAPERS,
        surface=config["fragments"]["surface"],
        hydrogens=config["proteins"]["hydrogens"],
        patches=config["fragments"]["patches"],
        rows=config["why"]["clumps"]["rows"],
        radii=config["why"]["clumps"]["radii"],
        test_dots=config["why"]["clumps"]["test_dots"],
        draws=config["why"]["clumps"]["draws"],
        seed=config["seed"],
    message:
        "Z of random clumps"
    script:
        "../measure.py"


rule measure_holes:
    input:
        structures=ancient(SURFACES_OF_HOLES.values()),
    output:
        table=f"{TABLES}/why_holes.csv",
        fits=f"{TABLES}/why_holes_fits.csv",
    log:
        f"{RESULTS}/logs/why/measure_holes.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        structures=SURFACES_OF_HOLES,
        paper=PAPERS,
        surface=config["fragments"]["surface"],
        hydrogens=config["proteins"]["hydrogens"],
        patches=config["fragments"]["patches"],
        samplers=config["why"]["holes"]["samplers"],
        percents=config["why"]["holes"]["percents"],
        test_dots=config["why"]["holes"]["test_dots"],
        draws=config["why"]["holes"]["draws"],
        seed=config["seed"],
    message:
        "Z on the full surface by the holes of a subset"
    script:
        "../measure.py"


rule measure_centres:
    input:
        structures=ancient(PROTEINS_OF_CENTRES.values()),
    output:
        table=f"{TABLES}/why_centres.csv",
        means=f"{TABLES}/why_centres_means.csv",
    log:
        f"{RESULTS}/logs/why/measure_centres.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        structures=PROTEINS_OF_CENTRES,
        paper=PAPERS,
        surface=config["fragments"]["surface"],
        hydrogens=config["proteins"]["hydrogens"],
        patches=config["fragments"]["patches"],
        samplers=config["why"]["centres"]["samplers"],
        percents=config["why"]["centres"]["percents"],
        test_dots=config["why"]["centres"]["test_dots"],
        draws=config["why"]["centres"]["draws"],
        seed=config["seed"],
    message:
        "Kept dots as centres of patches"
    script:
        "../measure.py"


SETTINGS_GROUPS = {
    "chains": names_in_set(STRUCTURES, "chains")[:: config["why"]["law_settings"]["every"]],
    "with hydrogens": config["why"]["law_settings"]["with_hydrogens"],
}


rule measure_law_settings:
    input:
        structures=ancient([structure_file(name) for names in SETTINGS_GROUPS.values() for name in names]),
    output:
        table=f"{TABLES}/why_law_settings.csv",
        by_settings=f"{TABLES}/why_law_by_settings.csv",
        required=f"{TABLES}/why_law_settings_required.csv",
    log:
        f"{RESULTS}/logs/why/measure_law_settings.log",
    conda:
        "../../envs/evidence.yaml"
    params:
        structures={
            group: {name: structure_file(name) for name in names} for group, names in SETTINGS_GROUPS.items()
        },
        settings=config["why"]["law_settings"]["settings"],
        densities=config["why"]["densities"],
        seed=config["seed"],
    message:
        "The law of the error at other settings of the surface"
    script:
        "../measure.py"
