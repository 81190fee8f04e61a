# docs/finding_sites.md: sites of a bound form searched on the unbound form, and the effect of fewer dots.

import csv
from importlib.util import find_spec

SITES = config["sites"]
FORMS = list(dict.fromkeys(name.split("_")[0] for name in names_in_set(STRUCTURES, "sites")))[
    : SITES["complexes"]
]
# Each protein of a family with each relative: name -> family, query, relative
RELATIVES = {
    f"{query}-{relative}": {"family": family, "query": query, "relative": relative}
    for family, members in SITES["relatives"].items()
    for query in members
    for relative in members
    if query != relative and {query, relative} <= STRUCTURES.keys()
} | {  # and each protein with itself, of the half that the shipped weights do not know
    f"{name}-{name}": {"family": "the same protein", "query": name, "relative": name}
    for name in (f"{form}_{side}" for form in FORMS[1::2] for side in "rl")
}
PAIRS_OF_RELATIVES = [pair for pair in RELATIVES.values() if pair["family"] != "the same protein"]


# Chains of different superfamilies, searched for sites that they do not have. Without their folder p is not fitted again
UNRELATED = SITES["unrelated"]
CHAINS = [row["chain"] for row in csv.DictReader(open(HOME / SITES["chains"]))]
QUERY_CHAINS = CHAINS[: UNRELATED["chains"]]
INTERFACES = [f"{form}_{side}" for form in FORMS[1::2] for side in "rl"][: UNRELATED["interfaces"]]


def chains_from(number):
    """Paths of places of the next chains of the half that a query of this number belongs to."""
    chains = [CHAINS[(number + 2 * (k + 1)) % len(CHAINS)] for k in range(UNRELATED["targets"])]
    return expand(f"{RESULTS}/unrelated/{{chain}}.sites", chain=chains)


def unrelated_targets(wildcards):
    """Places of the chains on which groups of a chain are searched."""
    return chains_from(CHAINS.index(wildcards.chain))


def interface_targets(wildcards):
    """Places of the chains on which an interface is searched."""
    return chains_from(INTERFACES.index(wildcards.query))


def partner_of(query):
    """Name of the partner of a protein: NAME_l for NAME_r and NAME_r for NAME_l."""
    name, side = query.split("_")
    return f"{name}_{'l' if side == 'r' else 'r'}"


def bound_forms(wildcards):
    """Bound structures of both partners of a complex."""
    return [structure_file(f"{wildcards.form}_{side}") for side in "rl"]


def unbound_forms(wildcards):
    """Unbound structures of both partners of a complex."""
    return [structure_file(f"{wildcards.form}_{side}_u") for side in "rl"]


def query_structure(wildcards):
    """Bound structure of the protein whose sites are searched on a relative."""
    return structure_file(RELATIVES[wildcards.relatives]["query"])


def query_partner(wildcards):
    """Bound structure of the partner of that protein: NAME_l for NAME_r and NAME_r for NAME_l."""
    return structure_file(partner_of(RELATIVES[wildcards.relatives]["query"]))


def relative_structure(wildcards):
    """Unbound structure of the relative."""
    return structure_file(RELATIVES[wildcards.relatives]["relative"] + "_u")


wildcard_constraints:
    form=one_of(FORMS),
    relatives=one_of(RELATIVES),
    chain=one_of(CHAINS),
    query=one_of(INTERFACES),


rule measure_forms:
    input:
        bound=ancient(bound_forms),
        unbound=ancient(unbound_forms),
    output:
        numbers=[
            f"{RESULTS}/sites/{{form}}/numbers_1.npz",
            f"{RESULTS}/sites/{{form}}/numbers_2.npz",
        ],
        targets=[
            f"{RESULTS}/sites/{{form}}/target_1.sites",
            f"{RESULTS}/sites/{{form}}/target_2.sites",
        ],
        sites=[
            f"{RESULTS}/sites/{{form}}/site_1.sites",
            f"{RESULTS}/sites/{{form}}/site_2.sites",
        ],
        costs=f"{RESULTS}/sites/{{form}}/costs.csv",
    log:
        f"{RESULTS}/logs/sites/{{form}}/measure_forms.log",
    params:
        percents=SITES["percents"],
        places=SITES["places"],
        learned=SITES["learned"],
        seed=config["seed"],
    message:
        "Places of {wildcards.form} on both forms"
    script:
        "../measure_forms.py"


rule score_sites:
    input:
        numbers=expand(f"{RESULTS}/sites/{{form}}/numbers_{{side}}.npz", form=FORMS, side=(1, 2)),
        targets=expand(f"{RESULTS}/sites/{{form}}/target_{{side}}.sites", form=FORMS, side=(1, 2)),
        sites=expand(f"{RESULTS}/sites/{{form}}/site_{{side}}.sites", form=FORMS, side=(1, 2)),
        costs=expand(f"{RESULTS}/sites/{{form}}/costs.csv", form=FORMS),
    output:
        sites=f"{TABLES}/sites.csv",
        sites_means=f"{TABLES}/sites_means.csv",
        sites_moved=f"{TABLES}/sites_moved.csv",
        sites_whole=f"{TABLES}/sites_whole.csv",
        sites_summary=f"{TABLES}/sites_summary.csv",
        sites_costs=f"{TABLES}/sites_costs.csv",
        weights=f"{LIBRARY}/sites/weights.npz",
    log:
        f"{RESULTS}/logs/score_sites.log",
    params:
        forms=FORMS,
    message:
        "How often sites are found again"
    script:
        "../score_sites.py"


rule describe_chain:
    input:
        structure=f"{DATA}/chains/{{chain}}.pdb.gz",
    output:
        sites=f"{RESULTS}/unrelated/{{chain}}.sites",
    log:
        f"{RESULTS}/logs/unrelated/{{chain}}/describe_chain.log",
    message:
        "Places of {wildcards.chain}"
    script:
        "../describe_chain.py"


rule search_unrelated:
    input:
        sites=f"{RESULTS}/unrelated/{{chain}}.sites",
        targets=unrelated_targets,
    output:
        table=f"{RESULTS}/unrelated/{{chain}}.csv",
    log:
        f"{RESULTS}/logs/unrelated/{{chain}}/search_unrelated.log",
    params:
        half=lambda wildcards: 1 + CHAINS.index(wildcards.chain) % 2,
        seed=config["seed"],
    message:
        "Groups of {wildcards.chain} on other chains"
    script:
        "../search_unrelated.py"


rule search_interface:
    input:
        bound=ancient(lambda wildcards: structure_file(wildcards.query)),
        partner=ancient(lambda wildcards: structure_file(partner_of(wildcards.query))),
        unbound=ancient(lambda wildcards: structure_file(wildcards.query + "_u")),
        targets=interface_targets,
    output:
        table=f"{RESULTS}/unrelated/interfaces/{{query}}.csv",
    log:
        f"{RESULTS}/logs/unrelated/{{query}}/search_interface.log",
    params:
        half=lambda wildcards: 1 + INTERFACES.index(wildcards.query) % 2,
        seed=config["seed"],
    message:
        "Parts of the interface of {wildcards.query} on other chains"
    script:
        "../search_interface.py"


rule calibrate_sites:
    input:
        tables=expand(f"{RESULTS}/unrelated/{{chain}}.csv", chain=QUERY_CHAINS)
        + expand(f"{RESULTS}/unrelated/interfaces/{{query}}.csv", query=INTERFACES),
    output:
        searches=f"{TABLES}/sites_searches.csv",
        sites_chance=f"{TABLES}/sites_chance.csv",
        null=update(f"{LIBRARY}/sites/null.csv"),  # kept until it is replaced: the searches read it
    log:
        f"{RESULTS}/logs/calibrate_sites.log",
    message:
        "Scores of unrelated proteins"
    script:
        "../calibrate_sites.py"


CHANCE_TABLES = []
if DATA and Path(DATA, "chains").is_dir() and QUERY_CHAINS:
    CHANCE_TABLES = [
        f"{TABLES}/sites_searches.csv",
        f"{TABLES}/sites_chance.csv",
        f"{LIBRARY}/sites/null.csv",
    ]
elif workflow.is_main_process:
    print("sites_chance.csv is left out: it needs chains/ in EVIDENCE_DATA.", file=sys.stderr)


rule draw_sites:
    input:
        means=f"{TABLES}/sites_means.csv",
    output:
        figure=f"{FIGURES}/finding_sites.png",
    log:
        f"{RESULTS}/logs/draw_sites.log",
    localrule: True
    message:
        "Figure of finding sites"
    script:
        "../draw_sites.py"


rule measure_relatives:
    input:
        bound=ancient(query_structure),
        partner=ancient(query_partner),
        relative=ancient(relative_structure),
        weights=f"{LIBRARY}/sites/weights.npz",
    output:
        table=f"{RESULTS}/relatives/{{relatives}}.csv",
    log:
        f"{RESULTS}/logs/relatives/{{relatives}}.log",
    params:
        family=lambda wildcards: RELATIVES[wildcards.relatives]["family"],
        query=lambda wildcards: RELATIVES[wildcards.relatives]["query"],
        relative=lambda wildcards: RELATIVES[wildcards.relatives]["relative"],
        places=SITES["places_on_relatives"],
        seed=config["seed"],
    message:
        "Places of {wildcards.relatives}"
    script:
        "../measure_relatives.py"


rule tabulate_relatives:
    input:
        tables=expand(f"{RESULTS}/relatives/{{relatives}}.csv", relatives=RELATIVES),
    output:
        table=f"{TABLES}/sites_relatives.csv",
        means=f"{TABLES}/sites_relatives_means.csv",
    log:
        f"{RESULTS}/logs/tabulate_relatives.log",
    localrule: True
    params:
        identity=SITES["identity"],
    message:
        "How often places are found on the same protein and on relatives"
    script:
        "../tabulate_relatives.py"


rule measure_cofactors:
    input:
        sites=f"{DATA}/cofactors/sites.csv",
    output:
        table=f"{TABLES}/cofactors.csv",
        means=f"{TABLES}/cofactors_means.csv",
    log:
        f"{RESULTS}/logs/measure_cofactors.log",
    message:
        "Sites of cofactors across folds"
    script:
        "../measure_cofactors.py"


rule learn_cofactors:
    input:
        sites=f"{DATA}/cofactors/sites.csv",
        answers=f"{TABLES}/cofactors.csv",
        queries=ancient([structure_file(pair["query"]) for pair in PAIRS_OF_RELATIVES]),
        relatives=ancient([structure_file(pair["relative"] + "_u") for pair in PAIRS_OF_RELATIVES]),
    output:
        table=f"{TABLES}/cofactors_learned.csv",
        means=f"{TABLES}/cofactors_learned_means.csv",
    log:
        f"{RESULTS}/logs/learn_cofactors.log",
    params:
        seed=config["seed"],
    message:
        "Sites of cofactors across folds by learned weights"
    script:
        "../learn_cofactors.py"


COFACTOR_TABLES = []
if DATA and Path(DATA, "cofactors", "sites.csv").is_file() and find_spec("tmtools"):
    COFACTOR_TABLES = [
        f"{TABLES}/cofactors.csv",
        f"{TABLES}/cofactors_means.csv",
        f"{TABLES}/cofactors_learned.csv",
        f"{TABLES}/cofactors_learned_means.csv",
    ]
elif workflow.is_main_process:
    print(
        "cofactors.csv is left out: it needs cofactors/ in EVIDENCE_DATA, and pip install tmtools.",
        file=sys.stderr,
    )
