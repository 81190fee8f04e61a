"""The page on many proteins, from the tables that `scripts/write_proteins.py` writes."""

import pandas as pd

from sparsurf.patches.readings import TEXT
from sparsurf.recovery.readings import RECOVERED
from sparsurf.report.pages import markdown
from sparsurf.report.proteins_answer import answer, counted, interval, rho, share, signed
from sparsurf.report.recommendation import SIGNIFICANT, recommend
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.streams import stream
from sparsurf.study.protein_scores import WHOLE

STORED = (
    "d", "plateaus", "enough", "enough_means", "needed_means", "by_n_s", "correlations", "power", "coverage", "variants",
    "recovered", WHOLE,
)  # fmt: skip
AS_IS = {TEXT: "as they are", RECOVERED: "recovered"}
FAR = 2  # times the mean of Z
HYDROGENS = "hydrogens kept"  # a variant
ASKED = 10.0  # % of the dots, of the recommendation shown
CLAIMS = {
    "d_kept": "d, `kept`",
    "d_surface": "d, `surface`",
    "held": "winners that still may be the best",
    "over_floor": "Z recovered from 10 %, over fresh dots",
    "factor": "times fewer dots",
}
HOW = """`python scripts/study_proteins.py structures results/over_proteins` measures every structure of a folder, and `python
scripts/write_proteins.py results/over_proteins` writes the tables and this page. The structures are those of a
docking benchmark, one partner of each complex, and single ones; no two share more than a quarter of their runs of
five residues, so that conformations of one protein and near relatives count once. All without hydrogens, protein
only, our own dots at the density that D_link asks for. Of each: the default grid (6 draws, 200 test dots), noise
floors (3 draws, the same test dots), and uniform, farthest-point, Poisson-disk dots and the paper's Table I at ten
n_S (2 draws, 1 of surfaces above 38,000 dots; the same test dots), as they are (`surface`) and recovered (always at
5.35 dots per Å^2, less than these surfaces without hydrogens have). Recovering for every combination of the grid would
make 15,552 surfaces of each protein: `--recovered N` does it for a quarter of the grid (every second α and β, 2
draws, 48 test dots) on the N smallest, `--whole N` for all of it in as many draws. Not measured are the samplers
that choose dots by the error of the recovered surface ([recover.md](recover.md) has them). The protein is the unit
of every interval (95 %, Student's t), as it stands for the others that were not measured.

`make run CONFIG=studies/proteins.yaml` is the same study with all its outputs on 38 structures of the PDB.
"""


def page(stored):
    """The page as Markdown; `stored` are the tables of `STORED` and those of `recommendation.read_run`, by name."""
    parts = ["# Does any claim depend on the protein?\n", answer(stored), who(stored), HOW]
    parts += ["## Is d above 0?\n", of_d(stored["d"], stored.get("recovered"), stored.get(WHOLE))]
    parts += ["## Does one combination do for all?\n", of_plateaus(stored["d"], stored["plateaus"])]
    parts += ["## Does mean roughness predict the best parameters?\n", of_roughness(stored)]
    parts += ["## How many dots are enough?\n", of_enough(stored["enough_means"], stored["correlations"])]
    parts += ["## How many times fewer?\n", of_needed(stored["needed_means"], stored["by_n_s"])]
    if "variants" in stored:
        parts += ["## Which rule does a claim rest on?\n", of_variants(stored["variants"])]
    parts += ["## How often the intervals hold\n", of_coverage(stored["coverage"])]
    return "\n".join(parts)


def who(stored):
    """The proteins in a sentence."""
    one = stored["surfaces"]
    low, high = one["mean_roughness"].min(), one["mean_roughness"].max()
    return (
        f"{len(one)} proteins of {one['n_residues'].min()} to {one['n_residues'].max()} residues, {one['N'].min()} to "
        f"{one['N'].max()} dots, mean roughness {low:.3f} to {high:.3f}.\n"
    )


def of_d(table, recovered=None, whole=None):
    """d over the proteins, range by range; of the grids that were recovered where they were."""
    parts = ["![](proteins_d.png)\n"]
    readings = [*table.groupby("islands", sort=False)]
    readings += [] if recovered is None else [(RECOVERED, recovered)]
    for reading, rows in readings:
        rows = rows[rows["range"] > 0]
        short = pd.DataFrame(
            {
                "range": rows["range"],
                "n_S / %": [f"{x:.1f}" for x in rows["n_S_percent"]],
                "proteins": rows["n"],
                "own best, d held out": [interval(row, "own") for _, row in rows.iterrows()],
                "above 0 on": [f"{x:.0f}" for x in rows["n_above"]],
                "below 0 on": [f"{x:.0f}" for x in rows["n_below"]],
                "d of the choice of all others": [interval(row, "from_all") for _, row in rows.iterrows()],
                "own less that": [interval(row, "lost") for _, row in rows.iterrows()],
                "of the nearest less that": [interval(row, "near") for _, row in rows.iterrows()],
            }
        )
        parts.append(f"### islands: {reading}\n")
        if "winner" in rows:
            short.insert(3, "best on average", rows["winner"])
            n = rows["n"].max()
            some = "On all of them" if n == table["n"].max() else f"On the {n} smallest proteins"
            parts.append(
                f"{some}, a quarter of the grid, 2 draws; the sampled dots and as many "
                f"uniform ones are each made a dense surface again before they are compared. Two draws tell little of "
                f"one protein, so that few of their own intervals leave 0. {of_worst(rows)}\n"
            )
        parts.append(markdown(short))
    if whole is not None:
        parts += of_whole(whole)
    parts.append(
        "own best: the combination with the highest d on this protein, measured on test dots and draws that did not choose it; "
        "above, below: by the protein's own 95 % interval. Choice of all others: the combination with the highest "
        "mean d on the other proteins; of the nearest: on the three nearest in mean roughness.\n"
    )
    return "\n".join(parts)


def of_whole(table):
    """What the other three quarters of the grid add where all of it was recovered."""
    mean, rows = table.iloc[0], table.iloc[1:]
    short = pd.DataFrame({"range": rows["range"]})
    for grid, column in {"whole": "n_S_percent", "quarter": "n_S_percent_quarter"}.items():
        short[f"n_S / %, {grid}"] = [f"{x:.1f}" for x in rows[column]]
    for words, name in {"whole": "whole", "a quarter": "quarter", "whole less a quarter": "gain"}.items():
        short[f"own best, d held out, {words}"] = [interval(row, name) for _, row in rows.iterrows()]
    return [
        f"Four times as many combinations to choose from change that by {interval(mean, 'gain')}: on the {mean['n']:.0f} "
        f"smallest proteins the whole grid was recovered as well (2 draws), with a mean d of {interval(mean, 'whole')}, a "
        f"quarter of it there having {interval(mean, 'quarter')}.\n",
        markdown(short),
    ]


def of_worst(rows):
    """The protein on which the choice of all others does worst, as a sentence."""
    row = rows.loc[rows["lowest"].idxmin()]
    return (
        f"The choice of all others does worst on {row['lowest_protein']} in range {row['range']} (d = {signed(row['lowest'])}), "
        "which widens the interval there."
    )


def of_plateaus(d, plateaus):
    """The confidence sets of the best over proteins, and on how many proteins the winner may be the best."""
    parts = []
    for reading, rows in plateaus.groupby("islands", sort=False):
        share_held = rows["n_held"].sum() / rows["n_there"].sum()
        lost = d[(d["islands"] == reading) & (d["range"] > 0)]
        costs = lost[lost["lost_low"] > 0]["range"].tolist()
        where = f"in the ranges {', '.join(map(str, costs))}" if costs else "in no range"
        parts.append(
            f"Under `{reading}` the combination with the highest mean d lies in a protein's own confidence set of the best in "
            f"{100 * share_held:.0f} % of all cases (95 % if it were the best on each), and taking what the other proteins "
            f"choose costs d {where}.\n"
        )
        short = pd.DataFrame(
            {
                "n_S / %": [
                    f"{a:.1f} - {b:.1f}" for a, b in rows[["n_S_low_percent", "n_S_high_percent"]].to_numpy()
                ],
                "combinations": rows["n_combinations"],
                "highest mean d": rows["winner"],
                "may be the best on average": rows["n_best_set"],
                "may be the best on": [
                    f"{a} of {b} proteins" for a, b in rows[["n_held", "n_there"]].to_numpy()
                ],
            }
        )
        parts += [f"### islands: {reading}\n", markdown(short)]
    return "\n".join(parts)


def of_roughness(stored):
    """The relation with mean roughness, its power, and what is recommended."""
    relation, power = stored["relation"], stored["power"]
    short = pd.DataFrame(
        {
            "islands": relation["islands"],
            "range": relation["range"],
            "different winners": [f"{a} of {b}" for a, b in relation[["n_winners", "n_surfaces"]].to_numpy()],
            **{
                f"rho {name}": [rho(row, f"rho_{name}") for _, row in relation.iterrows()]
                for name in PARAMETERS
            },
            "p": relation["p"],
            "near less far": [interval(row, "gain") for _, row in relation.iterrows()],
        }
    )
    known, found, certain, supported = counted(relation)
    small = [
        f"`{row['islands']}` {row['range']} (p = {row['p']:.4f}, near less far {interval(row, 'gain')})"
        for _, row in relation[relation["p"] < SIGNIFICANT].iterrows()
    ]
    median = stored["surfaces"]["mean_roughness"].median()
    asked = recommend(stored, median, ASKED, stream(0, "recommend"))
    return "\n".join(
        [
            f"Of {known} ranges whose winners vary, {found} have p < {SIGNIFICANT:g}, where chance alone gives "
            f"{SIGNIFICANT * known:.0f}: {'; '.join(small) or 'none'}. Corrected for so many tests (Bonferroni) {certain} "
            f"remain, and in {supported} of these a choice by roughness gains over one combination for all. The test takes "
            f"the largest of four |rho|: over {power['n'].max()} proteins chance exceeds {power['critical'].min():.2f} in "
            "5 % of studies, and the smallest true rank correlation of one parameter that is found in 80 % is "
            f"{power['rho'].min():.2f}. A weaker one may be there; what it could gain is the last column.\n",
            "![](proteins_roughness.png)\n",
            markdown(short),
            "rho: Spearman's, of the winner's parameter with mean roughness (95 %, Bonett and Wright); p: of so large "
            "a rho of any of the "
            "four by chance, by permutation; near less far: d with the combination chosen on the proteins nearest in "
            "mean roughness, "
            "less that chosen on the farthest, which are always the same few at one of the two ends: a gain over these alone "
            "does not yet say that roughness helps, one over the choice of all others (above) would.\n",
            f"What `sparsurf recommend --roughness {median:.2f} --n-s {ASKED:g}` therefore answers, from these proteins:\n",
            f"```{asked}\n```\n",
        ]
    )


def of_enough(table, correlations):
    """n_S that is enough by each yardstick."""
    names = [(s, i) for i in AS_IS for s in ("uniform", "farthest", "poisson", "paper")]
    rows = table.set_index(["sampler", "islands", "yardstick"])
    cells = []
    for sampler, islands in names:
        cell = {"dots": f"{sampler}, {AS_IS[islands]}"}
        for yardstick in table["yardstick"].unique():
            row = rows.loc[(sampler, islands, yardstick)]
            cell[yardstick] = f"{share(row['median'])} ({share(row['lowest'])} to {share(row['highest'])})"
        cells.append(cell)
    return "\n".join(
        [
            "Smallest n_S in % whose Z lies within a tenth of a yardstick: median (lowest to highest) over the proteins, by "
            "interpolation between the n_S that were measured. The yardsticks are Z of all dots of the same surface "
            "laid anew, of those "
            "of the molecule turned, and of those of its atoms moved by 0.1 and 0.3 Å (rms).\n",
            markdown(pd.DataFrame(cells)),
            "![](proteins_enough.png)\n",
            against(correlations),
        ]
    )


def against(correlations):
    """Correlations with size and roughness as a table, with the sentence that sums them up."""
    clear = correlations[(correlations["rho_low"] > 0) | (correlations["rho_high"] < 0)]
    listed = "; ".join(
        f"{row.quantity} with {'size' if row.against == 'N' else 'mean roughness'} ({signed(row.rho)})"
        for row in clear.itertuples()
    )
    table = correlations.assign(text=[rho(row, "rho") for _, row in correlations.iterrows()])
    short = table.pivot(index="quantity", columns="against", values="text").reindex(
        table["quantity"].unique()
    )
    short = short.rename(columns={"N": "with N", "mean_roughness": "with mean roughness"})
    return f"Rank correlations beyond their 95 % interval: {listed or 'none'}.\n\n" + markdown(
        short[["with N", "with mean roughness"]].reset_index()
    )


def of_needed(needed, by_n_s):
    """Dots needed for the Z of uniform dots, and Z by n_S."""
    cells = []
    for (sampler, islands), rows in needed.groupby(["sampler", "islands"], sort=False):
        cell = {"dots": f"{sampler}, {AS_IS[islands]}"}
        for row in rows.itertuples():
            bound = f" [{row.n_bound}]" if row.n_bound else ""
            cell[f"n_S / %, Z of {row.target:g} %"] = f"{row.n_S_percent:.1f}{bound}"
            cell[f"times fewer than {row.target:g} %"] = (
                f"{row.factor:.1f} ({row.factor_low:.1f} to {row.factor_high:.1f})"
            )
        cells.append(cell)
    parts = [
        "n_S for the Z that so many uniform dots have as they are, and how many times fewer that is: geometric means over the "
        "proteins. [k]: on k of them n_S lies beyond 1 to 60 % and counts as the nearer end, so that the number is a bound.\n",
        markdown(pd.DataFrame(cells)),
        "![](proteins_needed.png)\n",
        outliers(by_n_s),
        "Z over proteins, and over the floor of fresh dots, for farthest-point dots:\n",
    ]
    own = by_n_s[by_n_s["sampler"] == "farthest"]
    short = pd.DataFrame({"n_S / %": [f"{p:g}" for p in own["percent"].unique()]})
    for islands, rows in own.groupby("islands", sort=False):
        short[f"Z {AS_IS[islands]}"] = [interval(row, "Z", unsigned=True) for _, row in rows.iterrows()]
    rows = own[own["islands"] == RECOVERED]
    short["recovered, over fresh dots"] = [
        interval(row, "over_floor", unsigned=True) for _, row in rows.iterrows()
    ]
    return "\n".join([*parts, markdown(short)])


def outliers(by_n_s):
    """The proteins whose Z is far above the mean of all, as a sentence."""
    far = by_n_s[by_n_s["highest"] > FAR * by_n_s["Z"]]
    listed = [
        f"{row.sampler}, {AS_IS[row.islands]}, {row.percent:g} %: {row.highest_protein} ({row.highest:.1f})"
        for row in far.itertuples()
    ]
    return f"Z of a single protein above {FAR:g} times the mean, which widens the band there: {'; '.join(listed) or 'none'}.\n"


def of_variants(table):
    """What changes when a rule does."""
    rows = table.set_index(["variant", "claim"])
    n = int(table["n"].max())
    cells, turned = [], []
    for variant in table["variant"].unique():
        cell = {"rule": variant, "n": int(rows.loc[(variant, "d_kept"), "n"])}
        for claim, words in CLAIMS.items():
            row = rows.loc[(variant, claim)]
            moved = row["change_low"] > 0 or row["change_high"] < 0
            text = interval(row, "value", unsigned=not claim.startswith("d_"))
            cell[words] = f"**{text}**" if moved else text
        cells.append(cell)
        turned += list(lost_claims(variant, rows))
    return "\n".join(
        [
            f"{' '.join(turned) or 'No rule turns a claim.'} {of_hydrogens(rows)}\n",
            f"One rule changed at a time, on {n} small proteins, a quarter of the grid (every second α and β), 3 "
            "draws, 48 test dots; means over the "
            "proteins with 95 % intervals. d is the mean of the ten ranges of the best combination, held out; the "
            "third column is the share "
            "of ranges in whose confidence set under `kept` the winner of the unvaried rules still lies; times fewer: "
            "farthest-point dots, "
            "recovered, for the Z of 25 % uniform ones as they are. Bold where the change, protein by protein, leaves 0.\n",
            markdown(pd.DataFrame(cells)),
        ]
    )


def of_hydrogens(rows):
    """What keeping hydrogens changes, as a sentence; nothing where it was not measured."""
    if (HYDROGENS, "d_kept") not in rows.index:
        return ""
    d, floor, held = (rows.loc[(HYDROGENS, claim)] for claim in ("d_kept", "over_floor", "held"))
    return (
        f"With hydrogens kept ({d['n']:.0f} structures that have them) d under `kept` changes by {interval(d, 'change')}, Z "
        f"recovered from a tenth over that of fresh dots by {interval(floor, 'change')}, and the winners without hydrogens may "
        f"still be the best in {100 * held['value']:.0f} % of the ranges: parameters chosen with and without are not the same."
    )


def lost_claims(variant, rows):
    """Sentences on the claims that do not hold under a variant."""
    kept, surface, factor = (rows.loc[(variant, claim)] for claim in ("d_kept", "d_surface", "factor"))
    if kept["value_low"] <= 0:
        yield f"With {variant}, d under `kept` is no longer above 0 ({interval(kept, 'value')})."
    if surface["value_high"] >= 0:
        yield f"With {variant}, d under `surface` is no longer below 0 ({interval(surface, 'value')})."
    if factor["value_low"] <= 1:
        yield f"With {variant}, recovering saves no dots ({interval(factor, 'value', True)})."


def of_coverage(table):
    """The check of the intervals."""
    means = table[table["interval"] == "mean"]
    return (
        "As many proteins were drawn again from those measured, as if these were all there are: intervals of means "
        "hold the true "
        f"mean in {100 * means['coverage'].min():.0f} to {100 * means['coverage'].max():.0f} % of 4000 samples, "
        "confidence sets the "
        f"truly best in {100 * table[table['interval'] != 'mean']['coverage'].min():.1f} % or more of 200.\n\n"
        + markdown(table, 3)
    )
