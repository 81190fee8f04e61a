"""Regions of enclosed surface beside the sites of known ligands: at which rank they stand, and how much of a site they hold."""

from dataclasses import replace

import numpy as np
import pandas as pd
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

import sparsurf
from sparsurf_study.workflow.jobs import Job
from measures.tables import write_tables
from sparsurf.patches.index import D_LINK
from sparsurf.surfaces.radii import PROBE_RADIUS

FIELD = "enclosure"
NEAR = 4.5  # Å, from a ligand to the atoms of its site
COVERED = 2.5  # Å, from an atom of a ligand to the centre of a probe that touches a region
LEAST_COVERED = 0.05  # of a ligand, by a region that has a row


def measure_regions(job: Job) -> None:
    """Tabulate the regions at known sites."""
    tables = [
        regions_at_site(path, ligand, job.params.above).assign(protein=protein, ligand=ligand)
        for protein, path, ligand in job.params.sites
    ]
    write_tables({job.output.table: pd.concat(tables)})


def regions_at_site(path: str, ligand: str, above: float) -> pd.DataFrame:
    """Compare the regions of a protein without its ligand with the site of the ligand.

    Returns
    -------
    DataFrame, one row for each region that covers some of the ligand: its rank by area among `regions` of them, the share of the
    ligand's atoms that it covers, how many of the `site_residues` it holds, and its residues and area (Å^2)
    """
    whole = sparsurf.read_molecule(path, selection="not water", model=1)
    is_ligand = whole.residue_name == ligand
    protein, atoms = whole.take((whole.kind == "protein") & ~is_ligand), whole.xyz[0][is_ligand]
    dots = sparsurf.surface(protein, radii="bondi", cavities="remove")
    dots = replace(dots, fields=sparsurf.fields(dots, FIELD).to_dict("series"))
    table = sparsurf.regions(dots, FIELD, above=above)
    near = cKDTree(atoms).query(protein.xyz[0])[0] < NEAR
    site = {*map(protein.residue_label, np.flatnonzero(near))}
    probes = dots.points + PROBE_RADIUS * dots.normals
    rows = []
    for part, row in zip(_parts(dots, above), table.itertuples(), strict=False):
        assert abs(dots.area[part].sum() - row.area) < 1e-6  # found independently
        residues, covered = {*row.residues.split("; ")}, cKDTree(probes[part]).query(atoms)[0] < COVERED
        rows.append(
            {
                "rank": row.region, "regions": len(table), "covered": covered.mean(), "of_site": len(residues & site),
                "site_residues": len(site), "residues": len(residues), "area": row.area,
            }
        )  # fmt: skip
    return pd.DataFrame(rows).query("covered > @LEAST_COVERED")


def _parts(dots: sparsurf.Surface, above: float) -> list[np.ndarray]:
    """Return the connected dots past a threshold, the largest area first."""
    past = np.flatnonzero(dots.fields[FIELD] > above)
    pairs = cKDTree(dots.points[past]).query_pairs(D_LINK, output_type="ndarray").T
    graph = coo_array((np.ones(pairs.shape[1]), pairs), (len(past), len(past)))
    n, label = connected_components(graph, directed=False)
    parts = [past[label == k] for k in range(n)]
    return sorted(parts, key=lambda part: -dots.area[part].sum())
