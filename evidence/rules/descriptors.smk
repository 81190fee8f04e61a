# docs/descriptors.md: how far position and dots change each descriptor, and the paper's tables with each descriptor.

DESCRIBED = names_in_set(STRUCTURES, "descriptors")


rule measure_descriptors:
    input:
        structure=ancient(structure),
    output:
        changes=f"{RESULTS}/descriptors/{{protein}}/changes.csv",
        linked=f"{RESULTS}/descriptors/{{protein}}/linked.csv",
        orders=f"{RESULTS}/descriptors/{{protein}}/orders.csv",
        rows=f"{RESULTS}/descriptors/{{protein}}/rows.csv",
        samplers=f"{RESULTS}/descriptors/{{protein}}/samplers.csv",
        grid=f"{RESULTS}/descriptors/{{protein}}/grid.csv",
    log:
        f"{RESULTS}/logs/descriptors/{{protein}}/measure_descriptors.log",
    params:
        test_dots=config["descriptors"]["test_dots"],
        densities=config["descriptors"]["densities"],
        d_link=config["descriptors"]["D_link"],
        percents=config["descriptors"]["percents"],
        sampling=config["descriptors"]["sampling"],
        grid_test_dots=config["descriptors"]["grid_test_dots"],
        seed=config["seed"],
    message:
        "Descriptors of {wildcards.protein}, rotated and with fresh dots"
    script:
        "../measure_descriptors.py"


rule tabulate_descriptors:
    input:
        changes=expand(f"{RESULTS}/descriptors/{{protein}}/changes.csv", protein=DESCRIBED),
        linked=expand(f"{RESULTS}/descriptors/{{protein}}/linked.csv", protein=DESCRIBED),
        orders=expand(f"{RESULTS}/descriptors/{{protein}}/orders.csv", protein=DESCRIBED),
        rows=expand(f"{RESULTS}/descriptors/{{protein}}/rows.csv", protein=DESCRIBED),
        samplers=expand(f"{RESULTS}/descriptors/{{protein}}/samplers.csv", protein=DESCRIBED),
        grid=expand(f"{RESULTS}/descriptors/{{protein}}/grid.csv", protein=DESCRIBED),
    output:
        changes=f"{TABLES}/descriptors_changes.csv",
        changes_means=f"{TABLES}/descriptors_changes_means.csv",
        linked=f"{TABLES}/descriptors_linked.csv",
        linked_means=f"{TABLES}/descriptors_linked_means.csv",
        orders=f"{TABLES}/descriptors_orders.csv",
        orders_means=f"{TABLES}/descriptors_orders_means.csv",
        rows=f"{TABLES}/descriptors_rows.csv",
        samplers=f"{TABLES}/descriptors_samplers.csv",
        grid=f"{TABLES}/descriptors_grid.csv",
        grid_means=f"{TABLES}/descriptors_grid_means.csv",
        cpu=f"{TABLES}/descriptors_cpu.csv",
    log:
        f"{RESULTS}/logs/tabulate_descriptors.log",
    localrule: True
    params:
        logs=f"{RESULTS}/logs/descriptors",
    message:
        "Tables of the descriptors"
    script:
        "../tabulate_descriptors.py"


rule draw_descriptors:
    input:
        changes=f"{TABLES}/descriptors_changes.csv",
        changes_means=f"{TABLES}/descriptors_changes_means.csv",
        orders_means=f"{TABLES}/descriptors_orders_means.csv",
        samplers=f"{TABLES}/descriptors_samplers.csv",
    output:
        steadiness=f"{FIGURES}/descriptors_steadiness.png",
        samplers=f"{FIGURES}/descriptors_samplers.png",
    log:
        f"{RESULTS}/logs/draw_descriptors.log",
    localrule: True
    message:
        "Figures of the descriptors"
    script:
        "../draw_descriptors.py"
