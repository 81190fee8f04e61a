"""Compare the paper's Table I and its claims with results on the same protein."""

import json
from pathlib import Path
from typing import Any

from sparsurf_study.workflow.jobs import job, reporter
from sparsurf.evaluation.prepared_surface import number_of_tests
from sparsurf.views import layout
from sparsurf_study.analysis.tables import add_reference_columns, read_table
from sparsurf_study.paper.replication import facts_for_page, reproduce
from sparsurf_study.report.figures.table1 import table1_figure
from sparsurf_study.report.page import embedded, write_rendered
from sparsurf_study.report.paper_page import PAPER_TEMPLATE, paper_page, surface_of
from sparsurf_study.rounding import write_rounded

with job(snakemake) as s:
    a1, best = s.params.a1, json.loads(Path(s.input.best).read_text(encoding="utf-8"))
    grid = read_table(s.input.grid, best["combinations"], "combinations")
    prepared = s.prepared(s.streams(a1))
    tables = reproduce(prepared, s.settings, reporter(f"{a1} as published", "steps"))
    for name, table in tables.items():
        write_rounded(s.output[name], add_reference_columns(table, best["references"]))
    results: dict[str, Any] = tables | {
        name: read_table(s.input[name]) for name in ("ranges", "bins", "recovered")
    }
    results |= {"grid": grid, "best": best}
    evaluation = s.settings.evaluation
    n_tests = number_of_tests(evaluation.test_dots, len(prepared))
    results |= facts_for_page(prepared, tables, grid, n_tests, evaluation.draws)
    results |= {"surface": surface_of(prepared, s.settings.surface, s.params.path_to_surface)}
    drawn = table1_figure(tables["places"], tables["rows"])
    for path in (s.output.svg, s.output.png):
        layout.save(drawn, path)
    figure = embedded(s.output.png)
    write_rendered(
        s.output.page, PAPER_TEMPLATE, s.params.lengths, **paper_page(results), first=a1, figure=figure
    )
