# docs/complexes.md: what propensity finds over many complexes, and what few centres are worth.

COMPLEX = config["complexes"]
# In this order: each is compared with the one before, as a control
PAIRS = plan.pairs(source.known)
BEFORE = dict(zip(list(PAIRS)[1:], PAIRS))


def files_of(pair):
    """Both structures of a complex."""
    return [source.path(name) for name in PAIRS[pair]]


def partners(wildcards):
    """The structures of a complex, of its bound form, and of the complex before it."""
    own = {"own": files_of(wildcards.pair)}
    if wildcards.pair.endswith("_u"):
        own["bound"] = files_of(wildcards.pair.removesuffix("_u"))
    if wildcards.pair in BEFORE:
        own["other"] = files_of(BEFORE[wildcards.pair])
    return own


wildcard_constraints:
    pair=one_of(PAIRS),
    descriptor=one_of(COMPLEX["descriptors"]),


complexes = chains.add(
    "complexes",
    COMPLEX | {"pairs": PAIRS},
    scripts=["measure_complex.py", "tabulate_complexes.py"],
    tables=["complexes", "complexes_means", "complexes_variants"]
    + ["complexes_contacts", "complexes_control", "complexes_cpu"],
)


rule measure_complex:
    input:
        unpack(partners),
    output:
        **{
            key: f"{OUT}/complexes/{{descriptor}}/{{pair}}/{key}.csv"
            for key in ("areas", "contacts", "control")
        },
    log:
        f"{LOGS}/complexes/{{descriptor}}/{{pair}}/measure_complex.log",
    params:
        **chains.made_by("measure_complex.py", {"patches": COMPLEX["patches"]}),
        pair="{pair}",
        descriptor="{descriptor}",
    message:
        "Propensity of {wildcards.pair}, {wildcards.descriptor} descriptor"
    script:
        "../measure_complex.py"


rule tabulate_complexes:
    input:
        **{
            key: expand(
                f"{OUT}/complexes/{{descriptor}}/{{pair}}/{key}.csv",
                descriptor=COMPLEX["descriptors"],
                pair=PAIRS,
            )
            for key in ("areas", "contacts", "control")
        },
    output:
        touch(complexes.mark),
        **complexes.tables,
    log:
        f"{LOGS}/tabulate_complexes.log",
    localrule: True
    params:
        **chains.made_by("tabulate_complexes.py"),
        logs=f"{LOGS}/complexes",
        chosen_on=COMPLEX["chosen_on"],
    message:
        "Tables over many complexes"
    script:
        "../tabulate_complexes.py"


thinned = chains.add(
    "thinning",
    COMPLEX["thinning"],
    scripts=["thin_complex.py", "tabulate_thinning.py"],
    tables=["complexes_thinning", "complexes_thinning_means", "thinning_cpu"],
    figures=["complexes_thinning"],
)


rule thin_complex:
    input:
        own=lambda wildcards: files_of(wildcards.pair),
    output:
        table=f"{OUT}/thinning/{{pair}}.csv",
    log:
        f"{LOGS}/thinning/{{pair}}/thin_complex.log",
    params:
        **chains.made_by("thin_complex.py", {key: COMPLEX["thinning"][key] for key in ("percents", "draws")}),
        pair="{pair}",
    message:
        "Maps of {wildcards.pair} from few centres"
    script:
        "../thin_complex.py"


rule tabulate_thinning:
    input:
        tables=expand(f"{OUT}/thinning/{{pair}}.csv", pair=COMPLEX["thinning"]["pairs"]),
    output:
        touch(thinned.mark),
        **thinned.tables,
        complexes_thinning_figure=thinned.figures["complexes_thinning"],
    log:
        f"{LOGS}/tabulate_thinning.log",
    localrule: True
    params:
        **chains.made_by("tabulate_thinning.py"),
        logs=f"{LOGS}/thinning",
    message:
        "Table and figure of few centres"
    script:
        "../tabulate_thinning.py"
