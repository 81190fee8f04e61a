"""The law of the error at other settings of the full surface."""

import pandas as pd

from sparsurf_study.workflow.jobs import Job, reporter
from measures import law
from measures.molecules import first_model
from measures.tables import write_tables
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.settings import Settings
from sparsurf.settings import SurfaceSettings as SurfaceSettings
from sparsurf.streams import Streams
from sparsurf.surfaces.molecular_surface import surface_of_molecule


def measure_law_settings(job: Job) -> None:
    """Tabulate the errors of reconstructed surfaces by density, at other settings of the full surface."""
    params, out, found = job.params, job.output, []
    structures = [(group, *pair) for group, paths in params.structures.items() for pair in paths.items()]
    progress = reporter("The law by settings", "surfaces")
    for k, (group, name, path) in enumerate(structures, 1):
        molecule, settings = first_model(name, path), Settings()
        if molecule is None:
            continue
        for words, changes in params.settings.items():
            rules = SurfaceSettings(**changes)
            surface = surface_of_molecule(molecule, rules, settings.patches.d_link, name)
            prepared = PreparedSurface(surface, settings, None, Streams(params.seed, f"law {name}"))
            of_surface, _ = law.errors_by_density(prepared, params.densities)
            known = {"group": group, "settings": words, "structure": name}
            found.append(pd.DataFrame(known | of_surface.to_dict("series")))
        progress(k, len(structures))
    table = pd.concat(found)
    write_tables({out.table: table, out.by_settings: law.by_settings(table)})
    write_tables({out.required: law.required_by_settings(table)})
