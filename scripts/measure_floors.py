"""Measure how far two descriptions of one surface differ: the noise floors that every Z of a subset is compared with."""

import numpy as np

from sparsurf.molecules.read_molecule import read_molecule, read_study_structure
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.study import floors as noise_floors
from sparsurf.study.floors import TIME_GAPS_PS, frames_at_gaps
from sparsurf.study.prepared_surface import PreparedSurface, number_of_tests
from sparsurf.study.tables import read_roughness, read_table
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.molecular_surface import surface_generator
from sparsurf.surfaces.radii import radii
from sparsurf.workflow.jobs import job


def main(
    surface: str,
    roughness: str,
    conformation: str | None,
    floors: str,
    distances: str,
    settings: Settings,
    seed: int,
    molecule_options: dict,
    name: str,
    structure: str | None = None,
    trajectory: str | None = None,
    frames: str | None = None,
    threads: int = 1,
) -> None:
    """Write floors.csv and the distances at the test dots; for a ready surface with those floors that need no atoms.

    Parameters
    ----------
    conformation : the structure of the conformation; None for a ready surface
    structure, trajectory, frames : the trajectory that the conformation is a frame of, and its table of chosen frames
    name : protein/conformation
    """
    dots = read_npz(surface)
    streams = Streams(seed, name, shared=True)
    prepared = PreparedSurface(dots, settings, read_roughness(roughness, dots), streams, threads)
    generate_surface = atoms = other_frames = None
    if conformation:
        molecule = read_study_structure(conformation)
        atom_radii = radii(molecule, settings.surface.radii)
        generate_surface, atoms = surface_generator(
            molecule, 0, atom_radii, settings.surface, settings.patches.D_link, name
        )
    if atoms is not None and structure and trajectory and frames:
        table = read_table(frames).set_index("conformation")
        time = float(table["time_ps"].loc[name.split("/")[-1]])
        if np.isfinite(time):
            times = [time, *(time + sign * gap for gap in TIME_GAPS_PS for sign in (-1, 1))]
            near = read_molecule(structure, trajectory, times=times, **molecule_options)
            other_frames = frames_at_gaps(near, atoms, time)
    n_tests = number_of_tests(settings.evaluation.test_dots, len(dots))
    measured = noise_floors.measure_floors(prepared, n_tests, generate_surface, atoms, other_frames)
    noise_floors.floors_table(measured).to_csv(floors, index=False)
    noise_floors.write_distances(distances, measured)


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface=snakemake.input.surface,
            roughness=snakemake.input.roughness,
            conformation=snakemake.input.conformation or None,
            structure=snakemake.input.get("structure"),
            trajectory=snakemake.input.get("trajectory"),
            frames=snakemake.input.get("frames"),
            floors=snakemake.output.floors,
            distances=snakemake.output.distances,
            settings=Settings.of(snakemake.params),
            seed=snakemake.params.seed,
            molecule_options=snakemake.params.molecule_options,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            threads=snakemake.threads,
        )
