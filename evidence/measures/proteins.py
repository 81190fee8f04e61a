"""Surfaces of several proteins, the paper's own with its hydrogens and dots as published, prepared one after the other."""

from collections.abc import Iterator
from typing import Any

from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.settings import Settings
from sparsurf.settings import Surface as SurfaceSettings
from sparsurf.streams import Streams
from sparsurf.surfaces.molecular_surface import surface_of_molecule
from sparsurf_study.workflow.jobs import reporter


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
