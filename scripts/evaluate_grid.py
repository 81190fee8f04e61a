"""Sample a surface with every combination of the grid and compare the subsets with the whole surface."""

from sparsurf_study.workflow.jobs import job, reporter
from sparsurf.evaluation.prepared_surface import number_of_tests
from sparsurf.sampling.published import parameter_grid
from sparsurf_study.analysis.grid import evaluate_grid, write_grid
from sparsurf_study.analysis.tables import grid_table

with job(snakemake) as s:
    sampling, evaluation = s.settings.sampling, s.settings.evaluation
    prepared = s.prepared(s.streams())
    result = evaluate_grid(
        prepared,
        parameter_grid(sampling.alpha, sampling.beta, sampling.gamma, sampling.delta),
        number_of_tests(evaluation.test_dots, len(prepared)),
        evaluation.draws,
        evaluation.grid_readings,
        progress=reporter(s.place),
    )
    write_grid(s.output.distances, result)
    grid_table(result).to_csv(s.output.grid, index=False)
