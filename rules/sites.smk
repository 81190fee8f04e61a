# Sites that are searched for on other surfaces, and forms of a protein that are compared, for each entry of `sites`.


rule describe_places:
    input:
        surface="results/{run}/{protein}/{conformation}/surface.npz",
        structure=structure_of_conformation,
    output:
        sites="results/{run}/{protein}/{conformation}/places.sites",
    log:
        "results/{run}/logs/{protein}/{conformation}/describe_places.log",
    wildcard_constraints:
        protein=any_of(DESCRIBED),
    conda:
        "../envs/study.yaml"
    resources:
        mem_mb=lambda wildcards, input, attempt: attempt * (1000 + 40 * input.size_mb),
    params:
        code=METHOD,
    message:
        "Describing the places of {wildcards.protein}/{wildcards.conformation}"
    script:
        "../scripts/describe_places.py"


rule find_site:
    input:
        unpack(searched_places),
    output:
        hits="results/{run}/sites/{site}/hits.csv",
        matches="results/{run}/sites/{site}/matches.csv",
        poses="results/{run}/sites/{site}/poses.csv",
        superposed=directory("results/{run}/sites/{site}/superposed"),
        page="results/{run}/sites/{site}/site.html",
    log:
        "results/{run}/logs/sites/{site}/find_site.log",
    wildcard_constraints:
        site=any_of(SEARCHES),
    conda:
        "../envs/study.yaml"
    params:
        site=lambda wildcards: SITES[wildcards.site],
        code=[METHOD, REPORT],
    message:
        "Searching for the site {wildcards.site}"
    script:
        "../scripts/find_site.py"


rule draw_site:
    input:
        unpack(searched_surfaces),
        hits="results/{run}/sites/{site}/hits.csv",
        poses="results/{run}/sites/{site}/poses.csv",
    output:
        png=in_report("results/{run}/sites/{site}/site.png", "{site}", "Sites"),
        view_1=in_report(
            "results/{run}/sites/{site}/view_1.html", "{site} to turn", "Sites", caption="site_view"
        ),
        view_2=in_report(
            "results/{run}/sites/{site}/view_2.html",
            "{site}, best hit to turn",
            "Sites",
            caption="site_view",
        ),
    log:
        "results/{run}/logs/sites/{site}/draw_site.log",
    wildcard_constraints:
        site=any_of(SEARCHES),
    localrule: True
    conda:
        "../envs/study.yaml"
    params:
        site=lambda wildcards: SITES[wildcards.site],
        patches=config["patches"],
        seed=config["seed"],
        code=REPORT,
    message:
        "Pictures of the site {wildcards.site} and its hits"
    script:
        "../scripts/draw_site.py"


rule summarise_sites:  # of several searches
    input:
        hits=expand("results/{{run}}/sites/{site}/hits.csv", site=SEARCHES),
    output:
        matrix="results/{run}/sites/matrix.csv",
        png=in_report("results/{run}/sites/matrix.png", "All sites on all surfaces", "Sites"),
    log:
        "results/{run}/logs/summarise_sites.log",
    localrule: True
    conda:
        "../envs/study.yaml"
    params:
        code=REPORT,
    message:
        "All sites on all surfaces"
    script:
        "../scripts/summarise_sites.py"


rule compare_forms:
    input:
        unpack(compared_forms),
    output:
        changes="results/{run}/sites/{site}/changes.csv",
        pdb_1="results/{run}/sites/{site}/changed_1.pdb",
        pdb_2="results/{run}/sites/{site}/changed_2.pdb",
        page="results/{run}/sites/{site}/changes.html",
    log:
        "results/{run}/logs/sites/{site}/compare_forms.log",
    wildcard_constraints:
        site=any_of(COMPARISONS),
    conda:
        "../envs/study.yaml"
    threads: 8
    params:
        forms=lambda wildcards: SITES[wildcards.site]["changes"],
        surface=config["surface"],
        d_link=config["patches"]["D_link"],
        seed=config["seed"],
        code=[METHOD, REPORT],
    message:
        "Comparing the forms of {wildcards.site}"
    script:
        "../scripts/compare_forms.py"


rule draw_changes:
    input:
        unpack(compared_forms),
        changes="results/{run}/sites/{site}/changes.csv",
    output:
        png=in_report("results/{run}/sites/{site}/changes.png", "{site}", "Sites"),
        view_1=in_report(
            "results/{run}/sites/{site}/view_1.html", "{site}, form 1 to turn", "Sites", caption="site_view"
        ),
        view_2=in_report(
            "results/{run}/sites/{site}/view_2.html", "{site}, form 2 to turn", "Sites", caption="site_view"
        ),
    log:
        "results/{run}/logs/sites/{site}/draw_changes.log",
    wildcard_constraints:
        site=any_of(COMPARISONS),
    localrule: True
    conda:
        "../envs/study.yaml"
    params:
        forms=lambda wildcards: SITES[wildcards.site]["changes"],
        patches=config["patches"],
        seed=config["seed"],
        code=REPORT,
    message:
        "Pictures of the changes of {wildcards.site}"
    script:
        "../scripts/draw_changes.py"
