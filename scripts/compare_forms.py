"""Compare two forms of a protein residue by residue: a table, and both structures, the second superposed."""

import numpy as np

from sparsurf_study.workflow.jobs import job
from sparsurf.errors import InputError
from sparsurf.streams import stream
from sparsurf_study.config.conformations import absent_conformation, first_column
from sparsurf_study.pairs.changes import changes, over_floor, read_forms, superpose_forms, warn_of_unmatched
from sparsurf_study.pairs.matching import on_atoms

B_FACTOR_OF_BURIED = -1.0  # The B factor of residues without a change.

with job(snakemake) as s:
    name, forms = s.wildcards.comparison, s.params.forms
    for side, form in enumerate(forms, 1):
        if names := s.input.get(f"names_{side}"):
            raise InputError(absent_conformation(f"changes.{name}", form, first_column(names)))
    files = [[s.input[f"{kind}_{side}"] for kind in ("surface", "structure")] for side in (1, 2)]
    compared = read_forms(name, dict(zip(forms, files, strict=True)), s.settings.surface, s.params.d_link)
    warn_of_unmatched(*compared)
    table = changes(*compared, stream(s.params.seed, "changes", *forms), s.threads)
    table.to_csv(s.output.changes, index=False, float_format="%.5g")
    relative = table.assign(over_floor=over_floor(table))
    first, second = (form.molecule for form in compared)
    for path, molecule in ((s.output.pdb_1, first), (s.output.pdb_2, superpose_forms(second, first))):
        change = on_atoms(molecule, relative, "over_floor", B_FACTOR_OF_BURIED)
        molecule.write_pdb(path, b_factor=np.nan_to_num(change, nan=B_FACTOR_OF_BURIED))
