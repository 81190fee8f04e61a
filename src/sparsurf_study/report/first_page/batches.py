"""Thousands of structures on the first page: distributions, the most unusual surfaces, and the failures by reason."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sparsurf_study import catalogue
from sparsurf_study.report.first_page.run import MAX_SHOWN, Cell, Figure, TableLink


def of_batches(batches: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """Collect the surfaces of a run in batches; None of another run."""
    if not batches:
        return None
    surfaces, failures = batches["surfaces"], batches["failures"]
    n_failed = sum(len(names) for _, names in failures)
    found: dict[str, Any] = {
        "n_surfaces": len(surfaces),
        "n_failed": n_failed,
        "n_batches": batches["n_batches"],
        "failures": [(reason, names[:MAX_SHOWN], len(names)) for reason, names in failures],
        "max_names": MAX_SHOWN,
        "links": [
            (f"{output.path.split('/')[0]}/", f"one Parquet file for each batch: {output.content}")
            for output in catalogue.in_section("batches")
        ],
    }
    if surfaces.empty:
        return found
    picture = catalogue.outputs()["distributions.png"]
    models = surfaces[surfaces["masked_residues"].notna()]
    masked = int(models["masked_residues"].sum())
    roughness = surfaces["mean_roughness"]
    return found | {
        "n_dots": int(surfaces["N"].sum()),
        "n_kept": int(surfaces["minimal_n_S"].sum()),
        "percent": 100 * surfaces["minimal_n_S"].sum() / surfaces["N"].sum(),
        "atoms": (surfaces["atoms"].min(), surfaces["atoms"].max()),
        "roughness": (roughness.median(), roughness.min(), roughness.max()),
        "n_models": len(models),
        "masked": (masked, masked + int(models["residues"].sum())),
        "figure": Figure(picture.path, picture.caption),
        "table": unusual_table(batches["unusual"].to_dict("records")),
    }


def unusual_table(records: list[dict[Any, Any]]) -> TableLink:
    """Tabulate the most unusual surfaces."""
    columns = ["structure", "deviation", "measure", "atoms", "area (Å²)", "volume (Å³)", "mean roughness"]
    columns += ["components", "cavities"]
    form = {"deviation": "{:.1f}", "area": "{:,.0f}", "volume": "{:,.0f}", "mean_roughness": "{:.2f}"}
    measured = ("deviation", "atoms", "area", "volume", "mean_roughness", "components", "cavities")
    rows: list[list[Any]] = []
    for row in records:
        cells = [Cell(form.get(k, "{:,}").format(row[k]), key=str(row[k])) for k in measured]
        rows.append([row["protein"], cells[0], row["unusual"], *cells[1:]])
    return TableLink(columns, rows, sortable=True)
