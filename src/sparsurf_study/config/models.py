"""The config of a study as pydantic models: every key with its type, limits, default and meaning."""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, PlainSerializer, model_validator

from sparsurf import registry
from sparsurf.arguments import DEFAULT_SEED, Hydrogens
from sparsurf.files import URL_OF_PDB
from sparsurf.molecules.formats import STRUCTURE_LABELS, TOPOLOGY_LABELS, TRAJECTORY_LABELS
from sparsurf.settings import (
    Evaluation,
    Length,
    Minimal,
    Number,
    PatchesSettings,
    Percent,
    Positive,
    Sampler,
    SamplingSettings,
    Section,
    Seed,
    SurfaceSettings,
    UniqueList,
    key,
    optional,
    without_repeats,
)
from sparsurf_study.config import listing
from sparsurf_study.config.download import file_name
from sparsurf_study.config.protein_keys import MOLECULE_KEYS, SOURCE_KEYS
from sparsurf_study.config.yaml_file import DEFAULT_RUN, MOST_OF_RUN
from sparsurf_study.settings import Ensemble, FrameNumber, Integer, PercentBelow100, Plddt, Thousand, Two
from sparsurf_study.simulation.protocol import KEYS_OF_SIMULATION

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
CONFORMATION_PATTERN = "^[^/]+(/[cf][0-9]+)?$"
RESIDUES = f"^{RESIDUE_RANGE}(,{RESIDUE_RANGE})*$"
FORMS = {  # examples of strings of these patterns
    WORD: "charmm27",
    URL: "https://address/of/a/file",
    PDB_ID: "1ubi",
    SHA256: "64 digits and letters from a to f",
    CONFORMATION_PATTERN: "my_protein or my_protein/c2",
    RESIDUES: "A:10-52A,60,-5--3",
}
Word = Annotated[str, Field(pattern=WORD)]
Url = Annotated[str, Field(pattern=URL)]
# YAML reads 4530 as a number
AS_TEXT = BeforeValidator(lambda value: str(value) if type(value) is int else value)
PdbId = Annotated[str, Field(pattern=PDB_ID), AS_TEXT]
Sha256 = Annotated[str, Field(pattern=SHA256)]
NAME_OF_FOLDER = r"^[A-Za-z0-9][A-Za-z0-9_.-]*$"
Name = Annotated[str, Field(pattern=NAME_OF_FOLDER, max_length=MOST_OF_RUN)]
Conformation = Annotated[str, Field(pattern=CONFORMATION_PATTERN)]
Residues = Annotated[str, Field(pattern=RESIDUES)]


def _switch(section: type[Section]) -> BeforeValidator:
    """Accept true and false in place of a section with the key `run`."""
    return BeforeValidator(_as_section, json_schema_input_type=section | bool)


class Simulate(Section):
    """Molecular dynamics that GROMACS runs before the study; {} for the paper's protocol over 1 ns."""

    ns: Number = key(1.0, "Length of the production run, whose frames the study uses, ns.", gt=0, le=100_000)
    nvt_ns: Number = key(
        0.1,
        "Length of the equilibration of the temperature, ns; increase it for a large protein.",
        gt=0,
        le=1000,
    )
    npt_ns: Number = key(
        0.1,
        "Length of the equilibration of the pressure, ns; increase it for a large protein.",
        gt=0,
        le=1000,
    )
    save_ps: Number = key(1.0, "Time between two saved frames, ps.", gt=0, le=10**6)
    temperature: Number = key(300.0, "Temperature, K.", gt=0, le=1000)
    cutoff: Number = key(
        12.0,
        "Cut-off of the short-range interactions, Å; use 12 with CHARMM force fields and 10 with AMBER.",
        ge=6,
        le=30,
    )
    force_field: Word = key("charmm27", "Name of a force field of GROMACS.")
    water: str = key("tip3p", "Name of a water model of the force field.", pattern="^[A-Za-z0-9]+$")


class Protein(Section):
    """A structure with or without a trajectory, or a ready surface."""

    structure: Text = optional(
        f"Path of the structure: a {STRUCTURE_LABELS} file, also .gz except for HDF5; with a trajectory, also a "
        f"{TOPOLOGY_LABELS} file."
    )
    trajectory: Text = optional(
        f"Path of a trajectory ({TRAJECTORY_LABELS}, or a structure with several frames), whose frames are conformations of the "
        "structure. A file that was cut off between two frames cannot be recognised."
    )
    url: Url = optional("Address from which the structure is downloaded: https, or http with a sha256.")
    pdb: PdbId = optional("PDB id of the structure, which is downloaded as mmCIF.")
    sha256: Sha256 = optional("SHA-256 checksum that the downloaded file must have.")
    surface: Text = optional(
        "Path of a ready surface, whose dots are used instead of placing dots on a structure: a file with the suffix "
        f"{', '.join(registry.suffixes('dots', is_read=True))}, also .gz."
    )
    table: Text = optional(
        "Path of a CSV file with values for each residue or atom: the column residue, chain and atom where they are "
        "needed, and columns of numbers, which `fields` can name."
    )
    selection: Text = optional(
        "Atoms to use, as a selection expression of mdtraj, such as 'resid < 100'; the protein by default."
    )
    chains: list[str] = optional("Identifiers of the chains to use; all by default.", min_length=1)
    residues: Residues = optional(
        "Ranges of residues to use, both ends included, such as A:10-52A,-5-3: chain A, from 10 to 52A and from -5 to 3."
    )
    model: Integer = optional(
        "Number of the model to use, as written in the file, of a structure with several models; by default, all models are used "
        "as frames."
    )
    assembly: bool = optional(
        "true to read the biological assembly: the copies that a file of one model declares, or all models as one molecule; "
        "false by default."
    )
    altloc: Text = optional(
        "Which of the alternate positions of an atom is used: first (the default), highest (occupancy) or a letter."
    )
    hydrogens: Hydrogens = optional("Whether the hydrogens of the file are kept (the default) or removed.")
    simulate: Annotated[Simulate, AfterValidator(Simulate.model_dump), PlainSerializer(dict)] = optional(
        Simulate.__doc__ or ""
    )
    ligands: bool | Literal["all"] | list[str] = optional(
        "Ligands, molecules bound to the protein, that are included in the surface: a list of residue names such as [HEM], "
        "or true for all except waters and ions; false by default."
    )
    plddt: Plddt = optional("The same as the key plddt of the study, for this protein alone.")
    sampling: bool = optional(
        "false skips the grid for this protein; true evaluates it even if the study has `sampling: false`."
    )

    model_config = ConfigDict(json_schema_extra={"oneOf": [{"required": [key]} for key in SOURCE_KEYS]})

    @model_validator(mode="after")
    def _has_one_source(self) -> "Protein":
        if len(self._given(SOURCE_KEYS)) != 1:
            sources = "'structure' (with or without 'trajectory'), 'pdb', 'url' and 'surface'"
            raise ValueError(f"needs exactly one of {sources}.")
        return self

    @property
    def source(self) -> str | None:
        """URL of the structure; None for local files."""
        return self.url or (URL_OF_PDB.format(self.pdb.upper()) if self.pdb else None)

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

    proteins: Two[str] = optional("Names of two of the proteins, whose first conformations are compared.")
    files: Two[Text] = optional("Paths of two structures in the positions of the complex.")
    complex: Text = optional("Path of one structure that contains both partners; it also needs chains.")
    chains: Two[UniqueList[str]] = optional(
        "Chains of the first and of the second partner in the file complex, such as [[A], [B, C]]."
    )

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
    percent: Percent = optional("Number of centres, in % of the dots.")
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
    """How the partners of each pair are compared."""

    centres: Literal["all"] | Centres = key(
        {"sampler": "farthest", "percent": 5},
        "Dots whose patches are compared: all, or those that a sampler chooses; {sampler: farthest, percent: 5} by default.",
        validate_default=True,
    )
    smoothing: Number = key(
        6.0,
        "Radius over which the distances between patches are averaged, Å; 0 for no averaging.",
        ge=0,
        le=100,
    )
    interface: Length = key(3.0, "Distance to the partner below which a dot belongs to the interface, Å.")


class FramesSection(Section):
    """Which frames of a trajectory, or of a file with several models, the study analyses as conformations."""

    clusters: Literal["auto"] | Thousand = key(
        "auto",
        "Number of clusters into which k-means divides the frames; auto: the number from 2 to 11 with the highest mean "
        "silhouette.",
    )
    selection: Literal["clusters", "all"] | UniqueList[FrameNumber] = key(
        "clusters",
        "Which frames are analysed: clusters (the frame nearest to the centre of each cluster), all, or a list of frame "
        "numbers, counted from 0.",
    )
    stride: Positive = key(1, "Read only every n-th frame, so that a long trajectory needs less memory.")
    start: Integer = key(
        0, "Position of the first frame that is read, from 0, such as the one after an equilibration.", ge=0
    )
    stop: Integer = optional("Position of the frame before which reading stops; by default, the end.", ge=1)


class Tables(Section):
    """The tables that list the best combination in each range of the number of kept dots, n_S."""

    ranges: Integer = key(10, "Number of ranges of equal width into which n_S is divided.", ge=1, le=1000)
    max_n_S_percent: Number = key(
        20.0,
        "Largest n_S, in % of the dots, of the best combination of few dots in best.json; the paper calls it the maximum number "
        "of sampled points.",
        ge=1,
        le=100,
    )


class Compare(Section):
    """A comparison of samplers at equal numbers of kept dots, n_S."""

    run: bool = key(
        False,
        "Whether every run compares the samplers, for which `sampling` must not be false; `make compare` does so once.",
    )
    percents: UniqueList[PercentBelow100] = key(
        [2.5, 5, 10, 20, 40, 60], "Values of n_S at which the samplers are compared, in % of the dots."
    )
    samplers: UniqueList[Sampler] = optional(
        "Samplers to compare; by default, all but cover. Without `uniform`, compare.csv has Z of each sampler, but no random "
        "subsets from which d and the column `ratio` follow."
    )


class Folder(Section):
    """All files of a folder."""

    folder: Text = Field(description="Folder that holds the files.")


FIELD_ITEMS = {"anyOf": [{"enum": [*registry.TABLE["field"]]}, {"type": "string"}]}
PLACES = (
    "protein, protein/c2 (one conformation), protein/* (results over all frames), pairs/name or changes/name"
)
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

    run: Name = key(
        DEFAULT_RUN,
        "Name of the study, whose results are written to results/<run>/; by default, the name of the config file.",
    )
    seed: Seed = key(DEFAULT_SEED, "Seed of all random numbers of the study.")
    proteins: ListedProteins = key(
        {},
        "Proteins to analyse, by name; or the path of a CSV table with the column name and a column for each key, whose "
        "paths start at the folder of the table; or {folder: path} for all files of a folder.",
    )
    pairs: ListedPairs = key(
        {},
        "Pairs of molecules whose surfaces are compared, by name; or the path of a CSV table with the columns name, first "
        "and second, or name, complex, chains_1 and chains_2; or {folder: path} for files named NAME_r and NAME_l.",
    )
    changes: dict[Name, Two[Conformation]] = key(
        {},
        "Two forms of a protein to compare residue by residue, by the name of the comparison, such as {opening: [open, "
        "closed]}. A form is a protein, or protein/c2 for one of its conformations.",
    )
    pages: Annotated[list[str], AfterValidator(without_repeats)] = optional(
        "Only with `sampling: false`: names of the structures that get HTML pages, figures and files of their own. By "
        "default, these are all structures if there are at most 10, and none otherwise. If any structure gets none, all "
        "are also analysed in batches."
    )
    plddt: Plddt = optional(
        "Leave out the residues of a predicted model, such as one of AlphaFold, whose pLDDT is lower. pLDDT is the "
        "confidence of the prediction, from 0 to 100. Experimental structures are not changed."
    )
    exclude: Excluded = key(
        {}, f"Parts of the study to leave out, each with the reason that the first page shows: {PLACES}."
    )
    complementarity: Complementarity = Complementarity()
    paper: Text = optional(
        "Name of the protein that is conformation A1 of the paper; its results are compared with the published tables."
    )
    frames: FramesSection = FramesSection()
    surface: SurfaceSettings = SurfaceSettings()
    fields: Fields = key(
        [],
        "Names of values to compute at every dot in addition to roughness: properties that follow from the structure, or "
        "columns that every `table` of a protein has.",
    )
    patches: PatchesSettings = PatchesSettings()
    sampling: Annotated[SamplingSettings, _switch(SamplingSettings)] = SamplingSettings()
    evaluation: Evaluation = Evaluation()
    tables: Tables = Tables()
    minimal: Minimal = Minimal()
    ensemble: Annotated[Ensemble, _switch(Ensemble)] = Ensemble()
    compare: Annotated[Compare, _switch(Compare)] = Compare()
