# All steps of one conformation in one job, where it is not sampled: with many structures, starting a process costs as much as a step.


ruleorder:
    analyse_conformation
    > compute_surface
    > measure_roughness
    > measure_floors
    > select_minimal_subset
    > draw_view
    > tabulate_residues


rule analyse_conformation:
    input:
        unpack(frames_around_conformation),
        structures="results/{run}/{protein}/structures",
        table=lambda wildcards: PROTEINS[wildcards.protein].table or [],
    output:
        surface="results/{run}/{protein}/{conformation}/surface.npz",
        structure="results/{run}/{protein}/{conformation}/structure.pdb",
        dms="results/{run}/{protein}/{conformation}/surface.dms",
        components="results/{run}/{protein}/{conformation}/components.csv",
        roughness="results/{run}/{protein}/{conformation}/roughness.csv",
        floors="results/{run}/{protein}/{conformation}/floors.csv",
        floor_distances="results/{run}/{protein}/{conformation}/floor_distances.npz",
        minimal="results/{run}/{protein}/{conformation}/minimal.csv",
        ply="results/{run}/{protein}/{conformation}/minimal.ply",
        whole="results/{run}/{protein}/{conformation}/surface.ply",
        recovered="results/{run}/{protein}/{conformation}/recovered.csv",
        required_dots="results/{run}/{protein}/{conformation}/required_dots.csv",
        curves="results/{run}/{protein}/{conformation}/curves.csv",
        fields="results/{run}/{protein}/{conformation}/fields.npz",
        fields_recovered="results/{run}/{protein}/{conformation}/fields.csv",
        page=in_report("results/{run}/{protein}/{conformation}/view.html", "Turn, sample and pick dots"),
        picture="results/{run}/{protein}/{conformation}/view.png",
        residues=in_report("results/{run}/{protein}/{conformation}/residues.csv", "Residue by residue"),
        pdb="results/{run}/{protein}/{conformation}/structure_roughness.pdb",
        cif="results/{run}/{protein}/{conformation}/structure_roughness.cif",
        pml="results/{run}/{protein}/{conformation}/open.pml",
        cxc="results/{run}/{protein}/{conformation}/open.cxc",
        bild="results/{run}/{protein}/{conformation}/minimal.bild",
    log:
        "results/{run}/logs/{protein}/{conformation}/analyse_conformation.log",
    wildcard_constraints:
        protein=any_of([name for name in MOLECULES if name not in SAMPLED]),
    conda:
        "../envs/study.yaml"
    resources:
        mem_mb=lambda wildcards, input, attempt: attempt * (1000 + 20 * input.size_mb),
    params:
        surface=config["surface"],
        patches=config["patches"],
        distance_from_moved_centre=config["sampling"]["distance_from_moved_centre"],
        chance_in_every_patch=config["sampling"]["chance_in_every_patch"],
        test_dots=config["evaluation"]["test_dots"],
        minimal=config["minimal"],
        fields=config["fields"],
        seed=config["seed"],
        title=title_of_page,
        molecule_options=lambda wildcards: PROTEINS[wildcards.protein].molecule_options,
        code=[METHOD, REPORT],
    message:
        "Surface and minimal subset of {wildcards.protein}/{wildcards.conformation}"
    script:
        "../scripts/analyse_conformation.py"
