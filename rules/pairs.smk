# Pairs: how well the patches of both partners match, for each entry of `pairs`.


rule compute_partner_surfaces:
    input:
        files=files_of_pair,
    output:
        surface_1="results/{run}/pairs/{pair}/surface_1.npz",
        surface_2="results/{run}/pairs/{pair}/surface_2.npz",
        structure_1="results/{run}/pairs/{pair}/structure_1.pdb",
        structure_2="results/{run}/pairs/{pair}/structure_2.pdb",
    log:
        "results/{run}/logs/pairs/{pair}/compute_partner_surfaces.log",
    localrule: True
    conda:
        "../envs/study.yaml"
    params:
        pair=entry_of_pair,
        surface=config["surface"],
        d_link=config["patches"]["d_link"],
        inputs=stamps_of(files_of_pair),
        code=CODE["numbers"],
    message:
        "Surfaces of both partners of {wildcards.pair}"
    script:
        "../scripts/compute_partner_surfaces.py"


rule match_partners:
    input:
        unpack(partner_files),
    output:
        dots="results/{run}/pairs/{pair}/propensity.csv",
        best="results/{run}/pairs/{pair}/best_pairs.csv",
        agreement="results/{run}/pairs/{pair}/agreement.csv",
        contacts="results/{run}/pairs/{pair}/contacts.csv",
        ply_1="results/{run}/pairs/{pair}/partner_1.ply",
        ply_2="results/{run}/pairs/{pair}/partner_2.ply",
    log:
        "results/{run}/logs/pairs/{pair}/match_partners.log",
    conda:
        "../envs/study.yaml"
    threads: 8
    params:
        pair=entry_of_pair,
        patches=config["patches"],
        centres=config["complementarity"]["centres"],
        smoothing=config["complementarity"]["smoothing"],
        interface=config["complementarity"]["interface"],
        seed=config["seed"],
        code=CODE["numbers"],
    message:
        "Comparing the patches of both partners of {wildcards.pair}"
    script:
        "../scripts/match_partners.py"


rule tabulate_pair_residues:
    input:
        unpack(partner_files),
        dots="results/{run}/pairs/{pair}/propensity.csv",
    output:
        pdb_1="results/{run}/pairs/{pair}/partner_1.pdb",
        pdb_2="results/{run}/pairs/{pair}/partner_2.pdb",
        residues="results/{run}/pairs/{pair}/residues.csv",
        pml="results/{run}/pairs/{pair}/open.pml",
        cxc="results/{run}/pairs/{pair}/open.cxc",
    log:
        "results/{run}/logs/pairs/{pair}/tabulate_pair_residues.log",
    localrule: True
    conda:
        "../envs/study.yaml"
    params:
        code=CODE["pages"],
    message:
        "Propensity of the residues of {wildcards.pair}"
    script:
        "../scripts/tabulate_pair_residues.py"


rule draw_pair:
    input:
        unpack(partner_files),
        dots="results/{run}/pairs/{pair}/propensity.csv",
        agreement="results/{run}/pairs/{pair}/agreement.csv",
    output:
        png=in_report("results/{run}/pairs/{pair}/book.png"),
        view=in_report("results/{run}/pairs/{pair}/view.html"),
    log:
        "results/{run}/logs/pairs/{pair}/draw_pair.log",
    localrule: True
    conda:
        "../envs/study.yaml"
    params:
        surface=part_of("surface", "probe_radius", "radii", "reentrant", "cavities"),
        patches=config["patches"],
        sampling=part_of("sampling", *RULES_OF_SAMPLING),
        seed=config["seed"],
        code=CODE["pages"],
    message:
        "Pictures of both partners of {wildcards.pair}"
    script:
        "../scripts/draw_pair.py"


rule summarise_pairs:
    input:
        tables=expand("results/{{run}}/pairs/{pair}/agreement.csv", pair=PAIRS),
    output:
        table="results/{run}/pairs/pairs.csv",
        png=in_report("results/{run}/pairs/pairs.png"),
    log:
        "results/{run}/logs/summarise_pairs.log",
    localrule: True
    conda:
        "../envs/study.yaml"
    params:
        code=CODE["pages"],
    message:
        "Agreement with the interface, over all pairs"
    script:
        "../scripts/summarise_pairs.py"
