# Pairs: what the patches of one partner say of the other's, for those that `pairs` names.

PAIR = f"{RUN}/pairs/{{pair}}"
PAIR_LOGS = f"{LOGS}/pairs/{{pair}}"
DOTS = inside(PAIR, dots="propensity.csv")


rule make_partners:
    input:
        unpack(pairs.given),
        **KERNELS,
    output:
        **{f"surface_{side}": f"{PAIR}/surface_{side}.npz" for side in (1, 2)},
        **{f"structure_{side}": f"{PAIR}/structure_{side}.pdb" for side in (1, 2)},
    log:
        f"{PAIR_LOGS}/make_partners.log",
    wildcard_constraints:
        pair=one_of(pairs.alone),
    localrule: True
    params:
        **made_by("make_partners.py", "surface", "patches.D_link"),
        contents=pairs.contents,
        pair=pairs.pair,
    message:
        "Surfaces of both partners of {wildcards.pair}"
    script:
        "../scripts/make_partners.py"


rule match_partners:
    input:
        unpack(pairs.partners("surface", "structure")),
        **KERNELS,
    output:
        **DOTS,
        **{f"ply_{side}": f"{PAIR}/partner_{side}.ply" for side in (1, 2)},
        **inside(PAIR, best="best_pairs.csv", agreement="agreement.csv", contacts="contacts.csv"),
        page=f"{PAIR}/pair.html",
    log:
        f"{PAIR_LOGS}/match_partners.log",
    threads: THREADS
    params:
        **made_by("match_partners.py", "patches", "complementarity", "seed"),
        pair=pairs.pair,
    message:
        "Comparing the patches of both partners of {wildcards.pair}"
    script:
        "../scripts/match_partners.py"


rule tabulate_pair_residues:
    input:
        unpack(pairs.partners("structure")),
        **DOTS,
    output:
        **{f"pdb_{side}": f"{PAIR}/partner_{side}.pdb" for side in (1, 2)},
        **inside(PAIR, residues="residues.csv", pml="open.pml", cxc="open.cxc"),
    log:
        f"{PAIR_LOGS}/tabulate_pair_residues.log",
    wildcard_constraints:
        pair=one_of(pairs.with_atoms),
    localrule: True
    params:
        **made_by("tabulate_pair_residues.py"),
    message:
        "Propensity of the residues of {wildcards.pair}"
    script:
        "../scripts/tabulate_pair_residues.py"


rule draw_pair:
    input:
        unpack(pairs.partners("surface", "structure")),
        **(DOTS | KERNELS),
    output:
        **figure(f"{PAIR}/book", "{pair}", "book", "Pairs"),
        view_1=shown(f"{PAIR}/view_1.html", "{pair}, partner 1 to turn", "pair_view", "Pairs"),
        view_2=shown(f"{PAIR}/view_2.html", "{pair}, partner 2 to turn", "pair_view", "Pairs"),
    log:
        f"{PAIR_LOGS}/draw_pair.log",
    localrule: True
    params:
        **made_by("draw_pair.py", "patches", *defects, "seed"),
    message:
        "Pictures of both partners of {wildcards.pair}"
    script:
        "../scripts/draw_pair.py"


if config["complementarity"]["thinning"]["run"]:

    rule thin_pair:
        input:
            unpack(pairs.partners("surface", "structure")),
            **KERNELS,
        output:
            **figure(f"{PAIR}/thinning", "{pair}, fewer centres", "thinning", "Pairs"),
            table=f"{PAIR}/thinning.csv",
        log:
            f"{PAIR_LOGS}/thin_pair.log",
        params:
            **made_by("thin_pair.py", "patches", *defects, "complementarity", "seed"),
        message:
            "Maps of {wildcards.pair} from fewer centres"
        script:
            "../scripts/thin_pair.py"


rule summarise_pairs:
    input:
        tables=expand(f"{PAIR}/agreement.csv", pair=pairs.names),
    output:
        **inside(pairs.folder, table="pairs.csv", page="pairs.html"),
        **figure(f"{pairs.folder}/pairs", "All pairs", "pairs", "Pairs"),
        means=shown(f"{pairs.folder}/means.csv", "Means over pairs", "pairs", "Pairs"),
    log:
        f"{LOGS}/summarise_pairs.log",
    localrule: True
    params:
        **made_by("summarise_pairs.py"),
    message:
        "Agreement with the interface, over all pairs"
    script:
        "../scripts/summarise_pairs.py"
