"""Which files a run has: what its proteins come from and what the rules ask for.

The functions of `wildcards` are input functions of Snakemake.
"""

import gzip
import re
from functools import cache
from math import gcd
from pathlib import Path

from snakemake.exceptions import IncompleteCheckpointException

from sparsurf.molecules.formats import MMCIF, PDB, suffix
from sparsurf.simulation.protocol import completed, length_ns, stage_before
from sparsurf.workflow.code_digests import content
from sparsurf.workflow.jobs import conformations_of, plain
from sparsurf.workflow.needs import held, is_small, memory_of_grid, thousand_dots
from sparsurf.workflow.schema import proteins


class FilesOfARun:
    """Proteins of a run by their kind, and their files.

    Parameters
    ----------
    config : dict, as `config.check` gives it
    checkpoints : Snakemake's; its `choose_frames` tells which conformations a molecule has

    Attributes
    ----------
    run : str, folder of the run
    proteins : dict of name to `Protein`
    surfaces, molecules, simulated : lists of names: ready surfaces; all others; those of them that are simulated first
    single, many : lists of names: molecules with one conformation for certain; those whose frames must be seen first
    fetched : dict of name to the name of the file that is fetched for it
    few_frames : bool, whether the conformations of all molecules are chosen in seconds
    """

    def __init__(self, config, checkpoints):
        self.run = f"results/{config['run']}"
        self._without = {plain(place) for place in config["without"]}
        self.proteins = {name: each for name, each in proteins(config).items() if name not in self._without}
        self.surfaces = [name for name, protein in self.proteins.items() if protein.surface]
        self.molecules = [name for name in self.proteins if name not in self.surfaces]
        self.fetched = {name: protein.download for name, protein in self.proteins.items() if protein.source}
        self.simulated = [name for name, protein in self.proteins.items() if protein.simulate is not None]
        self._config, self._checkpoints = config, checkpoints
        self.single = [name for name in self.molecules if self._is_single(name)]
        self.many = [name for name in self.molecules if name not in self.single]
        self.few_frames = not self.simulated and all(
            is_small("choose_frames", held(self.proteins[name].files, config["frames"]["stride"]))
            for name in self.molecules
        )

    def protein(self, wildcards):
        """What the config says about a protein."""
        return self.proteins[wildcards.protein]

    def conformations(self, name):
        """Names of the conformations of a protein; Snakemake asks again once its frames are chosen."""
        return [each for each in self._chosen(name) if not self.goes_without(name, each)]

    def has_frames(self, name):
        """Whether a molecule has frames to choose from; Snakemake asks again once they are read."""
        if name in self.surfaces + self.single:
            return False
        return len(conformations_of(self._checkpoints.choose_frames.get(protein=name).output.projection)) > 1

    def steps_over_frames(self, name):
        """Whether `frames.stride` may leave out frames of a molecule, which its ensemble goes over."""
        return name in self.many and self._config["frames"]["stride"] > 1

    def first(self, name):
        """The first conformation of a protein, which its pairs take."""
        return self._chosen(name)[0]

    def _chosen(self, name):
        if name in self.surfaces:
            return ["c1"]
        if name in self.single:
            return ["c1" if self._config["frames"]["use"] == "clusters" else "f0"]
        return conformations_of(self._checkpoints.choose_frames.get(protein=name).output.frames)

    def _is_single(self, name):
        """Whether a molecule is a file with one model: then no job waits for what its frames turn out to be."""
        protein = self.proteins[name]
        if protein.source or protein.trajectory or protein.simulate is not None or protein.model:
            return False
        return has_one_model(protein.structure)

    def goes_on_with(self, name, conformation):
        """Whether a protein takes part with one of its conformations."""
        return name in self.proteins and not self.goes_without(name, conformation)

    def goes_without(self, *place):
        """Whether the config leaves a protein, conformation or job (rule's name behind it) out."""
        return bool(self._without) and plain("/".join(place)) in self._without

    def side_by_side(self, most, cores):
        """Threads, at most `most`, of a job of which each conformation has one; as a rule takes them.

        Such jobs run side by side with few threads each, as far as that leaves no core idle: each begins and ends with
        what one thread does alone. `cores` are those of this machine, None where jobs run elsewhere.
        """
        if cores is None:
            return most
        cores = min(cores, most)

        def threads(wildcards):
            try:
                jobs = len(self.conformations(wildcards.protein)) * len(self.proteins)  # about
            except IncompleteCheckpointException:  # asked again later
                jobs = len(self.proteins)
            return 1 if jobs >= 4 * cores else cores // gcd(cores, jobs)

        return threads

    def given(self, wildcards):
        """The files that the config names for a molecule, or that were fetched."""
        name = wildcards.protein
        fetched = (
            {"structure": f"{self.run}/{name}/download/{self.fetched[name]}"} if name in self.fetched else {}
        )
        return self.proteins[name].files | fetched

    def contents(self, wildcards):
        """Digests of the files that the config names for a protein."""
        protein = self.protein(wildcards)
        return [content(path) for path in [*protein.files.values(), protein.surface] if path]

    def table(self, wildcards):
        """The table of a protein's own fields; none where it has none."""
        return self.protein(wildcards).table or []

    def molecule(self, wildcards):
        """The files of a structure or trajectory that enter the study, simulated or not."""
        if wildcards.protein in self.simulated:
            folder = f"{self.run}/{wildcards.protein}/simulation"
            return {"structure": f"{folder}/topology.pdb", "trajectory": f"{folder}/trajectory.xtc"}
        return self.given(wildcards)

    def stage_before(self, wildcards):
        """The stage of a simulation that ends where another begins."""
        stage = stage_before(wildcards.stage)
        return {"before": f"{self.run}/{wildcards.protein}/simulation/{stage}"} if stage else {}

    def structure(self, wildcards):
        """The structure of a conformation; none of a ready surface."""
        folder = f"{self.run}/{wildcards.protein}/{wildcards.conformation}"
        return f"{folder}/structure.pdb" if wildcards.protein in self.molecules else []

    def atoms(self, wildcards):
        """The structure of a conformation, and its trajectory where it is a frame of one; or neither."""
        if wildcards.protein not in self.molecules:
            return {}
        return self.frames(wildcards) | {"own": self.structure(wildcards)}

    def frames(self, wildcards):
        """The files of a trajectory, and which frames of it were chosen; none of another molecule."""
        files = self.molecule(wildcards)
        if "trajectory" not in files:
            return {}
        return files | {"frames": f"{self.run}/{wildcards.protein}/frames.csv"}

    def every(self, *files):
        """Input function: `files` of every conformation, of one protein or of all."""

        def of_conformations(wildcards):
            names = [wildcards.protein] if hasattr(wildcards, "protein") else self.proteins
            return [
                f"{self.run}/{name}/{conformation}/{file}"
                for name in names
                for conformation in self.conformations(name)
                for file in files
            ]

        return of_conformations

    def nanoseconds(self, wildcards):
        """Simulated time of a stage."""
        return length_ns(wildcards.stage, completed(self.protein(wildcards).simulate))

    def megabytes(self, stride):
        """Input function: MB of the files of a molecule, of its trajectory every `stride`-th frame."""
        return lambda wildcards: held(self.molecule(wildcards), stride)

    def dots(self, wildcards):
        """Dots of a conformation in thousands, from the size of the file that it comes from: what its jobs need grows so."""
        surface = self.protein(wildcards).surface
        structure = f"{self.run}/{wildcards.protein}/structures/{wildcards.conformation}.pdb"
        return thousand_dots([surface or structure], of_dots=bool(surface))

    def distances(self, wildcards):
        """Memory in MB of all distances of the grid of a conformation."""
        return memory_of_grid(self._config, self.dots(wildcards)) / 1e6


@cache
def has_one_model(path):
    """Whether a PDB or mmCIF file certainly holds one model; False where that takes a closer look."""
    kind = suffix(path)
    if kind not in PDB + MMCIF:
        return False
    try:
        text = Path(path).read_bytes()
        text = gzip.decompress(text) if text[:2] == b"\x1f\x8b" else text
    except (OSError, EOFError):  # choose_frames says so
        return False
    if kind in PDB:
        end = text.find(b"\nEND")
        models = text.startswith(b"MODEL ") + text.count(b"\nMODEL ")
        return models <= 1 and not (end >= 0 and re.search(rb"^(ATOM|HETATM)", text[end:], re.M))
    columns = re.findall(rb"^_atom_site\.(\w+)", text, re.M)
    rows = re.findall(rb"^(?:ATOM|HETATM)\s.*", text, re.M)
    if columns[-1:] != [b"pdbx_PDB_model_num"] or not rows:
        return False
    first, last = rows[0].split(), rows[-1].split()
    return len(first) == len(last) == len(columns) and first[-1] == last[-1]
