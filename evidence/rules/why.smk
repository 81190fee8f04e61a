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
