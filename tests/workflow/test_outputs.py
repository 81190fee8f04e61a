"""Outputs of rules and how the report shows them."""

import re
from types import SimpleNamespace

from snakemake.io import IOFile, temp, touch

from conftest import ROOT, WORKFLOW
from sparsurf.workflow.outputs import CAPTIONS, Outputs, figure, inside, shown


def test_files_of_a_folder_have_names():
    assert inside("a/{b}", x="x.csv", y="z.md") == {"x": "a/{b}/x.csv", "y": "a/{b}/z.md"}
    assert inside("a") == {}


def test_the_report_shows_a_file_among_those_of_its_protein():
    whole = shown("r/summary.csv", "All", "summary").flags["report"]
    assert (whole.category, whole.subcategory, whole.labels) == ("All surfaces", None, {"result": "All"})
    of_protein = shown("r/{protein}/frames.png", "F", "frames").flags["report"]
    assert (of_protein.category, of_protein.subcategory) == ("{protein}", None)
    of_conformation = shown("r/{protein}/{conformation}/x.png", "F", "frames").flags["report"]
    assert (of_conformation.category, of_conformation.subcategory) == ("{protein}", "{conformation}")
    assert shown("r/pairs/{pair}/x.png", "F", "book", "Pairs").flags["report"].category == "Pairs"


def test_a_caption_may_be_missing_only_where_there_is_none():
    assert shown("x.png", "F", "frames").flags["report"].caption == str(CAPTIONS / "frames.rst")
    assert shown("x.png", "F", "no such").flags["report"].caption is None
    named = re.findall(r'(?:shown|figure|of_each)\((?:f?".*?"), "[^"]*", "(\w+)"', WORKFLOW)
    assert len(named) > 15
    assert all((ROOT / "src/sparsurf/report/captions" / f"{name}.rst").is_file() for name in named)


def test_a_figure_is_two_files():
    found = figure("r/a", "A", "frames")
    assert found == {"png": "r/a.png", "svg": "r/a.svg"}
    assert found["png"].flags["report"].labels == {"result": "A"}


def test_the_guide_to_the_results_names_what_the_rules_make_and_nothing_else():
    said = (ROOT / "results" / "README.md").read_text(encoding="utf-8")
    ends = "csv|json|html|ply|npz|pdb|cif|dms|png|pml|cxc|bild|sites"  # beside each png lies its svg
    named = set(re.findall(rf"`(?:[^`]*/)?(\w+\.(?:{ends}))`", said)) - {"report.html"}  # made from them all
    made = set(re.findall(rf'[/"](\w[\w{{}}]*\.(?:{ends}))"', WORKFLOW))
    made |= {f"{name}.png" for name in re.findall(r'figure\(\s*f?"[^"]*?(\w+)"', WORKFLOW)} | {"grid.csv"}
    made = {each.replace("{side}", side) for each in made for side in "12"}
    assert len(named) > 60 and named == made, sorted(named ^ made)


def outputs(without=(), has_frames=lambda name: True, steps=False, **rules):
    """Outputs of a run of the proteins p (a molecule of two frames) and q (a surface), and of a pair."""
    found = []
    for name, files in rules.items():
        rule = SimpleNamespace(name=f"theirs_{name}", log=[f"logs/{{protein}}/{name}.log"])
        rule.pathvars = SimpleNamespace(apply=str)
        rule.output = [IOFile(file, rule=rule) for file in files]
        found.append(rule)
    files = SimpleNamespace(
        run="r",
        proteins={"p": 1, "q": 1},
        conformations={"p": ["f0", "f7"], "q": ["c1"]}.get,
        has_frames=has_frames,
        steps_over_frames=lambda name: steps,
        goes_without=lambda *place: "/".join(place) in without,
    )
    return Outputs(SimpleNamespace(rules=found), files, pair=SimpleNamespace(names=["one"]))


RULES = {
    "frames": ["r/{protein,p}/frames.csv", shown("r/{protein,p}/frames.png", "F", "frames")],
    "grid": ["r/{protein}/{conformation}/grid.csv", temp("r/{protein}/{conformation}/part.csv")],
    "fetch": ["r/{protein}/download/{file}"],
    "pair": ["r/pairs/{pair}/dots.csv"],
    "all_of_it": ["r/summary.csv"],
    "page": ["r/index.html"],
    "mark": [touch("r/{protein}/.complete")],
    "rule_of_another_workflow": ["their.csv", "rr/{protein}.csv"],
}


def test_what_a_run_has_follows_from_its_rules():
    own, p, q = outputs(**RULES), SimpleNamespace(protein="p"), SimpleNamespace(protein="q")
    assert own.of_protein(p) == ["r/p/frames.csv", "r/p/frames.png", "r/p/f0/grid.csv", "r/p/f7/grid.csv"]
    assert own.of_protein(q) == ["r/q/c1/grid.csv"]
    assert own.of_place(SimpleNamespace(place="pairs/one")) == ["r/pairs/one/dots.csv"]
    assert own.of_run() == ["r/summary.csv", "r/index.html"] and own.places == ["pairs/one"]
    p_alone = ["r/p/frames.csv", "r/p/frames.png"]  # before the conformations are chosen
    each = [p_alone, own.of_protein(p), [], own.of_protein(q), ["r/pairs/one/dots.csv"]]
    assert [ask(None) for ask in own.each()] == each
    everything = {*own.of_protein(p), *own.of_protein(q), "r/pairs/one/dots.csv", "r/summary.csv"}
    assert {*own.all_but("r/index.html")(None)} == everything
    assert own.all_but("r/index.html", shown=True)(None) == ["r/p/frames.png"]
    assert {*own.all_but("r/index.html", shown=False)(None)} == everything - {"r/p/frames.png"}


def test_frames_are_drawn_only_where_there_are_several():
    rules, p = {"draw_frames": RULES["frames"], "grid": RULES["grid"]}, SimpleNamespace(protein="p")
    assert "r/p/frames.png" in outputs(**rules).of_protein(p)
    alone = outputs(has_frames=lambda name: name != "p", **rules)
    assert alone.of_protein(p) == ["r/p/f0/grid.csv", "r/p/f7/grid.csv"]
    rules["draw_ensemble"] = ["r/{protein}/ensemble.html"]
    for steps, ensemble in (
        (False, []),
        (True, ["r/p/ensemble.html"]),
    ):  # over the frames of one that is chosen
        alone = outputs(has_frames=lambda name: name != "p", steps=steps, **rules)
        assert alone.of_protein(p) == [*ensemble, "r/p/f0/grid.csv", "r/p/f7/grid.csv"]
    # which is known only after the conformations are chosen
    assert next(ask(None) for ask in outputs(**rules).each()) == []


def test_a_run_goes_without_a_job():
    own = outputs(without=["p/frames", "page"], **RULES)
    assert own.of_protein(SimpleNamespace(protein="p")) == ["r/p/f0/grid.csv", "r/p/f7/grid.csv"]
    assert own.of_run() == ["r/summary.csv"]
    own = outputs(without=["p/*"], **RULES)
    assert own.of_protein(SimpleNamespace(protein="p")) == ["r/p/f0/grid.csv", "r/p/f7/grid.csv"]
    assert all(type(path) is str for path in own.all_but()(None))  # without the flags of the report
