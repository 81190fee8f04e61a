"""One protein of the config: where it comes from and what of it takes part."""

from dataclasses import dataclass

from sparsurf.simulation.protocol import BEFORE
from sparsurf.workflow.download import PDB_URL, file_name

FILES = ("structure", "trajectory", "surface")  # keys that hold a path
CHOSEN = ("selection", "chains", "residues", "model", "altloc", "hydrogens", "ligands")


@dataclass(frozen=True)
class Protein:
    """An entry of the config's `proteins`; what it does not give is None.

    Attributes
    ----------
    structure, trajectory, surface : paths; a surface stands alone
    url, pdb, sha256 : where a structure is fetched from, and its checksum
    selection, chains, residues, model, altloc, hydrogens, ligands : see `molecules.reading.read_molecule`
    simulate : how it is simulated before the study, see `simulation.protocol`
    """

    structure: str | None = None
    trajectory: str | None = None
    surface: str | None = None
    url: str | None = None
    pdb: str | None = None
    sha256: str | None = None
    selection: str | None = None
    chains: list | None = None
    residues: str | None = None
    model: int | None = None
    altloc: str | None = None
    hydrogens: str | None = None
    ligands: bool | list | None = None
    simulate: dict | None = None

    @property
    def source(self):
        """URL that the structure is fetched from; None for local files."""
        return self.url or (PDB_URL.format(self.pdb.upper()) if self.pdb else None)

    @property
    def download(self):
        """Name of the fetched file; None for local files."""
        return file_name(self.source) if self.source else None

    @property
    def files(self):
        """Local files of a structure, by key."""
        return {key: getattr(self, key) for key in ("structure", "trajectory") if getattr(self, key)}

    @property
    def chosen(self):
        """What of the file takes part, as keyword arguments of `read_molecule`."""
        return {key: getattr(self, key) for key in CHOSEN if getattr(self, key) is not None}

    @property
    def reading(self):
        """The same for the molecule that enters the study: a simulated one is cut to its part already."""
        before = BEFORE if self.simulate is not None else ()
        return {key: value for key, value in self.chosen.items() if key not in before}

    @property
    def without_meaning(self):
        """Keys that say nothing about a ready surface, where the protein is one."""
        return [
            key
            for key in (*CHOSEN, "simulate", "trajectory")
            if self.surface and getattr(self, key) is not None
        ]


def proteins(config):
    """The proteins of a checked config, by name."""
    return {name: Protein(**entry) for name, entry in config["proteins"].items()}
