"""The config of a study as pydantic models: every key with its type, limits, default and meaning."""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, PlainSerializer, model_validator

from sparsurf.arguments import DEFAULT_SEED
from sparsurf.settings import (
    Evaluation,
    Length,
    Minimal,
    Number,
    Patches,
    Percent,
    Positive,
    Sampler,
    Sampling,
    Section,
    Seed,
    Surface,
    UniqueList,
    key,
    optional,
    without_repeats,
)
from sparsurf_study.settings import Ensemble, FrameNumber, Integer, PercentBelow100, Plddt, Thousand, Two
from sparsurf_study.simulation.protocol import KEYS_OF_SIMULATION
from sparsurf_study.workflow import listing
from sparsurf_study.workflow.download import PDB_URL, file_name
from sparsurf_study.workflow.names import FIELDS, MOLECULE_KEYS, SOURCE_KEYS

RESIDUE_RANGE = r"\s*(([^:,\s][^:,]*)?:)?-?[0-9]+[A-Za-z]?(--?[0-9]+[A-Za-z]?)?\s*"


def _as_section(value: Any) -> Any:
    """Let true and false stand for the key `run` of a section, also as Snakemake's --config hands them on."""
    value = {"true": True, "false": False}.get(value, value) if isinstance(value, str) else value
    return {"run": value} if isinstance(value, bool) else value


def _as_reasons(value: Any) -> Any:
    """Convert a list of places to a mapping without reasons."""
    is_list = isinstance(value, list) and all(isinstance(part, str) for part in value)
    return dict.fromkeys(value, "") if is_list else value


Text = Annotated[str, Field(min_length=1)]
WORD = "^[A-Za-z0-9_-]+$"
URL = "^https?://"
PDB_ID = "^([0-9][A-Za-z0-9]{3}|pdb_[0-9]{5}[A-Za-z0-9]{3})$"
SHA256 = "^[0-9A-Fa-f]{64}$"
CONFORMATION = "^[^/]+(/[cf][0-9]+)?$"
RESIDUES = f"^{RESIDUE_RANGE}(,{RESIDUE_RANGE})*$"
FORMS = {  # examples of strings of these patterns
    WORD: "charmm27",
    URL: "https://address/of/a/file",
    PDB_ID: "1ubi",
    SHA256: "64 digits and letters from a to f",
    CONFORMATION: "my_protein or my_protein/c2",
    RESIDUES: "A:10-52A,60,-5--3",
}
Word = Annotated[str, Field(pattern=WORD)]
Url = Annotated[str, Field(pattern=URL)]
# YAML reads 4530 as a number
AS_TEXT = BeforeValidator(lambda value: str(value) if type(value) is int else value)
PdbId = Annotated[str, Field(pattern=PDB_ID), AS_TEXT]
Sha256 = Annotated[str, Field(pattern=SHA256)]
NAME_OF_FOLDER = r"^[A-Za-z0-9][A-Za-z0-9_.-]*$"
Name = Annotated[str, Field(pattern=NAME_OF_FOLDER, max_length=100)]
Conformation = Annotated[str, Field(pattern=CONFORMATION)]
Residues = Annotated[str, Field(pattern=RESIDUES)]


def _switch(section: type[Section]) -> BeforeValidator:
    """Accept true and false in place of a section with the key `run`."""
    return BeforeValidator(_as_section, json_schema_input_type=section | bool)


class Simulate(Section):
    """Molecular dynamics by GROMACS before the study; {} for the paper's protocol over 1 ns."""

    ns: Number = key(1.0, "Length of the production, ns.", gt=0, le=100_000)
    nvt_ns: Number = key(0.1, "Length of the thermalisation, ns; longer for a large protein.", gt=0, le=1000)
    npt_ns: Number = key(0.1, "Length of the pressurisation, ns; longer for a large protein.", gt=0, le=1000)
    save_ps: Number = key(1.0, "Time between two saved frames, ps.", gt=0, le=10**6)
    temperature: Number = key(300.0, "Temperature, K.", gt=0, le=1000)
    cutoff: Number = key(
        12.0, "Cut-off of the short-range interactions, Å; 12 suits CHARMM, 10 AMBER.", ge=6, le=30
    )
    force_field: Word = key("charmm27", "A force field that GROMACS has.")
    water: str = key("tip3p", "A water model that the force field has.", pattern="^[A-Za-z0-9]+$")


class Protein(Section):
    """A structure (with or without a trajectory) or a ready surface."""

    structure: Text = optional("PDB or mmCIF file (also .gz), or any topology that mdtraj reads.")
    trajectory: Text = optional(
        "Any trajectory that mdtraj reads; a file cut off between two frames looks complete."
    )
    url: Url = optional("Address of the structure: https, or http with a sha256.")
    pdb: PdbId = optional("PDB id; the entry is fetched as mmCIF.")
    sha256: Sha256 = optional("Checksum that a fetched file must have.")
    surface: Text = optional("Ready surface: DMS file, CSV, PLY or npz.")
    table: Text = optional("CSV of values per residue or atom: residue, chain, atom, columns for `fields`.")
    selection: Text = optional("Atoms that take part, as an mdtraj expression.")
    chains: list[str] = optional("Chain identifiers.", min_length=1)
    residues: Residues = optional("Residue ranges, like A:10-52A,-5-3.")
    model: Integer = optional("Number of one model; without it, models are frames.", ge=1)
    assembly: bool = optional("true: all models are parts of one molecule, as in files of assemblies.")
    altloc: Text = optional("Alternate location: first (the default), highest (occupancy) or a letter.")
    hydrogens: Literal["keep", "remove"] = optional("Hydrogens of the file; kept by default.")
    simulate: Annotated[Simulate, AfterValidator(Simulate.model_dump), PlainSerializer(dict)] = optional(
        Simulate.__doc__ or ""
    )
    ligands: bool | list[str] = optional("true for all, or a list of residue names; false by default.")
    plddt: Plddt = optional("The same as `plddt` of the study, for one protein.")
    sampling: bool = optional(
        "false: no grid for this protein; true: a grid where the study has `sampling: false`."
    )

    model_config = ConfigDict(json_schema_extra={"oneOf": [{"required": [key]} for key in SOURCE_KEYS]})

    @model_validator(mode="after")
    def _has_one_source(self) -> "Protein":
        if len(self._given(SOURCE_KEYS)) != 1:
            words = "'structure' (with or without 'trajectory'), 'pdb', 'url' and 'surface'"
            raise ValueError(f"needs exactly one of {words}.")
        return self

    @property
    def source(self) -> str | None:
        """URL of the structure; None for local files."""
        return self.url or (PDB_URL.format(self.pdb.upper()) if self.pdb else None)

    @property
    def download(self) -> str | None:
        """Name of the fetched file; None for local files."""
        return file_name(self.source) if self.source else None

    @property
    def file_options(self) -> dict[str, Any]:
        """Keyword arguments of `read_molecule` for the protein's file."""
        return self._given(MOLECULE_KEYS)

    @property
    def molecule_options(self) -> dict[str, Any]:
        """The same for the molecule of the study: a simulated one holds the chosen atoms only."""
        skip = KEYS_OF_SIMULATION if self.simulate is not None else ()
        return {key: value for key, value in self.file_options.items() if key not in skip}

    @property
    def keys_of_atoms(self) -> list[str]:
        """Keys that apply to structures only, where the protein is a ready surface."""
        return [*self._given((*MOLECULE_KEYS, "simulate", "trajectory", "table"))] if self.surface else []

    def _given(self, keys: Any) -> dict[str, Any]:
        return {key: getattr(self, key) for key in keys if getattr(self, key) is not None}


class Pair(Section):
    """Two partners whose patches are compared: two proteins, two files or two parts of one file."""

    proteins: Two[str] = optional("Two of the proteins; their first conformations are compared.")
    files: Two[Text] = optional("Two structures, placed as in the complex.")
    complex: Text = optional("One structure that holds both partners.")
    chains: Two[UniqueList[str]] = optional("Chains of the first and of the second partner of `complex`.")

    model_config = ConfigDict(
        json_schema_extra={"oneOf": [{"required": [key]} for key in ("proteins", "files", "complex")]}
    )

    @model_validator(mode="after")
    def _has_one_source(self) -> "Pair":
        sources = [key for key in ("proteins", "files", "complex") if getattr(self, key) is not None]
        if len(sources) != 1 or (self.complex is None) != (self.chains is None):
            raise ValueError("needs exactly one of 'proteins', 'files' and 'complex' (with 'chains').")
        return self


class Centres(Section):
    """Dots whose patches are compared, chosen by a sampler."""

    sampler: Sampler = Field(description="Sampler that chooses the centres.")
    percent: Percent = optional("Number of centres, % of the dots.")
    n_dots: Integer = optional("Number of centres.", ge=1)

    model_config = ConfigDict(
        json_schema_extra={"oneOf": [{"required": ["percent"]}, {"required": ["n_dots"]}]}
    )

    @model_validator(mode="after")
    def _has_one_number(self) -> "Centres":
        if (self.n_dots is None) == (self.percent is None):
            raise ValueError("needs exactly one of 'percent' and 'n_dots'.")
        return self


class Complementarity(Section):
    """How the partners of a pair are compared."""

    centres: Literal["all"] | Centres = key(
        {"sampler": "farthest", "percent": 5},
        "Dots whose patches are compared: all, or by a sampler; by default {sampler: farthest, percent: 5}.",
        validate_default=True,
    )
    smoothing: Number = key(6.0, "Radius over which the maps are averaged, Å; 0 for none.", ge=0, le=100)
    interface: Length = key(3.0, "Dots nearer than this to the partner are interface, Å.")


class Frames(Section):
    """Frames of a trajectory that enter the study as conformations."""

    clusters: Literal["auto"] | Thousand = key(
        "auto", "Number of k-means clusters on two principal components; auto: best mean silhouette."
    )
    selection: Literal["clusters", "all"] | UniqueList[FrameNumber] = key(
        "clusters", "Frames: clusters (nearest to the centroids), all, or a list of numbers from 0."
    )
    stride: Positive = key(1, "Read every n-th frame: a long trajectory in less memory.")


class Tables(Section):
    """The tables of the best combinations."""

    ranges: Integer = key(10, "Number of equal ranges of n_S.", ge=1, le=1000)


class Compare(Section):
    """Samplers compared at equal n_S."""

    run: bool = key(False, "Compare in every run; `make compare` does it once.")
    percents: UniqueList[PercentBelow100] = key([2.5, 5, 10, 20, 40, 60], "Requested n_S, % of the dots.")
    samplers: UniqueList[Sampler] = optional("Samplers to compare; all of them by default.")


class Folder(Section):
    """All files of a folder."""

    folder: Text = Field(description="Folder that holds the files.")


FIELD_ITEMS = {"anyOf": [{"enum": [*FIELDS]}, {"type": "string"}]}
PLACES = "protein, protein/c2, protein/* (results over all its frames), pairs/name, changes/name"
Fields = Annotated[
    list[str],
    AfterValidator(without_repeats),
    Field(json_schema_extra={"items": FIELD_ITEMS, "uniqueItems": True}),
]
ListedProteins = Annotated[
    dict[Name, Protein],
    BeforeValidator(listing.list_proteins, json_schema_input_type=dict[Name, Protein] | Folder | Text),
]
ListedPairs = Annotated[
    dict[Name, Pair],
    BeforeValidator(listing.list_pairs, json_schema_input_type=dict[Name, Pair] | Folder | Text),
]
Excluded = Annotated[
    dict[str, str], BeforeValidator(_as_reasons, json_schema_input_type=dict[str, str] | list[str])
]


class Config(Section):
    """Config of a study. Lengths are in Å. A key that is left out takes its default."""

    run: Name = key("default", "Name of the study; its results go to results/<run>/.")
    seed: Seed = key(DEFAULT_SEED, "Seed of all random numbers.")
    proteins: ListedProteins = key({}, "Proteins by name, a CSV table of them, or {folder: path}.")
    pairs: ListedPairs = key({}, "Pairs of partners by name, a CSV table of them, or {folder: path}.")
    changes: dict[Name, Two[Conformation]] = key(
        {}, "Forms of a protein to compare residue by residue, such as {opening: [open, tdp43/c2]}."
    )
    pages: Annotated[list[str], AfterValidator(without_repeats)] = optional(
        "With `sampling: false`: structures that get the files and pages of a study, by name; by default all of at most 10. "
        "If it leaves any out, all are analysed in batches."
    )
    plddt: Plddt = optional(
        "Leave out the residues of predicted models (AlphaFold) whose pLDDT is below; other structures stay as they are."
    )
    exclude: Excluded = key({}, f"What to leave out, with the reason that the first page shows: {PLACES}.")
    complementarity: Complementarity = Complementarity()
    paper: Text = optional("Protein that is the paper's A1, to compare with the published tables.")
    frames: Frames = Frames()
    surface: Surface = Surface()
    fields: Fields = key(
        [], "Values at every dot besides roughness: from the atoms, or a column of every `table`."
    )
    patches: Patches = Patches()
    sampling: Annotated[Sampling, _switch(Sampling)] = Sampling()
    evaluation: Evaluation = Evaluation()
    tables: Tables = Tables()
    minimal: Minimal = Minimal()
    ensemble: Annotated[Ensemble, _switch(Ensemble)] = Ensemble()
    compare: Annotated[Compare, _switch(Compare)] = Compare()
