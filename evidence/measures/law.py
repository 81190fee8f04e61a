"""The error of the surface reconstructed from farthest-point dots, by their density, and the law error = C / density."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

import sparsurf
from sparsurf_study.workflow.jobs import Job, reporter
from measures.molecules import first_model
from measures.tables import read_tables, write_tables
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.residues import KIND_NUMBERS
from sparsurf.recovery.errors import DENSITY_FOR_ERRORS, TAIL_QUANTILE, distance_to_recovered, kept_out
from sparsurf.sampling.samplers import get_sampler
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.views import layout
from sparsurf.views.layout import styled

CHAINS, HYDROGENS = "chains", "with hydrogens"
ERRORS = ("mean", "high_99")
NEAR = 0.15  # a relative deviation from the prediction
DENSITIES, SHOWN_ERRORS = (0.15, 0.3, 0.6, 1.2), (0.01, 0.02, 0.05, 0.1)  # of the axes of the figure
SIZES = (200, 500, 1000, 2000, 5000)  # atoms
REQUESTED = (0.02, 0.03, 0.05)  # Å, mean errors whose density is asked for
CONSTANTS = {CHAINS: 0.0125, HYDROGENS: 0.015}  # Å, of the lines of the figure: mean error times dots per Å^2
SAMPLER = "farthest"
LARGEST = 0.99  # quantile above which errors are the largest of a surface
AS_USUAL = "default"  # of the settings of the surface


def errors_by_density(
    prepared: PreparedSurface, densities: Sequence[float]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Measure the distance of the dots that are not kept from the surface reconstructed from those that are.

    The kept dots are farthest-point dots, so that the subset of a lower density is the beginning of that of a higher one.

    Returns
    -------
    DataFrame: requested and density (kept dots per Å^2), mean, high_99 and largest (Å)
    DataFrame: requested, part (of the surface: contact, saddle, concave), dots_percent (of the dots that
    were not kept, those in this part), ratio (mean error here over that of all) and largest_percent (of the largest 1 % of the
    errors, those in this part)
    """
    n = np.round(np.asarray(densities) * prepared.area).astype(int)
    order = get_sampler(SAMPLER)(prepared, int(n.max()), prepared.stream("law"))
    rows, rows_of_parts = [], []
    for requested, n_kept in zip(densities, n, strict=True):
        kept = order[:n_kept]
        few = prepared.points[kept], prepared.normals[kept]
        found = distance_to_recovered(prepared.points, *few, prepared.threads, DENSITY_FOR_ERRORS)
        found = kept_out(found, kept)
        row = {"requested": requested, "density": n_kept / prepared.area, "mean": found.mean()}
        rows.append(row | {"high_99": np.quantile(found, TAIL_QUANTILE), "largest": found.max()})
        kind, large = kept_out(prepared.surface.kind, kept), found > np.quantile(found, LARGEST)
        for part, k in KIND_NUMBERS.items():
            here = kind == k
            row = {"requested": requested, "part": part, "dots_percent": 100 * here.mean()}
            row["ratio"] = found[here].mean() / found.mean() if here.any() else np.nan
            rows_of_parts.append(row | {"largest_percent": 100 * here[large].mean()})
    return pd.DataFrame(rows), pd.DataFrame(rows_of_parts)


def with_range(name: str, values: pd.Series) -> dict[str, float]:
    """Return the mean of values over structures, their lowest and their highest, as columns of this name."""
    return {name: values.mean(), f"{name}_lowest": values.min(), f"{name}_highest": values.max()}


def by_part(table: pd.DataFrame) -> pd.DataFrame:
    """Describe the errors of each part of the surface over structures.

    Returns
    -------
    DataFrame: group, density (requested), part, n (structures), dots_percent, ratio with its lowest and highest,
    largest_percent with its lowest and highest (as `errors_by_density` defines them)
    """
    rows = []
    for (group, density, part), of in table.groupby(["group", "requested", "part"], sort=False):
        row = {"group": group, "density": density, "part": part, "n": len(of)}
        row["dots_percent"] = of["dots_percent"].mean()
        row |= with_range("ratio", of["ratio"])
        rows.append(row | with_range("largest_percent", of["largest_percent"]))
    return pd.DataFrame(rows)


def in_order(table: pd.DataFrame) -> pd.DataFrame:
    """Sort errors by group and, among the chains, by name: every second one is fitted, whatever the jobs that measured them."""
    key = table["structure"].where(table["group"] == CHAINS, "")
    return table.assign(key=key).sort_values(["group", "key"], kind="stable").drop(columns="key")


def fitted(density: np.ndarray, error: np.ndarray, exponent: float | None = None) -> tuple[float, float]:
    """Fit error = C / density^exponent by least squares of the logarithms; return C and the exponent, free unless given."""
    x, y = np.log(density), np.log(error)
    if exponent is None:
        exponent = -float(np.polyfit(x, y, 1)[0])
    return float(np.exp(np.mean(y + exponent * x))), float(exponent)


def fits(table: pd.DataFrame) -> pd.DataFrame:
    """Fit the law to every second structure of a group and predict the errors of the others.

    Returns
    -------
    DataFrame: group, error ('mean' or 'high_99'), exponent_is ('free' or 'one'), C, exponent, n_fitted and n_predicted
    (structures), n_errors (predicted), residual_percent (standard deviation of the logarithm of measured over predicted),
    lowest_percent and highest_percent (of measured over predicted, less 100) and within_percent, the share of errors within 15 %
    """
    rows = []
    for group, part in table.groupby("group", sort=False):
        names = list(dict.fromkeys(part["structure"]))
        half = part["structure"].isin(names[::2])
        for error in ERRORS:
            for words, given in (("free", None), ("one", 1.0)):
                known, others = part[half], part[~half]
                c, exponent = fitted(known["density"].to_numpy(), known[error].to_numpy(), given)
                ratio = (others[error] * others["density"] ** exponent / c).to_numpy()
                row = {"group": group, "error": error, "exponent_is": words, "C": c, "exponent": exponent}
                row |= {"n_fitted": len(names[::2]), "n_predicted": len(names[1::2]), "n_errors": len(ratio)}
                if len(ratio):
                    row["residual_percent"] = 100 * np.log(ratio).std()
                    row |= {
                        "lowest_percent": 100 * ratio.min() - 100,
                        "highest_percent": 100 * ratio.max() - 100,
                    }
                    row["within_percent"] = 100 * (np.abs(ratio - 1) <= NEAR).mean()
                rows.append(row)
    return pd.DataFrame(rows)


def by_density(table: pd.DataFrame) -> pd.DataFrame:
    """Describe error times density over the structures of a group at each density.

    Returns
    -------
    DataFrame: group, density (requested), n (structures), product (mean of mean error times density, Å) with its standard
    deviation, lowest and highest, tail (99 % over mean error) with its lowest and highest
    """
    rows = []
    for (group, density), part in table.groupby(["group", "requested"], sort=False):
        product, tail = part["mean"] * part["density"], part["high_99"] / part["mean"]
        row = {"group": group, "density": density, "n": len(part), "product": product.mean()}
        row |= {
            "product_sd": product.std(),
            "product_lowest": product.min(),
            "product_highest": product.max(),
        }
        rows.append(row | with_range("tail", tail))
    return pd.DataFrame(rows)


def required(table: pd.DataFrame, fitted_law: pd.DataFrame) -> pd.DataFrame:
    """Compare the density that the law gives for a mean error with those measured.

    Returns
    -------
    DataFrame: group, error (Å), law (C over the error, exponent one), n (structures), density, lowest and highest: mean and range
    of the densities at which the measured errors of a structure, joined by lines of their logarithms, pass the error
    """
    rows = []
    for group, part in table.groupby("group", sort=False):
        own = fitted_law[(fitted_law["group"] == group) & (fitted_law["error"] == "mean")]
        c = own.loc[own["exponent_is"] == "one", "C"].iloc[0]
        for error in REQUESTED:
            found = pd.Series(
                [
                    np.exp(
                        np.interp(
                            -np.log(error), -np.log(one["mean"]), np.log(one["density"]), np.nan, np.nan
                        )
                    )
                    for _, one in part.sort_values("density").groupby("structure", sort=False)
                ]
            ).dropna()
            row = {"group": group, "error": error, "law": c / error, "n": len(found), "density": found.mean()}
            rows.append(row | {"lowest": found.min(), "highest": found.max()})
    return pd.DataFrame(rows)


def by_settings(table: pd.DataFrame) -> pd.DataFrame:
    """Describe error times density by the settings of the surface, and compare it with that at the default settings.

    Returns
    -------
    DataFrame: group, settings, density (requested), n (structures), product (mean of mean error times density, Å), its lowest
    and highest, change_percent (mean over structures of the product against that at the default settings), its lowest and
    highest, tail (99 % over mean error)
    """
    keys = ["group", "structure", "requested"]
    table = table.assign(product=table["mean"] * table["density"], tail=table["high_99"] / table["mean"])
    usual = table[table["settings"] == AS_USUAL].set_index(keys)["product"]
    of_usual = usual.loc[pd.MultiIndex.from_frame(table[keys])].to_numpy()
    table["change"] = 100 * (table["product"] / of_usual - 1)
    rows = []
    for (group, settings, density), part in table.groupby(["group", "settings", "requested"], sort=False):
        row = {"group": group, "settings": settings, "density": density, "n": len(part)}
        row |= with_range("product", part["product"]) | with_range("change_percent", part["change"])
        rows.append(row | {"tail": part["tail"].mean()})
    return pd.DataFrame(rows)


def required_by_settings(table: pd.DataFrame) -> pd.DataFrame:
    """Find the density for an error as `required` does, with the settings of the surface in the name of the group."""
    named = table.assign(group=table["group"] + ": " + table["settings"])
    return required(named, fits(named))


@styled
def draw(table: pd.DataFrame) -> Figure:
    """Draw the mean error against the density with the lines of the law, and their product against the size of the molecule."""
    figure = layout.constrained(layout.PAGE_WIDTH, 78)
    left, right = figure.subplots(1, 2, width_ratios=(1.2, 1))
    looks = {CHAINS: (layout.PALETTE[0], "o", 5), HYDROGENS: (layout.PALETTE[5], "D", 9)}
    ends = np.array([table["density"].min() / 1.3, table["density"].max() * 1.3])
    for group, (colour, marker, size) in looks.items():
        part = table[table["group"] == group]
        n, c = part["structure"].nunique(), CONSTANTS[group]
        words = f"{n} chains without hydrogens" if group == CHAINS else f"{n} structures {group}"
        look = {"s": size, "color": colour, "marker": marker, "linewidths": 0, "alpha": 0.6}
        left.scatter(part["density"], part["mean"], label=words, zorder=2, **look)
        left.plot(ends, c / ends, color=colour, label=f"{c:g} Å⁻¹ / density", zorder=1)
        right.scatter(part["atoms"], part["mean"] * part["density"], zorder=2, **look)
        right.axhline(c, color=colour, zorder=1)
    left.set_xscale("log")
    left.set_yscale("log")
    right.set_xscale("log")
    for axis, values in ((left.xaxis, DENSITIES), (left.yaxis, SHOWN_ERRORS), (right.xaxis, SIZES)):
        axis.set_major_locator(FixedLocator(values))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())
    left.set_xlim(ends)
    left.set_xlabel("kept dots per Å²")
    left.set_ylabel("mean error (Å)")
    left.legend(loc="lower left")
    right.set_xlabel("atoms")
    right.set_ylabel("mean error × dots per Å² (Å⁻¹)")
    right.set_ylim(0, None)
    layout.panel_title(left, "A", "Error by density")
    layout.panel_title(right, "B", "Error × density by size")
    return layout.fix_layout(figure)


def measure_law(job: Job) -> None:
    """Measure the errors of the surfaces reconstructed from few dots of several structures, by the density of the kept dots."""
    params, errors, parts, progress = job.params, [], [], reporter("The law", "surfaces")
    for k, (name, path) in enumerate(params.structures.items()):
        molecule = first_model(name, path, params.hydrogens)
        if molecule is None:
            continue
        streams = Streams(params.seed, f"law {name}")
        prepared = PreparedSurface(sparsurf.surface(molecule), Settings(), None, streams)
        found = errors_by_density(prepared, params.densities)
        known = {"group": params.group, "structure": name, "atoms": molecule.n_atoms, "area": prepared.area}
        for tables, table in zip((errors, parts), found, strict=True):
            tables.append(pd.DataFrame(known | table.to_dict("series")))
        progress(k + 1, len(params.structures))
    pd.concat(errors).to_csv(job.output.errors, index=False)
    pd.concat(parts).to_csv(job.output.parts, index=False)


def tabulate_law(job: Job) -> None:
    """Tabulate and draw the law of the error by density."""
    table, out = in_order(read_tables(job.input.errors)), job.output
    fitted_law = fits(table)
    write_tables({out.table: table, out.fits: fitted_law, out.by_density: by_density(table)})
    parts = by_part(read_tables(job.input.parts))
    write_tables({out.required: required(table, fitted_law), out.by_part: parts})
    layout.save(draw(table), out.figure)
