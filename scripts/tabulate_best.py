"""Tabulate the best combination in each range of n_S, and the best of all."""

import json
from pathlib import Path

from sparsurf_study.workflow.jobs import job
from sparsurf.evaluation.prepared_surface import number_of_tests
from sparsurf.patches.readings import SCALED_READING
from sparsurf_study.analysis import tables
from sparsurf_study.analysis.grid import add_scaled_link, read_grid
from sparsurf_study.analysis.islands import add_islands
from sparsurf_study.analysis.winners import write_winners
from sparsurf_study.rounding import write_rounded

with job(snakemake) as s:
    result, evaluation = read_grid(s.input.distances), s.settings.evaluation
    grid = tables.read_table(s.input.grid, len(result.combinations), "combinations")
    floors = tables.floors_by_name(tables.read_table(s.input.floors))
    prepared = s.prepared(s.streams())
    ranges = tables.ranges_table(grid, result, s.params.ranges, floors)
    n_tests = number_of_tests(evaluation.test_dots, len(prepared))
    best = tables.best_combinations(grid, result, s.params.max_n_s_percent, floors)
    ranges = add_islands(ranges, best, prepared, n_tests, evaluation.draws)
    if SCALED_READING in evaluation.readings:
        ranges = add_scaled_link(ranges, prepared, n_tests, evaluation.draws)
    write_rounded(s.output.ranges, ranges)
    Path(s.output.best).write_text(json.dumps(best, indent=2) + "\n", encoding="utf-8")
    write_winners(s.output.winners, ranges, prepared)
