# All of one conformation in one job, where `sampling` is false: of many structures the start of a process costs as much as a step.

OF_STEPS = "surface patches minimal fields seed".split()
STEPS = "make_surface measure_roughness measure_floors take_minimal draw_view tabulate_residues".split()


ruleorder:
    take_all_steps
    > make_surface
    > measure_roughness
    > measure_floors
    > take_minimal
    > draw_view
    > tabulate_residues


rule take_all_steps:
    input:
        unpack(files.frames),
        **KERNELS,
        structures=f"{PROTEIN}/structures",
        table=files.table,
    output:
        **{f"{step}_{key}": path for step in STEPS for key, path in getattr(rules, step).output.items()},
    log:
        f"{CONFORMATION_LOGS}/take_all_steps.log",
    wildcard_constraints:
        protein=one_of(files.molecules),
    resources:
        **needs("take_all_steps", files.dots),
    params:
        **made_by("take_all_steps.py", *OF_STEPS, *defects, "evaluation.test_dots"),
        contents=rules.take_minimal.params.contents,
        molecule_options=lambda wildcards: files.protein(wildcards).molecule_options,
    message:
        "Surface and minimal subset of {wildcards.protein}/{wildcards.conformation}"
    script:
        "../scripts/take_all_steps.py"
