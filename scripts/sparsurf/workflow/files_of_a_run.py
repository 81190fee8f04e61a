"""Which files a run has: what its proteins come from, what each must have in the end, what the rules ask for.

The functions of `wildcards` are input functions of Snakemake.
"""

from math import gcd
from types import SimpleNamespace

from snakemake.exceptions import IncompleteCheckpointException

from sparsurf.simulation.protocol import completed, length_ns, stage_before
from sparsurf.workflow.code_digests import content
from sparsurf.workflow.jobs import conformations_of
from sparsurf.workflow.needs import held, is_small, memory_of_grid, thousand_dots
from sparsurf.workflow.protein import proteins

OF_CONFORMATION = (
    *("surface.ply", "ranges.csv", "ranges.md", "best.json", "best.md"),
    *("minimal.csv", "minimal.ply", "enough.csv", "floors.csv", "view.html", "residues.csv"),
)
# By the checkpoint: while one of them is missing, Snakemake does not know what follows from it, and takes all for made
OF_FRAMES = ("frames.csv", "silhouette.csv", "projection.csv", "explained.csv", "structures")
OF_ATOMS = ("residues.csv",)  # what a ready surface has not
# By the first page: what the report holds, what lies beside it
LED_TO = ("view.html", "ranges.csv", "residues.csv")
LED_TO_BESIDE = ("minimal.csv", "enough.csv", "floors.csv", "best.md", "ranges.md")


class FilesOfARun:
    """Proteins of a run by their kind, and their files.

    Parameters
    ----------
    config : dict, as `config.check` gives it
    figures : names of the figures of a conformation
    checkpoints : Snakemake's; its `choose_frames` tells which conformations a molecule has

    Attributes
    ----------
    run : str, folder of the run
    proteins : dict of name to `Protein`
    surfaces, molecules, simulated : lists of names: ready surfaces; all others; those of them that are simulated first
    fetched : dict of name to the name of the file that is fetched for it
    few_frames : bool, whether the conformations of all molecules are chosen in seconds
    """

    def __init__(self, config, figures, checkpoints):
        self.run = f"results/{config['run']}"
        self.proteins = proteins(config)
        self.surfaces = [name for name, protein in self.proteins.items() if protein.surface]
        self.molecules = [name for name in self.proteins if name not in self.surfaces]
        self.fetched = {name: protein.download for name, protein in self.proteins.items() if protein.source}
        self.simulated = [name for name, protein in self.proteins.items() if protein.simulate is not None]
        self._config, self._figures, self._checkpoints = config, list(figures), checkpoints
        self.few_frames = not self.simulated and all(
            is_small("choose_frames", held(self.proteins[name].files, config["frames"]["stride"]))
            for name in self.molecules
        )

    def protein(self, wildcards):
        """What the config says about a protein."""
        return self.proteins[wildcards.protein]

    def conformations(self, name):
        """Names of the conformations of a protein; Snakemake asks again once its frames are chosen."""
        if name in self.surfaces:
            return ["c1"]
        return conformations_of(self._checkpoints.choose_frames.get(protein=name).output.frames)

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
        files = self.molecule(wildcards)
        frames = (
            files | {"frames": f"{self.run}/{wildcards.protein}/frames.csv"} if "trajectory" in files else {}
        )
        return frames | {"own": self.structure(wildcards)}

    def every(self, *files):
        """Input function: `files` of every conformation, of one protein or of all."""

        def of_conformations(wildcards):
            names = [wildcards.protein] if hasattr(wildcards, "protein") else self.proteins
            return [
                f"{self.run}/{name}/{conformation}/{file}"
                for name in names
                for conformation in self.conformations(name)
                for file in files
                if name in self.molecules or file not in OF_ATOMS
            ]

        return of_conformations

    def of_conformations(self, wildcards):
        """What every conformation must have in the end."""
        figures = [f"figures/{name}.{kind}" for name in self._figures for kind in ("png", "svg")]
        compared = ["compare.csv"] if self._config["compare"]["run"] else []
        return self.every(*OF_CONFORMATION, *figures, *compared)(wildcards)

    def of_protein(self, wildcards):
        """What a protein must have in the end beside its conformations."""
        name = wildcards.protein
        frames = f"{self.run}/{name}/figures/frames.svg"
        return [*self._pictures(name), frames] if name in self.molecules else []

    def _pictures(self, name):
        """Pictures of the frames of a molecule."""
        names = ["frames", *(("ensemble", "residues") if self._config["ensemble"]["run"] else ())]
        names += ["simulation"] if name in self.simulated else []
        return [f"{self.run}/{name}/figures/{each}.png" for each in names]

    def of_proteins(self):
        """What the run must have in the end but for its pairs."""
        found = [f"{name}/.complete" for name in self.proteins] + ["index.html", ".front_page.html"]
        found += [f"{name}/{file}" for name in self.molecules for file in OF_FRAMES]
        found += ["summary.csv", "summary.svg"] if self.proteins else []
        found += ["verdict.md"] if "paper" in self._config else []
        found += ["compare.md"] if self._config["compare"]["run"] else []
        return [f"{self.run}/{file}" for file in found]

    def of_each(self):
        """Input functions, one per protein: the same, file by file; a mark stays where a file is deleted."""

        def files(name):
            one = SimpleNamespace(protein=name)
            return lambda _: self.of_protein(one) + self.of_conformations(one)

        return [files(name) for name in self.proteins]

    def led_to(self, wildcards):
        """What the first page leads to, in the report, but for the pairs."""
        compared = self._config["compare"]["run"]
        figures = [*self._figures, *(["compare"] if compared else [])]
        found = self.every(*LED_TO, *(f"figures/{name}.png" for name in figures))(wildcards)
        found += [picture for name in self.molecules for picture in self._pictures(name)]
        found += [f"{self.run}/{file}" for file in ("summary.csv", "summary.png")]
        found += [f"{self.run}/compare.png"] if compared else []
        return found + ([f"{self.run}/verdict.html"] if "paper" in self._config else [])

    def led_to_beside(self, wildcards):
        """The same, beside the report."""
        compared = ["compare.md"] if self._config["compare"]["run"] else []
        found = self.every(*LED_TO_BESIDE, *compared)(wildcards)
        found += [f"{self.run}/{name}/simulation/quality.csv" for name in self.simulated]
        return found + [f"{self.run}/{file}" for file in ("summary.md", *compared)]

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
