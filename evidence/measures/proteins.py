"""Tables over many proteins, whose surfaces are prepared one after the other: A1 with its hydrogens and dots as published."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pandas as pd

from sparsurf_study.workflow.jobs import Job, reporter
from measures.protein_figures import FIGURES
from measures.protein_tables import tables_of
from measures.studies import read_study, sizes
from measures.tables import write_tables
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.recovery.readings import RECOVERED
from sparsurf.settings import Settings
from sparsurf.settings import SurfaceSettings as SurfaceSettings
from sparsurf.streams import Streams
from sparsurf.surfaces.molecular_surface import surface_of_molecule
from sparsurf.views import layout


def prepare_proteins(params: Any, study: str, threads: int) -> Iterator[tuple[str, PreparedSurface]]:
    """Yield names and surfaces by the params of a rule: structures (paths by name), paper, surface, hydrogens, patches, seed."""
    settings, progress = Settings(patches=params.patches), reporter(study.capitalize(), "surfaces")
    for k, (name, path) in enumerate(params.structures.items(), 1):
        published = name == params.paper
        molecule = read_molecule(path, model=1, hydrogens="keep" if published else params.hydrogens)
        rules = SurfaceSettings(**params.surface if published else {})
        surface = surface_of_molecule(molecule, rules, settings.patches.d_link, name)
        yield name, PreparedSurface(surface, settings, None, Streams(params.seed, f"{study} {name}"), threads)
        progress(k, len(params.structures))


def tabulate_proteins(job: Job) -> None:
    """Tabulate and draw the study of many proteins."""
    params, output = job.params, job.output
    run, run_recovered = Path(job.input.summary).parent, Path(job.input.recovered[0]).parents[2]
    summary = pd.read_csv(job.input.summary)
    summary["best_set"] = summary["best_set"].fillna("")
    relation = pd.read_csv(job.input.relation)
    surfaces = pd.read_csv(job.input.surfaces).merge(sizes(run, params.proteins))
    surfaces = surfaces.assign(hydrogens=params.hydrogens)
    tables = tables_of(
        read_study(run, params.proteins),
        summary,
        relation,
        surfaces,
        read_study(run_recovered, params.recovered, RECOVERED),
    )
    write_tables({output[name]: table for name, table in tables.items()})
    stored = {name: pd.read_csv(output[name]) for name in tables}
    of_study = {"summary": summary, "relation": relation, "surfaces": surfaces}
    write_tables({output[name]: table for name, table in of_study.items()})
    stored |= {name: pd.read_csv(output[name]) for name in of_study}
    for name, draw in FIGURES.items():
        layout.save(draw(stored), output[f"figure_{name}"])


def table_of_proteins(
    job: Job, study: str, measure: Callable[[PreparedSurface], pd.DataFrame], column: str
) -> pd.DataFrame:
    """Measure a table on each protein and put them one below the other; the first `column` names the protein."""
    found = [
        measure(prepared).assign(**{column: name})
        for name, prepared in prepare_proteins(job.params, study, job.threads)
    ]
    return pd.concat(found).set_index(column).reset_index()
