"""Compare samplers at equal n_S on one surface."""

from sparsurf_study.workflow.jobs import job, reporter
from sparsurf.evaluation.prepared_surface import PreparedSurface, number_of_tests
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.views import layout
from sparsurf_study.analysis.comparison import compare_samplers, select_methods
from sparsurf_study.analysis.tables import floors_by_name, read_roughness, read_table
from sparsurf_study.report.figures.comparison_figure import comparison_figure
from sparsurf_study.report.page_origin import with_atoms
from sparsurf_study.rounding import write_rounded

with job(snakemake) as s:
    dots = with_atoms(
        read_npz(s.input.surface), s.input.structure, s.settings
    )  # for samplers that read fields
    roughness = read_roughness(s.input.roughness, dots)
    prepared = PreparedSurface(dots, s.settings, roughness, s.streams(), s.threads)
    compared = compare_samplers(
        prepared,
        select_methods(prepared, s.params.samplers, read_table(s.input.ranges)),
        s.params.percents,
        number_of_tests(s.settings.evaluation.test_dots, len(prepared)),
        s.settings.evaluation.draws,
        reporter(f"{s.place}: comparison", "samplers"),
        floors_by_name(read_table(s.input.floors)),
    )
    write_rounded(s.output.table, compared)
    layout.save(comparison_figure(compared, s.params.title), s.output.png)
