# The paper beside it, where `paper` names the protein that is its A1.

A1 = {"protein": config["paper"], "conformation": "c1"}
OF_A1 = (
    ROUGH_SURFACE | GRID | RANGES | BEST | FLOORS | ENOUGH | inside(CONFORMATION, bins="rough_and_flat.csv")
)


rule reproduce_paper:
    input:
        **{key: path.format(**A1) for key, path in OF_A1.items()},
    output:
        **inside(RUN, runs="paper_as_published.csv", places="paper_places.csv", tests="paper_tests.csv"),
        **inside(RUN, links="paper_links.csv", defects="paper_defects.csv", family="paper_family.csv"),
        **figure(f"{RUN}/table1", "Table I, published and made again", "table1", "The paper"),
        html=shown(f"{RUN}/verdict.html", "Claim by claim", "verdict", "The paper"),
        rows=shown(f"{RUN}/paper_rows.csv", "Table I, row by row", "paper_rows", "The paper"),
    log:
        f"{LOGS}/reproduce_paper.log",
    threads: THREADS
    params:
        **made_by("reproduce_paper.py", "surface", "patches", "sampling", "evaluation", "seed"),
        path_to_surface=files.proteins[config["paper"]].surface,
        name="/".join(A1.values()),
    message:
        "Comparing with the paper"
    script:
        "../scripts/reproduce_paper.py"
