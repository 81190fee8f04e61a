# docs/complexes.md: how well complementarity finds the interface of many complexes, and how many centres it needs.

# In this order: each complex is compared with the one before, as a control
PREVIOUS_COMPLEX = dict(zip(list(COMPLEXES)[1:], COMPLEXES))


def partners(wildcards):
    """Structures of both partners of a complex."""
    return [structure_file(name) for name in COMPLEXES[wildcards.pair]]


def bound_partners(wildcards):
    """Structures of the bound form of a complex given as NAME_u; none for others."""
    if not wildcards.pair.endswith("_u"):
        return []
    return [structure_file(name) for name in COMPLEXES[wildcards.pair.removesuffix("_u")]]


def control_partners(wildcards):
    """Structures of the complex before this one; none for the first."""
    names = COMPLEXES.get(PREVIOUS_COMPLEX.get(wildcards.pair), ())
    return [structure_file(name) for name in names]


wildcard_constraints:
    descriptor=one_of(config["complexes"]["descriptors"]),


rule measure_complex:
    input:
        partners=ancient(partners),
        bound=ancient(bound_partners),
        control=ancient(control_partners),
    output:
        areas=f"{RESULTS}/complexes/{{descriptor}}/{{pair}}/areas.csv",
        contacts=f"{RESULTS}/complexes/{{descriptor}}/{{pair}}/contacts.csv",
        control=f"{RESULTS}/complexes/{{descriptor}}/{{pair}}/control.csv",
    log:
        f"{RESULTS}/logs/complexes/{{descriptor}}/{{pair}}/measure_complex.log",
    params:
        patches=config["complexes"]["patches"],
    message:
        "Complementarity of {wildcards.pair}, {wildcards.descriptor} descriptor"
    script:
        "../measure_complex.py"


rule tabulate_complexes:
    input:
        areas=expand(
            f"{RESULTS}/complexes/{{descriptor}}/{{pair}}/areas.csv",
            descriptor=config["complexes"]["descriptors"],
            pair=COMPLEXES,
        ),
        contacts=expand(
            f"{RESULTS}/complexes/{{descriptor}}/{{pair}}/contacts.csv",
            descriptor=config["complexes"]["descriptors"],
            pair=COMPLEXES,
        ),
        control=expand(
            f"{RESULTS}/complexes/{{descriptor}}/{{pair}}/control.csv",
            descriptor=config["complexes"]["descriptors"],
            pair=COMPLEXES,
        ),
    output:
        complexes=f"{TABLES}/complexes.csv",
        complexes_means=f"{TABLES}/complexes_means.csv",
        complexes_variants=f"{TABLES}/complexes_variants.csv",
        complexes_contacts=f"{TABLES}/complexes_contacts.csv",
        complexes_control=f"{TABLES}/complexes_control.csv",
        complexes_cpu=f"{TABLES}/complexes_cpu.csv",
    log:
        f"{RESULTS}/logs/tabulate_complexes.log",
    localrule: True
    params:
        chosen_on=config["complexes"]["chosen_on"],
        logs=f"{RESULTS}/logs/complexes",
    message:
        "Tables over many complexes"
    script:
        "../tabulate_complexes.py"


rule thin_complex:
    input:
        partners=ancient(partners),
    output:
        table=f"{RESULTS}/thinning/{{pair}}.csv",
    log:
        f"{RESULTS}/logs/thinning/{{pair}}/thin_complex.log",
    params:
        percents=config["complexes"]["thinning"]["percents"],
        draws=config["complexes"]["thinning"]["draws"],
    message:
        "Maps of {wildcards.pair} from few centres"
    script:
        "../thin_complex.py"


rule tabulate_thinning:
    input:
        tables=expand(f"{RESULTS}/thinning/{{pair}}.csv", pair=config["complexes"]["thinning"]["pairs"]),
    output:
        complexes_thinning=f"{TABLES}/complexes_thinning.csv",
        complexes_thinning_means=f"{TABLES}/complexes_thinning_means.csv",
        thinning_cpu=f"{TABLES}/thinning_cpu.csv",
        figure=f"{FIGURES}/complexes_thinning.png",
    log:
        f"{RESULTS}/logs/tabulate_thinning.log",
    localrule: True
    params:
        logs=f"{RESULTS}/logs/thinning",
    message:
        "Tables and figure of few centres"
    script:
        "../tabulate_thinning.py"
