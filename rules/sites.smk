# Sites that are sought on other surfaces, for those that `sites` names.

SITE = f"{RUN}/sites/{{site}}"
SITE_LOGS = f"{LOGS}/sites/{{site}}"
PLACES = inside(CONFORMATION, sites="places.sites")
HITS = inside(SITE, hits="hits.csv", matches="matches.csv", poses="poses.csv")


wildcard_constraints:
    site=one_of(sites.names),


rule complete_site:
    input:
        outputs.of_named,
    output:
        touch(f"{SITE}/.complete"),


rule describe_places:
    input:
        **(SURFACE | KERNELS),
        structure=files.structure,
    output:
        **PLACES,
    log:
        f"{CONFORMATION_LOGS}/describe_places.log",
    wildcard_constraints:
        protein=one_of(sites.proteins),
    threads: THREADS
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
    log:
        f"{SITE_LOGS}/draw_site.log",
    localrule: True
    params:
        **made_by("draw_site.py"),
        site=sites.site,
    message:
        "Pictures of the site {wildcards.site} and its hits"
    script:
        "../scripts/draw_site.py"
