"""What maps from few centres are worth on three complexes: `python scripts/thin_complexes.py data docs`.

The folder `data` is that of `study_complexes.py`. Writes tables/complexes_thinning.csv, a row per complex, sampler and
size, and complexes_thinning.png into `docs`. In one thread, so that CPU seconds can be compared.
"""

import sys
from pathlib import Path

import pandas as pd

from sparsurf import InputError
from sparsurf.molecules.reading import read_molecule
from sparsurf.report.figures.thinning_figure import thinning_figure
from sparsurf.study.thinning import STAGES, thinning
from study_complexes import complexes, ready

NAMES = ("1a1u", "1PPE", "1AK4")
DRAWS = 1
KEYS = ["complex", "sampler", "percent", "surface"]


def main(path_to_data, path_to_docs):
    """Thin each complex; means over both sides and all draws are stored."""
    tables = []
    for name, form, paths in complexes(path_to_data):
        if name in NAMES and form == "bound":
            pair = [ready(read_molecule(path), f"{name} {side}") for side, path in enumerate(paths, 1)]
            table = thinning(*pair, draws=DRAWS, with_recovered=True).assign(complex=name)
            values = ["n_S_percent", "correlation", "auc", "seconds", *STAGES]
            tables.append(table.groupby(KEYS, sort=False)[values].mean().reset_index())
            tables[-1].insert(4, "n_S", table.groupby(KEYS, sort=False)["n_S"].mean().round(1).to_numpy())
            print(f"{name}: {table['seconds'].iloc[0]:.1f} CPU seconds for all dots", flush=True)
    docs = Path(path_to_docs)
    (docs / "tables").mkdir(parents=True, exist_ok=True)
    stored = pd.concat(tables)
    stored.to_csv(docs / "tables" / "complexes_thinning.csv", index=False, float_format="%.4g")
    figure = thinning_figure(stored, f"mean of {', '.join(NAMES)}")
    figure.savefig(docs / "complexes_thinning.png", dpi=150, metadata={"Software": None})


if __name__ == "__main__":
    try:
        main(*sys.argv[1:3])
    except InputError as error:
        sys.exit(str(error))
