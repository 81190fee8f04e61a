"""Pages of the small study: each number is in a table of the run, in the place that the page says; each link leads to a file."""

import json
import re
from string import Formatter
from urllib.parse import unquote, urldefrag

import pandas as pd
import pytest

from parsed_pages import Page
from sparsurf.report.page import TEMPLATES
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.study.statistics import mean_interval

BOTH = ("kept", "full")
PARAMETERS = ["alpha", "beta", "gamma", "delta"]
NUMBER = re.compile(r"(?<![\w.,–−-])[−-]?\d[\d,]*(?:\.\d+)?(?![\w–])")
LABELS = {name: about.label for name, about in SAMPLERS.items()} | {"dotted": "sparsely placed dots"}
TEMPLATE_OF = {"index": "first", "verdict": "paper"}
# In no table of the run: claims, and what tests/paper computes by hand
UNTABLED = (
    "claim of the paper",
    "figure",
    "α, β, γ, δ",
    "centres of patches",
)  # first cells of tables and rows
COMPUTED = (
    r"patches stay is \S+",
    r"is \S+ too high",
    r"d peaks .*",
    r"In \S+ % of the .*",
    r"A dot lies in \S+",
)
COMPUTED += (r"\d+ more", r"It may be the best in \d+", r"is ours in \d+ of 10")


def rounded(x, digits=2):
    """Return a number as pages show it: rounded once, with a true minus, without the sign of a 0, a dash if unknown.

    The tables are rounded, too, so a number half way between two may be either on its page: ‹0.52|0.53›.
    """
    return "–" if pd.isna(x) else within(x, 1e-9, digits)


def within(x, by, digits=2):
    """Return all roundings of numbers that differ from one by at most so much, ‹a|b› if there are several."""
    found = {f"{x + k * by / 10:z.{digits}f}".replace("-", "−") for k in range(-10, 11)}
    return f"‹{'|'.join(sorted(found))}›" if len(found) > 1 else found.pop()


def share(x):
    """Return a share in %: whole from 10 to 99, otherwise with one decimal if that is not 0."""
    return rounded(x, 0 if 9.95 <= x < 99.5 else 1).removesuffix(".0")


def ends(values, form=rounded):
    """Return the lowest to the highest value."""
    low, high = form(min(values)), form(max(values))
    return low if low == high else f"{low} to {high}"


def limits(x, low, high, digits=2):
    """Return a number with its limits if it has any."""
    return rounded(x, digits) + (
        "" if pd.isna(low) else f" ({rounded(low, digits)} to {rounded(high, digits)})"
    )


class Cells(Formatter):
    """Fills in a row: {x} and {x:1} a number with two and one decimals, {x:%} a share, {x:ci} its limits, {x:ci end} x_end."""

    def get_value(self, key, args, row):
        return row, key

    def format_field(self, value, form):
        row, key = value
        x = row.get(key)
        if key == "combination":
            return "–" if pd.isna(row["alpha"]) else f"({', '.join(f'{row[name]:g}' for name in PARAMETERS)})"
        if form.startswith("ci"):
            end = form[2:].replace(" ", "_")
            return limits(*(row[f"{key}{name}{end}"] for name in ("", "_low", "_high")))
        if isinstance(x, str):
            return LABELS.get(x, x)
        known = {"%": share, ",": "{:,.0f}".format, "g": "{:g}".format, "d": "{:.0f}".format}
        return known[form](x) if form in known else rounded(x, int(form or 2))


def filled(table, *cells):
    """Return the cells of each row of a table."""
    return [[Cells().format(cell, **row) for cell in cells] for row in table.to_dict("records")]


def spoken(reading):
    return reading.replace("_", " ")


def best_of_ranges(folder):
    """Return what ranges.html should show: the rows of its tables, and sentences."""
    best, ranges = json.loads((folder / "best.json").read_text()), pd.read_csv(folder / "ranges.csv")
    columns = [
        "{n_S_low_percent:1} – {n_S_high_percent:1}",
        "{combination}",
        "{n_S_percent:1}",
        "{d_cv:ci}",
        "{Z_tS}",
    ]
    of_all, tables, sentences = [], [], []
    for reading in BOTH:
        own = ranges[ranges["reading"] == reading]
        tables.append(filled(own, *columns, "{median_patch_size:0}", "{n_best_set:0}"))
        found = (best[reading][name] for name in ("unrestricted", "under_max_n_S"))
        words = "{combination} keeps {n_S_percent:%} %d = {d_cv:ci}"
        cells = [row.get("answer") or Cells().format(words, **row) for row in found]
        every = "It keeps every dot." * (best[reading]["unrestricted"]["n_S_percent"] > 99.995)
        of_all.append([spoken(reading), cells[0] + every, cells[1]])
        own = own.dropna(subset="d_cv_low")
        above = (own["Z_tS"] > best["references"]["Z_mean_descriptor"]).sum()
        counts = (own["d_cv_low"] > 0).sum(), len(own), (own["d_cv_high"] < 0).sum()
        sentences.append("beats a uniform subset in {} of {} ranges of nS and loses in {}.".format(*counts))
        sentences += [f"In {above} its Z exceeds that of the mean patch."] * bool(above)
    z = [best["references"][f"Z_{name}"] for name in ("empty", "two_patches", "mean_descriptor")]
    names = ("an empty patch", "two different patches", "the mean patch in place of every patch")
    floors = [*zip(names, z, strict=True), *best["references"]["floors"].items()]
    return [of_all, *tables, [[name, rounded(z)] for name, z in floors]], sentences


def over_time(folder):
    """Return what ensemble.html should show."""
    table = pd.read_csv(folder / "ensemble.csv")
    columns = {"N": ("dots", 0), "area": ("area / Å²", 0), "mean_roughness": ("mean roughness", 3)}
    columns |= {
        "n_S_percent": ("n_S / %", 1),
        "d_kept": ("d as coded", 2),
        "d_full": ("d as written", 2),
    }
    cells = [
        [words, *(rounded(x, digits) for x in table[column].agg(["mean", "std", "min", "max"]))]
        for column, (words, digits) in columns.items()
    ]
    n_s, *d = (f"{row[1]} ± {row[2]}" for row in cells[3:])
    answer = f"Over {len(table)} frames, combination (1, 0, 6, 0) keeps {n_s} % of the dots."
    return [cells], [answer, *(f"{spoken(r).capitalize()}, d is {x}." for r, x in zip(BOTH, d, strict=True))]


def changed(folder):
    """Return what changes.html should show."""
    table = pd.read_csv(folder / "changes.csv", na_values=[""], keep_default_na=False)
    floor = table[["total_floor", "total_moved"]].max(axis=1)
    table = table.loc[(table["total"] / floor).sort_values(ascending=False).index].head(10)
    channels = [
        name.removesuffix("_floor") for name in table if name.endswith("_floor") and name != "total_floor"
    ]
    ratios = [
        {name: row[name] / row[f"{name}_floor"] for name in channels} for row in table.to_dict("records")
    ]
    most = [sorted((name for name in r if r[name] > 1), key=lambda name: -r[name])[:2] for r in ratios]
    signs = {
        name: table[f"{name}_difference"].round(1).gt(0).map({True: "+", False: ""})
        for name in ("potential", "hydropathy")
    }
    table = table.assign(
        most=[", ".join(names) or "–" for names in most], plus=signs["potential"], more=signs["hydropathy"]
    )
    cells = filled(
        table, "{residue_name}{residue:d}", "{total}", "{total_floor}", "{total_moved}", "{most}",
        "{plus}{potential_difference:1}", "{more}{hydropathy_difference:1}",
    )  # fmt: skip
    n = f"{table['above'].sum()} of {len(floor)} residues change more than fresh dots explain; 0 would by chance."
    return [cells], [n, f"{table['above_moved'].sum()} change more than", f"{cells[0][0]} changes most"]


def claimed(run):
    """Return what verdict.html should show of the surface ready/c1, after the two tables of claims."""
    folder, names = run / "ready/c1", ("rows", "places", "tests", "links", "defects", "family")
    own, places, tests, links, defects, family = (pd.read_csv(run / f"paper_{name}.csv") for name in names)
    names = ("grid", "ranges", "rough_and_flat", "required_dots", "roughness")
    grid, ranges, bins, required, roughness = (pd.read_csv(folder / f"{name}.csv") for name in names)
    best, null = json.loads((folder / "best.json").read_text()), own["Z_mean_descriptor"].iloc[0]
    runs = places[places["binning"] == "half-open"].reset_index(drop=True)
    rows = own.assign(row=runs["range"]).join(runs.loc[:, ~runs.columns.isin(own.columns)])
    for name in ("d", "Z_tS"):
        rows[f"runs_{name}"] = rows[f"{name}_mean"]
        rows[f"runs_{name}_low"], rows[f"runs_{name}_high"] = rows[f"{name}_lowest"], rows[f"{name}_highest"]
        published, known = places[f"{name}_published"], places[f"{name}_lowest"].notna()
        inside = published.between(places[f"{name}_lowest"], places[f"{name}_highest"])
        outside = places[known & ~inside].groupby("binning")["range"].agg(lambda of: ", ".join(map(str, of)))
        of_measure = tests["measure"] == name
        tests.loc[of_measure, "outside"] = tests.loc[of_measure, "binning"].map(outside).fillna("none")
    tests["p"] = [f"{p:.2g}" if p >= 1e-4 else "below 0.0001" for p in tests["p"]]
    tests = tests.replace("Z_tS", "ZtS").fillna({"outside": "–"})
    rows["won"] = rows["n_won"].astype(str) + " of " + rows["n_runs"].astype(str)
    ours = [filled(ranges[ranges["reading"] == reading], "{combination}") for reading in BOTH]
    winners = [row[:2] + coded + written + row[2:] for row, coded, written in
               zip(filled(rows, "{row:d}", "{combination}", "{won}"), *ours, strict=True)]  # fmt: skip
    published = grid[(grid[PARAMETERS] == [1, 0, 6, 0]).all(axis=1)]
    shown = [bins[bins["bin"] == f"{half} half"] for half in ("rougher", "flatter")]
    shown.append(bins[(bins["n"] >= 10) & ~bins["bin"].str.endswith("half")].groupby("around").tail(1))
    rough = [
        [
            around,
            spoken(reading),
            *(filled(of[of["around"] == around], f"{{d:ci {reading}}}")[0][0] for of in shown),
        ]
        for around in bins["around"].unique()
        for reading in BOTH
    ]
    by_link = links.pivot(index="row", columns="D_link", values="d")
    by_link = by_link.iloc[:, :: -(-by_link.shape[1] // 6)]  # at most six
    of_defect = defects.set_index(["sampling", "row"])[["n_S_percent", "d_kept", "d_full"]]
    change = (
        (of_defect - of_defect.loc["as published"])
        .groupby("sampling", sort=False)
        .mean()
        .drop("as published")
    )
    required["share"] = required["n_S_percent"].map(share)
    required.loc[required["bound"] == "at most", "share"] = "≤ " + required["share"]
    required.loc[required["bound"] == "more", "share"] = "all"
    required = required.set_index(["reading", "floor"])
    floors = required.loc["full"].assign(share_recovered=required.loc["recovered", "share"])
    per_reading = [
        {
            "reading": spoken(reading), "mean": (d := grid[f"d_{reading}"]).mean(), "largest": d.max(), "above_0": (d > 0).sum(),
            "above": (grid[f"d_low_{reading}"] > 0).sum(), "below": (grid[f"d_high_{reading}"] < 0).sum(),
            "ours": filled(published, f"{{d:ci {reading}}}")[0][0], "n": len(grid), "n_rows": len(own),
            "worse": (grid[f"Z_tS_{reading}"] > null).sum(), "worse_rows": (own[f"Z_tS_{reading}"] > null).sum(),
        }
        | best[reading]["unrestricted"]
        for reading in BOTH
    ]  # fmt: skip
    per_reading = pd.DataFrame(per_reading)
    by_percent = family.groupby("percent").agg(best=("Z_tS", "min"), uniform=("Z_tR", "mean")).reset_index()
    uniform = grid[(grid[PARAMETERS[1:]] == 0).all(axis=1)].eval("says = 100 * alpha")
    tables = [
        filled(tests, "{binning}", "{measure}", "{p}", "{outside}"),
        filled(rows, "{row:d}", "{combination}", "{d_published}", "{d:ci kept}", "{runs_d:ci}", "{d:ci full}"),
        filled(rows, "{row:d}", "{Z_tS_published}", "{Z_tS:ci kept}", "{runs_Z_tS:ci}"),
        winners,
        filled(per_reading, "{reading}", "{combination}", "{d_cv:ci}", "{n_best_set:0}", "{ours}"),
        filled(per_reading, "{reading}", "{above_0:d}", "{above:d}", "{below:d}", "{mean}", "{largest}"),
        filled(by_percent, "{percent:g}", "{best}", "{uniform}"),
        filled(per_reading, "{reading}", "{worse:d} of {n:d}", "{worse_rows:d} of {n_rows:d}"),
        rough,
        filled(uniform, "{alpha:g}", "{says:%}", "{n_S_percent:1}"),
        [[str(row), *(within(x, 0.05 if x == round(x, 1) else 1e-9) for x in d)]
         for row, d in zip(by_link.index, by_link.to_numpy(), strict=True)],  # by its error, d may have one decimal
        [[name, rounded(n, 1), within(coded, 0.01), within(written, 0.01)] for name, n, coded, written in change.itertuples()],
        filled(floors.reset_index(), "{floor}", "{Z_floor}", "{share}", "{share_recovered}"),
        [["dots", f"{len(roughness):,}", "20,045"], ["mean roughness", rounded(roughness["roughness"].mean(), 4), "0.6263"]],
    ]  # fmt: skip
    d, z = (
        own[f"{x}_published"].between(own[f"{x}_low_kept"], own[f"{x}_high_kept"]).sum()
        for x in ("d", "Z_tS")
    )
    return tables, [
        f"Here nS runs from {rounded(grid['n_S_percent'].min())} % to {rounded(grid['n_S_percent'].max())} %.",
        f"Of the 10 published d, {d} lie in", f"published Z these are {z}.", "range of 40 runs",
        f"rows runs from {ends(own['d_full'])}.", f"the {len(grid)} combinations have d above 0",
        f"exceeds {rounded(null)}, that", f"Here R runs from {ends(roughness['roughness'])}.",
        f"{(family['d_low'] > 0).sum()} of {len(family)} cases",
        f"{rounded(grid['d_kept'].corr(grid['d_full']))} over the grid",
    ]  # fmt: skip


def first_page(run):
    """Return what index.html should show."""
    surfaces, summary, relation, pairs = (
        pd.read_csv(run / f"{name}.csv") for name in ("surfaces", "summary", "relation", "pairs/pairs")
    )
    places = surfaces["protein"] + "/" + surfaces["conformation"]
    enough = pd.concat([pd.read_csv(run / place / "required_dots.csv") for place in places])
    enough = enough.query("floor == 'fresh dots' and reading == 'recovered'")
    d = summary.groupby(["reading", "range"])["d_cv"].agg(d="median", d_low="min", d_high="max").reset_index()
    best = relation.drop(columns="d").merge(d, how="left")
    cells = "{n_S_low_percent:0} – {n_S_high_percent:0}", "{combination}", "{d:ci}"
    ranges = [filled(best[best["reading"] == reading], *cells) for reading in BOTH]
    aucs, sides = pairs, pairs[["complex", "partner"]].drop_duplicates()
    pairs = pairs.pivot(index=[*sides], columns="score", values=["auc", "low", "high"]).loc[
        [*map(tuple, sides.to_numpy())]
    ]
    pairs.columns = [f"{score}_{name}".removesuffix("_auc") for name, score in pairs]
    alone = surfaces[surfaces["best_kept"].isna()]
    required = (
        "({required_percent_fresh_dots_recovered_low:%} to {required_percent_fresh_dots_recovered_high:%})"
    )
    cells = (
        "{N:,}",
        "{area:0}",
        "{mean_roughness}",
        "{minimal_n_S:,}",
        f"{{minimal_n_S_percent:%}} {required}",
    )
    tables = [
        filled(pairs.reset_index(), "{partner:0}", "{propensity_smoothed:ci}", "{protrusion:ci}"),
        filled(alone, *cells),
        [coded + written[1:] for coded, written in zip(*ranges, strict=True)],
    ]
    published = (
        pd.read_csv(run / "paper_places.csv").query("binning == 'half-open'").dropna(subset="d_lowest")
    )
    inside = published["d_published"].between(published["d_lowest"], published["d_highest"])
    frames, changes = pd.read_csv(run / "moving/ensemble.csv"), pd.read_csv(run / "changes/bend/changes.csv")
    fields = pd.concat([pd.read_csv(path) for path in run.glob("*/*/fields.csv")])
    fields = fields[fields["subset"] == "minimal"].groupby("field")["r"].median()
    z = pd.Series(
        [json.loads(path.read_text())["references"]["Z_two_patches"] for path in run.glob("*/*/best.json")]
    )
    sentences = [
        f"{len(surfaces)} surfaces of", f"{ends(surfaces['N'], '{:,}'.format)} dots each",
        f"mean roughness {ends(surfaces['mean_roughness'])}.",
        f"give Z = {rounded(surfaces['Z_frames_1_ps_apart'].median(), 1)}.",
        f"{share(enough['n_S_percent'].median())} % of the dots are enough (median; surfaces from"
        f" {ends(enough['n_S_percent'], share)} %)",
        f"within {share(enough['n_S_percent_low'].min())} to {share(enough['n_S_percent_high'].max())} %.",
        *(f"r = {rounded(r, 3)} {name}" for name, r in fields.items()), f"the median of {len(surfaces)} surfaces",
        f"{inside.sum()} of {len(inside)} published values of d lie among 40",
        f"d = {rounded(frames['d_kept'].mean(), 1)} ± {rounded(frames['d_kept'].std(), 1)}"
        f" over {len(frames)} frames",
        f"{changes['above_moved'].sum()} of {len(changes)} residues of bend", "By chance, about 0 would",
    ]  # fmt: skip
    for score, words in (
        ("propensity_smoothed", "AUC {} for smoothed"),
        ("protrusion", "Protrusion alone has {}."),
    ):
        mean, low, high = mean_interval(aucs[aucs["score"] == score].groupby("complex")["auc"].mean())
        sentences.append(words.format(limits(mean, max(0, low), min(1, high))))
    names = ["protein", "conformation"]
    coded = summary[summary["reading"] == "kept"].dropna(subset="d_cv").sort_values("d_cv")
    for reading, own in summary.merge(coded.groupby(names).tail(1)[[*names, "range"]]).groupby("reading"):
        above, below = (own["d_cv_low"] > 0).sum(), (own["d_cv_high"] < 0).sum()
        of_all = {above: "beats", below: "loses to"}
        of_all = {n: f"it {verb} a uniform subset on all {n} sampled surfaces" for n, verb in of_all.items()}
        rest = len(own) - above - below
        rest = f"; on {rest} it does not differ significantly" if rest else ""
        z_ts, z_tr, null = (rounded(own[name].median(), 1) for name in ("Z_tS", "Z_tR", "Z_mean_descriptor"))
        sentences += [
            f"d = {rounded(own['d_cv'].median())} for the paper's sampling {spoken(reading)}",
            f"with {share(own['n_S_percent'].median())} %",
            f"95 % intervals lie within {rounded(own['d_cv_low'].min())} to {rounded(own['d_cv_high'].max())}.",
            of_all.get(len(own), f"on {above} of {len(own)} surfaces and loses on {below}{rest}"),
            f"Its Z is {z_ts}, that of the uniform subset {z_tr}. If the mean patch",
            f"every patch, Z would be {null}; between two different patches it is {rounded(z.median(), 1)}.",
        ]
    return tables, sentences


PAGES = {
    "index.html": first_page,
    "verdict.html": claimed,
    "moving/ensemble.html": over_time,
    "changes/bend/changes.html": changed,
    "moving/f0000/ranges.html": best_of_ranges,
    "ready/c1/ranges.html": best_of_ranges,
}


@pytest.fixture(scope="module")
def run(study):
    """Folder of the results."""
    return study / "results" / "small"


def of_method(page):
    """Numbers that the template of a page writes itself: limits, distances and counts of the method."""
    texts = [
        (TEMPLATES / f"{name}.html.j2").read_text()
        for name in (TEMPLATE_OF.get(page, page), "parts", "words")
    ]
    texts += [(TEMPLATES / "cross_validated.j2").read_text()]
    code = re.compile(r"\{[{%](.*?)[%}]\}", re.DOTALL)
    return {
        n
        for text in texts
        for n in NUMBER.findall(code.sub(lambda m: " ".join(re.findall(r'"[^"]*"', m[1])), text))
    }


def pattern(words):
    """Return the regular expression of words in which numbers may be one of several."""
    parts = re.split("‹(.*?)›", words)  # every other one is such a number
    parts = [part if k % 2 else re.escape(part) for k, part in enumerate(parts)]
    return "".join(f"(?:{part.replace('.', '[.]')})" if k % 2 else part for k, part in enumerate(parts))


def holds(row, cells):
    """Return whether cells stand side by side in a row of a page."""
    return re.search(f"(^|\t){pattern(chr(9).join(cells))}($|\t)", "\t".join(row))


@pytest.mark.parametrize("page", PAGES)
def test_each_number_is_that_of_its_table(run, page):
    name, (tables, sentences) = page.split("/")[-1].removesuffix(".html"), PAGES[page]((run / page).parent)
    html = (run / page).read_text(encoding="utf-8")
    found = Page(re.sub(r'<details class="note".*?</details>', "", html, flags=re.DOTALL))
    shown = [table for table in found.tables if table[0][0] not in UNTABLED]
    shown = [
        [row for row in table[1:] if NUMBER.search(" ".join(row)) and row[0] not in UNTABLED]
        for table in shown
    ]
    for table, wanted in zip(shown, tables, strict=True):
        assert len(table) == len(wanted)
        for row, cells in zip(table, wanted, strict=True):
            assert holds(row, cells), f"{cells} is not in {row}"
    text = found.text
    for sentence in sentences:
        text, n = re.subn(pattern(sentence), "", text, count=1)
        assert n, f"{sentence!r} is not in {text!r}"
    for words in COMPUTED:
        text = re.sub(words, "", text)
    assert {*NUMBER.findall(text)} <= of_method(TEMPLATE_OF.get(name, name))


def test_each_link_leads_to_a_file_and_its_place(run):
    """On every page, so that a folder of results can be sent; nothing is read from another site."""
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in run.rglob("[!.]*.html")}
    assert len(pages) > 10
    for path, page in pages.items():
        for link in {*page.links, *(source for source in page.sources if not source.startswith("data:"))}:
            address, anchor = urldefrag(unquote(link))
            target = (path.parent / address).resolve() if address else path
            assert target.is_file(), f"{path}: {link}"
            assert not anchor or anchor in pages[target].anchors, f"{path}: {link}"


def test_no_page_shows_a_value_of_the_program(run):
    for path in run.rglob("[!.]*.html"):
        text = Page(path.read_text(encoding="utf-8")).text
        assert not re.search(r"\b(nan|None|inf|NaN)\b|\{\{|\bTrue\b|<[a-z]", text), path
