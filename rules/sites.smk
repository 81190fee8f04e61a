# Sites that are sought on other surfaces, and forms that are compared, for those that `sites` names.

SITE = f"{RUN}/sites/{{site}}"
SITE_LOGS = f"{LOGS}/sites/{{site}}"
HITS = inside(SITE, hits="hits.csv", matches="matches.csv", poses="poses.csv")


rule describe_places:
    input:
        **(SURFACE | KERNELS),
        structure=files.structure,
    output:
        sites=f"{CONFORMATION}/places.sites",
    log:
        f"{CONFORMATION_LOGS}/describe_places.log",
    wildcard_constraints:
        protein=one_of(sites.proteins),
    resources:
        **needs("describe_places", files.dots),
    params:
        **made_by("describe_places.py"),
    message:
        "Places of {wildcards.protein}/{wildcards.conformation} in numbers"
    script:
        "../scripts/describe_places.py"


rule find_site:
    input:
        unpack(sites.places),
    output:
        **HITS,
        superposed=directory(f"{SITE}/superposed"),
        page=f"{SITE}/site.html",
    log:
        f"{SITE_LOGS}/find_site.log",
    wildcard_constraints:
        site=one_of(sites.sought),
    params:
        **made_by("find_site.py"),
        site=sites.site,
    message:
        "Seeking the site {wildcards.site}"
    script:
        "../scripts/find_site.py"


rule draw_site:
    input:
        unpack(sites.surfaces),
        **(HITS | KERNELS),
    output:
        **figure(f"{SITE}/site", "{site}", "site", "Sites"),
        view_1=shown(f"{SITE}/view_1.html", "{site} to turn", "site_view", "Sites"),
        view_2=shown(f"{SITE}/view_2.html", "{site}, best hit to turn", "site_view", "Sites"),
    log:
        f"{SITE_LOGS}/draw_site.log",
    wildcard_constraints:
        site=one_of(sites.sought),
    localrule: True
    params:
        **made_by("draw_site.py", "patches", *defects, "seed"),
        site=sites.site,
    message:
        "Pictures of the site {wildcards.site} and its hits"
    script:
        "../scripts/draw_site.py"


if len(sites.sought) > 1:

    rule summarise_sites:
        input:
            hits=expand(HITS["hits"], site=sites.sought),
        output:
            **figure(f"{RUN}/sites/matrix", "All sites on all surfaces", "matrix", "Sites"),
            matrix=f"{RUN}/sites/matrix.csv",
        log:
            f"{LOGS}/summarise_sites.log",
        localrule: True
        params:
            **made_by("summarise_sites.py"),
        message:
            "All sites on all surfaces"
        script:
            "../scripts/summarise_sites.py"


rule compare_forms:
    input:
        unpack(sites.forms),
        **KERNELS,
    output:
        **{f"pdb_{side}": f"{SITE}/changed_{side}.pdb" for side in (1, 2)},
        changes=f"{SITE}/changes.csv",
        page=f"{SITE}/changes.html",
    log:
        f"{SITE_LOGS}/compare_forms.log",
    wildcard_constraints:
        site=one_of(sites.compared),
    threads: THREADS
    params:
        **made_by("compare_forms.py", "surface", "patches.D_link", "seed"),
        site=sites.site,
    message:
        "Comparing the forms of {wildcards.site}"
    script:
        "../scripts/compare_forms.py"


rule draw_changes:
    input:
        unpack(sites.forms),
        changes=rules.compare_forms.output.changes,
    output:
        **figure(f"{SITE}/changes", "{site}", "changes", "Sites"),
        view_1=shown(f"{SITE}/view_1.html", "{site}, form 1 to turn", "site_view", "Sites"),
        view_2=shown(f"{SITE}/view_2.html", "{site}, form 2 to turn", "site_view", "Sites"),
    log:
        f"{SITE_LOGS}/draw_changes.log",
    wildcard_constraints:
        site=one_of(sites.compared),
    localrule: True
    params:
        **made_by("draw_changes.py", "patches", *defects, "seed"),
        site=sites.site,
    message:
        "Pictures of the changes of {wildcards.site}"
    script:
        "../scripts/draw_changes.py"
