"""One protein of the config: where it comes from and what of it takes part."""

from dataclasses import make_dataclass

from sparsurf.simulation.protocol import BEFORE
from sparsurf.workflow.download import PDB_URL, file_name
from sparsurf.workflow.schema import OF_PROTEIN, keys_of_protein

Entry = make_dataclass("Entry", [(key, object, None) for key in OF_PROTEIN], frozen=True)


class Protein(Entry):
    """An entry of the config's `proteins`: its keys as attributes (see the schema), None where it does not give one."""

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
        return {key: path for key, path in self._given(keys_of_protein("file")).items() if key != "surface"}

    @property
    def chosen(self):
        """What of the file takes part, as keyword arguments of `read_molecule`."""
        return self._given(keys_of_protein("chosen"))

    @property
    def molecule_options(self):
        """The same for the molecule that enters the study: a simulated one is cut to its part already."""
        before = BEFORE if self.simulate is not None else ()
        return {key: value for key, value in self.chosen.items() if key not in before}

    @property
    def without_meaning(self):
        """Keys that say nothing about a ready surface, where the protein is one."""
        of_atoms = (*keys_of_protein("chosen"), "simulate", "trajectory")
        return [*self._given(of_atoms)] if self.surface else []

    def _given(self, keys):
        return {key: getattr(self, key) for key in keys if getattr(self, key) is not None}


def proteins(config):
    """The proteins of a checked config, by name."""
    return {name: Protein(**entry) for name, entry in config["proteins"].items()}
