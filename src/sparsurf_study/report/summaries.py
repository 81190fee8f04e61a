"""Tables and figures over all surfaces and pairs of a run, from the results that lie in their folders."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import pandas as pd

from sparsurf.streams import stream
from sparsurf_study.analysis.comparison import means_by_protein, means_over_proteins
from sparsurf_study.analysis.summary import read_result, relation_table, summary_table, surfaces_table
from sparsurf_study.rounding import write_rounded


def summarise_surfaces(folders: Mapping[Path, bool], table: str, png: str) -> None:
    """Write surfaces.csv and the figure of how many dots are enough; `folders` say whether they have results of the grid."""
    from sparsurf.views import layout  # here and below: matplotlib takes a third of a second to load
    from sparsurf_study.report.figures import required_dots

    write_rounded(table, surfaces_table([read_result(*folder) for folder in folders.items()]))
    layout.save(required_dots.figure([required_dots.read(folder) for folder in folders]), png)


def summarise_best(folders: Iterable[Path], seed: int, summary: str, relation: str) -> None:
    """Write the best parameters of all surfaces, and whether they follow mean roughness."""
    results = [read_result(folder, minimal=False) for folder in folders]
    best = summary_table(results)
    write_rounded(summary, best)
    write_rounded(relation, relation_table(results, best, stream(seed, "summary")))


def summarise_comparison(tables: Iterable[Path], table: str, png: str) -> None:
    """Write the means over <protein>/<conformation>/compare.csv and the spread between proteins, as table and figure."""
    from sparsurf.views import layout
    from sparsurf_study.report.figures.comparison_figure import comparison_figure

    comparisons = {(path.parts[-3], path.parts[-2]): pd.read_csv(path) for path in tables}
    units = means_by_protein(comparisons)
    several = "proteins" if len({protein for protein, _ in comparisons}) > 1 else "conformations"
    kind = several if len(units) > 1 else "conformation"
    means = means_over_proteins(units)
    write_rounded(table, means)
    subject = f"mean of {len(units)} {kind}" if len(units) > 1 else next(iter(units))
    drawn = means.rename(columns={"lowest": "low", "highest": "high"})
    layout.save(comparison_figure(drawn, subject, f"lowest to highest of {len(units)} {kind}"), png)


def summarise_pairs(tables: Iterable[Path], run: str, table: str, png: str) -> None:
    """Write <pair>/agreement.csv of all pairs as one table, and the figure of the means over pairs."""
    from sparsurf.views import layout
    from sparsurf_study.report.figures.pair_figures import over_pairs

    scores = pd.concat([pd.read_csv(path).assign(complex=path.parent.name) for path in tables])
    write_rounded(table, scores)
    layout.save(over_pairs(run, scores), png)
