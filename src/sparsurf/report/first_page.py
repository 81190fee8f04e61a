"""The first page of a run: what was studied, the answers as cards, the figure, the ranges, where to look."""

import re
from pathlib import Path

import pandas as pd

from sparsurf.recovery.readings import RECOVERED, readings_of_columns
from sparsurf.report.numbers import against_zero, combination, interval, number, share, span
from sparsurf.report.site_page import by_rarity, found_on

TEMPLATE = "first.html.j2"
NAMES = ["protein", "conformation"]
FRESH = "fresh dots"
AT = 10  # % of the dots, at which samplers are compared
LEAST = 1.05  # times fewer dots that a bound must promise to be worth a card
SHOWN = 20  # surfaces, or pairs, that get pictures
OF_ALL = ("surfaces", "summary", "relation")  # tables over all surfaces; the last two follow from the grid
OF_ROW = ("minimal.csv", "residues.csv")  # files of a surface that its row leads to
OF_EACH = 3  # surfaces that get a table of ranges of their own
PAGES = ("ranges", "compare", "ensemble")  # of a surface or a protein, that its heading leads to
OF_SITE = ("site", "changes")  # pages of a site, and their figures
TAKEN = {  # files of a surface to take along, what each is
    "minimal.csv": "the minimal subset: places, normals, weights",
    "minimal.ply": "the same for 3D programs",
    "surface.ply": "the whole surface with its roughness",
    "residues.csv": "area, roughness and fields of each residue",
    "structure_roughness.pdb": "the structure, roughness as B factors",
    "open.pml": "opens all of this in PyMOL",
    "open.cxc": "opens all of this in ChimeraX",
    "ranges.csv": "the best combination per range of n_S",
    "grid.csv": "Z and d of every combination",
    "floors.csv": "the noise floors",
    "enough.csv": "how many dots reach each floor",
    "fields.csv": "what few dots give back of each field",
}


def first_page(folder, held, beside, without=(), floor=FRESH):
    """What the template asks for.

    Parameters
    ----------
    folder : Path, results/<run>
    held, beside : sequence of str
        Files that the page may read and lead to, paths from `folder`: those that the report holds, and others.
    without : sequence of (protein, pairs/<name> or sites/<name>, reason)
        What could not be finished.
    floor : str or None
        The noise floor that the minimal subset goes by, None where the config asks for another one.
    """
    folder, files = Path(folder), dict.fromkeys([*held, *beside])
    places = [
        tuple(path.split("/")[:2]) for path in files if path.count("/") == 2 and path.endswith("/enough.csv")
    ]
    first = "/".join(places[0]) if places else ""
    sampled = "summary.csv" in files  # else the views stand in the rows
    other = [path for path in files if not path.endswith("/view.html")]
    return {
        "run": folder.name,
        "without": list(without),
        "warnings": warned(folder / "warnings.csv"),
        "surfaces": of_surfaces(folder, files, places, floor) if places else None,
        "fields": of_fields([read(folder, path) for path in files if path.endswith("/fields.csv")]),
        "paper": of_paper(read(folder, "paper_places.csv")) if "paper_places.csv" in files else None,
        "compared": compared(read(folder, "compare_needed.csv")) if "compare_needed.csv" in files else None,
        "pairs": of_pairs(
            read(folder, "pairs/means.csv"), read(folder, "pairs/pairs.csv"), len(pairs_in(files))
        )
        if "pairs/means.csv" in files
        else None,
        "sites": [
            (path.split("/")[1], of_site(read(folder, path))) for path in files if path.endswith("/hits.csv")
        ],
        "changes": [
            (path.split("/")[1], of_changes(read(folder, path)))
            for path in files
            if path.endswith("/changes.csv")
        ],
        "ensembles": [
            (path.split("/")[0], of_ensemble(read(folder, path.replace(".html", ".csv"))))
            for path in files
            if path.endswith("/ensemble.html")
        ],
        "main_figure": main_figure(folder, files, first),
        "galleries": galleries(places, files if sampled else other)
        + pair_galleries(files)
        + site_galleries(files),
        "taken_from": first,
        "taken": [(f"{first}/{name}", words) for name, words in TAKEN.items() if f"{first}/{name}" in files],
    }


def read(folder, path):
    """A table of the run; names stay text, "012", "1E96" and "NA" too."""
    names = dict.fromkeys([*NAMES, "complex", "bound"], str)
    table = pd.read_csv(folder / path, dtype=names, keep_default_na=False, na_values=[""])
    return table.fillna({"bound": ""})


def of_surfaces(folder, files, places, floor):
    """What the page says of the surfaces at `places`, see `numbers`; without a grid a row for each, see `rows_of`."""
    tables = {name: read(folder, f"{name}.csv") for name in OF_ALL if f"{name}.csv" in files}
    for name in {"surfaces", "summary"} & tables.keys():
        tables[name] = tables[name].set_index(NAMES).loc[places].reset_index()
    surfaces = tables.pop("surfaces")
    enough = pd.concat([read(folder, f"{'/'.join(place)}/enough.csv") for place in places])
    known = {
        "proteins": surfaces["protein"].drop_duplicates().tolist(),
        "dots": span(surfaces["N"], "{:,.0f}".format),
        "roughness": span(surfaces["mean_roughness"]),
        "n_surfaces": len(surfaces),
        "enough": enough_card(surfaces, enough, floor),
        "d": [],
        "rows": [] if tables else rows_of(surfaces, files),
    }
    return known | (numbers(surfaces, **tables) if tables else {})


def rows_of(surfaces, files):
    """One surface a row: its name, its page, the picture of that, files to take along, and its numbers as text."""
    rows = []
    for row in surfaces.to_dict("records"):
        start = f"{row['protein']}/{row['conformation']}/"
        page, picture, *taken = (f"{start}{name}" for name in ("view.html", "view.png", *OF_ROW))
        cells = [f"{row['N']:,}", number(row["area"], 0), number(row["mean_roughness"])]
        cells += [f"{row['minimal_n_S']:,}", share(row["minimal_n_S_percent"])]
        taken = [path for path in taken if path in files]
        rows.append((start[:-1], page, picture if picture in files else "", taken, cells))
    return rows


def main_figure(folder, files, first):
    """The large figure: that over all surfaces, else that of the first, else what there is."""
    for path in (
        "enough.png",
        f"{first}/figures/enough.png",
        f"{first}/figures/d_over_grid.png",
        "pairs/pairs.png",
    ):
        empty = (
            path.startswith("pairs/") and path in files and read(folder, "pairs/means.csv").empty
        )  # none touches
        if path in files and not empty:
            return {"path": path, "name": Path(path).stem}
    return None


def numbers(surfaces, summary, relation):
    """What the page says of the grids of the surfaces.

    Parameters
    ----------
    surfaces, summary, relation : DataFrame
        surfaces.csv, summary.csv and relation.csv of the run.

    Returns
    -------
    dict, by the names that the template asks for
    """
    readings = readings_of_columns(surfaces, "best_")
    places = surfaces[NAMES].drop_duplicates().to_numpy().tolist()
    return {
        "d": [d_card(summary, reading, readings[0]) for reading in readings],
        "readings": readings,
        "ranges": [
            ("/".join(place), ranges_rows(summary[(summary[NAMES] == place).all(axis=1)], readings))
            for place in places[:OF_EACH]
        ],
        "over_all": over_all(summary, relation, readings) if len(places) > 1 else [],
    }


def enough_card(surfaces, enough, floor):
    """From which share of the dots the surface comes back as well as by a floor; None where that was not measured.

    Where the minimal subsets go by no floor, `handed_out` is their share, and the card tells what would be enough for fresh dots.
    """
    own = enough[(enough["floor"] == (floor or FRESH)) & (enough["reading"] == RECOVERED)]
    if own.empty:
        return None
    minimal = surfaces.get("minimal_n_S_percent")
    percents, bounds = own["n_S_percent"], set(own.get("bound", ()))
    return {
        "bound": bounds.pop() if len(bounds) == 1 else "",
        "percent": share(percents.median()),
        "span": span(percents, share),
        "floor": floor or FRESH,
        "handed_out": "" if floor or minimal is None else share(minimal.median()),
        "sampler": own["sampler"].iloc[0],
        "every_dot": bool((percents >= 100).all()),
    }


def d_card(summary, reading, first):
    """d of the best combination in the range of n_S where that of the reading `first` is largest, over the surfaces."""
    best = summary[(summary["reading"] == first) & summary["d_held_out"].notna()]
    best = best.loc[best.groupby(NAMES)["d_held_out"].idxmax(), [*NAMES, "range"]]
    own = summary[summary["reading"] == reading].merge(best, on=[*NAMES, "range"])
    own = own.dropna(subset=["d_held_out"])
    if own.empty:
        return {"reading": reading, "d": None}
    places = [against_zero(*ends) for ends in own[["d_held_out_low", "d_held_out_high"]].to_numpy()]
    return {
        "reading": reading,
        "d": number(own["d_held_out"].median(), 1),
        "n_S": share(own["n_S_percent"].median()),
        "n": len(own),
        "places": {name: places.count(name) for name in ("above", "below", "around", "unknown")},
    }


def ranges_rows(own, readings):
    """Rows of the table of ranges of one surface: n_S, then combination and d with its interval by reading."""
    rows = []
    for _, of_range in own.groupby("range"):
        by = of_range.set_index("reading")
        row = [f"{number(by['n_S_low_percent'].iloc[0], 0)} – {number(by['n_S_high_percent'].iloc[0], 0)}"]
        for reading in readings:
            one = by.loc[reading]
            row += [combination(one), interval(*one[["d_held_out", "d_held_out_low", "d_held_out_high"]])]
        rows.append(row)
    return rows


def over_all(summary, relation, readings):
    """The same over several surfaces: the combination that is best on average, median d (lowest to highest)."""
    rows = []
    for k, of_range in relation.groupby("range"):
        by = of_range.set_index("reading")
        row = [f"{number(by['n_S_low_percent'].iloc[0], 0)} – {number(by['n_S_high_percent'].iloc[0], 0)}"]
        for reading in readings:
            d = summary[(summary["reading"] == reading) & (summary["range"] == k)]["d_held_out"].dropna()
            d_text = interval(d.median(), d.min(), d.max()) if len(d) else ""
            row += [combination(by.loc[reading]), d_text]
        rows.append(row)
    return rows


def compared(needed):
    """How many times fewer dots the farthest-point sampler needs than a uniform subset; None where that was not measured."""
    own = needed[(needed["measure"] == "Z as_written") & (needed["sampler"] == "farthest")]
    own = own[(own["than"] == "uniform") & (own["use"] == "surface")]
    own = own[~own["bound"].astype(str).str.startswith("more") | (own["factor"] >= LEAST)]
    if own.empty:
        return None
    row = own.loc[(own["percent"] - AT).abs().idxmin()]
    return {
        "factor": number(row["factor"], 1),
        "bound": row["bound"].strip(),
        "percent": share(row["percent"]),
    }


def of_fields(tables):
    """How well the minimal subset gives each field back, the median over surfaces: list of (field, r); empty without fields."""
    if not tables:
        return []
    own = pd.concat(tables).query("subset == 'minimal'").dropna(subset=["r"])
    return [(name, number(of_one["r"].median(), 3)) for name, of_one in own.groupby("field", sort=False)]


def of_paper(places):
    """In how many ranges the published d lies among those of the runs made as published."""
    own = places[places["binning"] == "half-open"].dropna(subset=["d_lowest"])
    inside = (own["d_published"] >= own["d_lowest"]) & (own["d_published"] <= own["d_highest"])
    return {"inside": int(inside.sum()), "rows": len(own), "runs": int(own["n_runs"].max())}


def of_pairs(means, table, n):
    """How well the maps of those of `n` pairs that touch find the interface."""
    found = {"n": n, "touching": table["complex"].nunique(), "auc": None}
    own = means[means["score"] == "propensity_smoothed"]
    if len(own):
        row = own.iloc[0]
        found |= {"auc": number(row["mean"]), "place": against_zero(row["low"] - 0.5, row["high"] - 0.5)}
    return found


def of_site(hits):
    """On how many targets a site is found, and the clearest of them."""
    return {"n": found_on(hits), "targets": len(hits), "best": by_rarity(hits)["target"].iloc[0]}


def of_changes(table):
    """How many residues change from one form to another, by more than moved atoms do."""
    return {"n": int(table["above_moved"].sum()), "residues": int(table["total"].count())}


def of_ensemble(table):
    """d of one combination over the frames of a trajectory, under the first reading of the table."""
    reading = readings_of_columns(table, "d_")[0]
    d = table[f"d_{reading}"].dropna()
    sd = number(d.std(ddof=1), 1)
    return {"frames": len(table), "reading": reading, "d": number(d.mean(), 1), "sd": sd}


def galleries(surfaces, files):
    """Pictures: heading, pages in words and list of (page, picture, name), of each protein and each surface (the first
    ones of many).

    Parameters
    ----------
    surfaces : list of (protein, conformation)
    files : iterable of str
        Paths from the folder of the run that the page may lead to.
    """
    found = []
    for protein in list(dict.fromkeys(protein for protein, _ in surfaces))[:SHOWN]:
        places = [f"{p}/{c}/" for p, c in surfaces[:SHOWN] if p == protein]
        for start in [f"{protein}/", *places]:
            view = f"{start}view.html"
            picture = f"{start}view.png"
            items = [(view, picture if picture in files else "", "view")] * (view in files)
            items += [(path, path, name) for path, name in pictures(start, files)]
            led = [(f"{start}{name}.html", name) for name in PAGES if f"{start}{name}.html" in files]
            found.append((start[:-1], led, items))
    return [each for each in found if each[2]]


def pictures(start, pages):
    """Figures directly below the folder `start`, with their names."""
    begin = f"{start}figures/"
    for path in pages:
        name = path.removeprefix(begin).removesuffix(".png")
        if path == f"{begin}{name}.png" and "/" not in name:
            yield path, name


def pairs_in(files):
    """Names of the pairs that have files."""
    of_pairs = (path for path in files if path.startswith("pairs/") and path.count("/") > 1)
    return list(dict.fromkeys(path.split("/")[1] for path in of_pairs))


def pair_galleries(files):
    """The same of pairs."""
    found = []
    for name in pairs_in(files)[:SHOWN]:
        start = f"pairs/{name}/"
        shown = [(f"{start}book.png",) * 2 + ("book",), (f"{start}view_1.html", "", "view_1")]
        shown += [(f"{start}view_2.html", "", "view_2"), (f"{start}thinning.png",) * 2 + ("thinning",)]
        led = [(f"{start}pair.html", "pair")] * (f"{start}pair.html" in files)
        found.append((name, led, [each for each in shown if each[0] in files]))
    return [each for each in found if each[2]]


def site_galleries(files):
    """The same of sites, and of forms that were compared."""
    matrix = "sites/matrix.csv", "sites/matrix.png"
    found = [("all sites", [(matrix[0], "matrix")], [(matrix[1],) * 2 + ("matrix",)])] * (matrix[1] in files)
    for path in files:
        folder, _, name = path.removesuffix(".html").rpartition("/")
        if folder.startswith("sites/") and name in OF_SITE and path.endswith(".html"):
            shown = [(f"{folder}/{name}.png",) * 2 + (name,)]
            shown += [(f"{folder}/view_{side}.html", "", f"view_{side}") for side in (1, 2)]
            found.append((folder.split("/")[1], [(path, name)], [each for each in shown if each[0] in files]))
    return found[:SHOWN]


def warned(path):
    """(places, sentence) of the warnings.csv of a run; those that differ in numbers only are told once, as the first says it.

    A file is named without its folder. Empty where there is no such table.
    """
    if not path.is_file():
        return []
    table = pd.read_csv(path, dtype=str, keep_default_na=False)
    places = ["/".join(filter(None, place)) for place in table[NAMES].to_numpy().tolist()]
    alike = {}
    for place, sentence in dict.fromkeys(zip(places, table["sentence"], strict=True)):
        said = re.sub(r"^\S*/(?=\S+: )", "", sentence.removeprefix(f"{place}: "))
        names = "|".join(re.escape(name) for name in place.split("/"))
        kind = re.sub(rf"\b({names})\b|[0-9][0-9.,]*", "", said)
        alike.setdefault(kind, (said, []))[1].append(place)
    return [(each, said) for said, each in alike.values()]
