"""Read and check the config of a study."""

import os
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from pydantic import ValidationError

from sparsurf import registry
from sparsurf.arguments import did_you_mean
from sparsurf.errors import InputError
from sparsurf.files import UNPACK, URL_START, shorten
from sparsurf.molecules.formats import stem, suffix
from sparsurf.molecules.listing import structures_below
from sparsurf.settings import OR_INSTALLED, REQUEST_KEYS
from sparsurf_study import manifest
from sparsurf_study.batches.assignment import BATCH_FOLDERS, BATCH_PERCENT, batched_structures, takes_batches
from sparsurf_study.config.conformations import absent_conformation, has_one_model, without_zeros
from sparsurf_study.config.download import ONLY, allowed, shown, variable
from sparsurf_study.config.memory import too_large
from sparsurf_study.config.mistakes import one_of, sentences
from sparsurf_study.config.models import Config, Protein
from sparsurf_study.config.protein_keys import FILE_KEYS
from sparsurf_study.config.yaml_file import read_config, run_of_config

__all__ = ["Config", "Protein", "check_config", "proteins", "read_config"]

# These names are taken in results/<run>/, beside the proteins.
RESERVED_NAMES = ("logs", "pairs", "changes", manifest.NAME.lower())
RESERVED_SUFFIXES = (".csv", ".md", ".png", ".svg", ".html", ".json", ".zip")
PUBLISHED_READINGS = ("kept", "full")
PUBLISHED_RANGES = 10  # rows of the paper's Table I
STRUCTURES_VARIABLE = "SPARSURF_STRUCTURES"  # environment variable: a folder of structures named like PDB ids
CONFORMATION_OR_ALL = re.compile(r"[cf]\d+|\*")  # one conformation, or all of them
WILDCARD = re.compile(r"[{}]|<[a-z][a-z0-9_]*>")  # Snakemake reads such a part of a path as a wildcard.
MAX_SENTENCES = 20


def check_config(
    config: dict, paths: Iterable[str | Path] = (), home: str | Path = ".", here: bool = True
) -> dict:
    """Return a checked copy of `config` with all defaults, in the order of `Config`, without optional keys that are not given.

    Without `proteins` and `pairs`, it changes the default study, which lies in `home`, key by key. The files `paths` that
    it comes from are read again to find keys that occur twice; a run without a name takes that of the first. If jobs run
    `here`, the grid must fit into this machine's memory.
    """
    paths = [*paths]
    for path in paths:
        read_config(path)
    if paths and "run" not in config:
        config = config | {"run": run_of_config(paths[0])}
    config = _with_default_study(config, Path(home))
    errors: list[str] = []
    try:
        checked = Config.model_validate(config).model_dump(exclude_none=True)
    except ValidationError as error:
        errors = [*sentences(error.errors(include_url=False))]
    if not {"proteins", "pairs"} & set(config):
        errors.append("the config lacks the key 'proteins'.")
    if not errors:
        checked["proteins"] = {
            name: _with_plddt(_with_file_at_home(_with_local_copy(name, protein), Path(home)), checked)
            for name, protein in checked["proteins"].items()
        }
        if batched_structures(checked) and not {*REQUEST_KEYS} & {*config.get("minimal", {})}:
            without_request = {
                key: value for key, value in checked["minimal"].items() if key not in REQUEST_KEYS
            }
            checked["minimal"] = without_request | {"percent": BATCH_PERCENT}
        errors = [*_check_keys_together(checked)]
        if here:
            errors += [*too_large(checked)] if sampled_proteins(checked) else []
    if errors:
        errors = [*dict.fromkeys(errors)]
        further = [f"{len(errors) - MAX_SENTENCES} more mistakes."] if len(errors) > MAX_SENTENCES else []
        raise InputError("config: " + "\n        ".join(errors[:MAX_SENTENCES] + further))
    return checked


def proteins(config: dict) -> dict[str, Protein]:
    """Return the proteins of a checked config, by name."""
    return {name: Protein(**entry) for name, entry in config["proteins"].items()}


def with_absolute_paths(config: dict) -> dict:
    """Return a checked config whose input files start at the root, so that no prefix of a workflow is put before them."""

    def absolute(entry: dict, keys: Sequence[str]) -> dict:
        return entry | {key: os.path.abspath(entry[key]) for key in keys if entry.get(key)}

    proteins = {name: absolute(entry, FILE_KEYS) for name, entry in config["proteins"].items()}
    pairs = {name: absolute(entry, ["complex"]) for name, entry in config["pairs"].items()}
    for entry in pairs.values():
        if entry.get("files"):
            entry["files"] = [os.path.abspath(path) for path in entry["files"]]
    return config | {"proteins": proteins, "pairs": pairs}


def sampled_proteins(config: dict) -> list[str]:
    """Return the names of the proteins of a checked config whose surfaces are sampled over the grid."""
    run = config["sampling"]["run"]
    return [name for name, entry in config["proteins"].items() if entry.get("sampling", run)]


def _with_default_study(config: dict, home: Path) -> dict:
    """Add the keys of the default study to a config without proteins and pairs."""
    if {"proteins", "pairs"} & set(config):
        return config
    path = home / "config.yaml"
    return read_config(path) | config if path.is_file() else config


def _with_local_copy(name: str, protein: dict) -> dict:
    """Replace a file from the network by the local file that an environment variable names."""
    if not {"url", "pdb"} & set(protein):
        return protein
    path = os.environ.get(variable(name)) if variable(name) != STRUCTURES_VARIABLE else None
    path = path or _structure_by_id(protein.get("pdb"))
    if not path:
        return protein
    if suffix(path) in registry.suffixes(is_read=True):
        return {"surface": path}
    options = {key: value for key, value in protein.items() if key not in ("url", "pdb", "sha256")}
    return {"structure": path} | options


def _structure_by_id(pdb: str | None) -> str | None:
    """Return the path of the structure named like a PDB id in the folder that SPARSURF_STRUCTURES names."""
    folder = os.environ.get(STRUCTURES_VARIABLE)
    if not (folder and pdb):
        return None
    if not Path(folder).is_dir():
        raise InputError(f"{STRUCTURES_VARIABLE} is {folder!r}, but there is no such folder.")
    return next((str(file) for file in structures_below(folder) if stem(file).lower() == pdb.lower()), None)


def _with_file_at_home(protein: dict, home: Path) -> dict:
    """Let the path of a file that lies only in `home` start there."""
    moved = {}
    for key in protein.keys() & FILE_KEYS:
        at_home = home / protein[key]
        if os.path.isfile(at_home) and not os.path.exists(protein[key]):
            moved[key] = str(at_home)
    return protein | moved


def _with_plddt(protein: dict, config: dict) -> dict:
    """Give the bound of the study to a structure without one; a trajectory and a ready surface have no pLDDT."""
    if "plddt" not in config or {"surface", "trajectory", "simulate"} & protein.keys():
        return protein
    return {"plddt": config["plddt"]} | protein


def _check_keys_together(config: dict) -> Iterator[str]:
    """Yield sentences on values that are valid alone, but not together."""
    if not config["proteins"] and not config["pairs"]:
        yield "proteins is empty; name at least one protein."
    for check in CONFIG_CHECKS:
        yield from check(config)


def _missing_file(key: str, path: str) -> Iterator[str]:
    exists = os.path.isfile(path)
    if not exists and any(os.path.isfile(parent) for parent in Path(path).parents):
        yield f"{key}: {shorten(repr(path))} leads into a file; {UNPACK}"
    elif WILDCARD.search(path):
        yield f"{key}: {shorten(repr(path))} contains a wildcard of Snakemake, {{x}} or <x>; rename that file or folder."
    elif os.path.isdir(path):
        yield f"{key}: {shorten(repr(path))} is a folder; name a file in it."
    elif not exists and URL_START.match(path):
        yield f"{key}: {shorten(repr(path))} is a URL; give a file, or a protein by its `url`, which is downloaded."
    elif not exists:
        yield f"{key}: there is no file {shorten(repr(path))} (paths start at {Path.cwd()})."


def _check_names(config: dict) -> Iterator[str]:
    """Yield a sentence for each name that the study uses itself, or that differs from another in case only."""
    for key in ("proteins", "pairs", "changes"):
        names: dict[str, str] = {}
        for name in config[key]:
            if (twin := names.setdefault(name.lower(), name)) != name:
                yield f"{key} {twin!r} and {name!r} differ only in upper and lower case; rename one of them."
            if name.lower().endswith(RESERVED_SUFFIXES) or name.lower() in RESERVED_NAMES:
                yield f"{key}: {name!r} is a file or folder of the study itself; choose another name."
    if Path("results", config["run"]).exists() and not Path("results", config["run"]).is_dir():
        yield f"run is {config['run']!r}, but results/{config['run']} is a file; choose another name."


def _check_proteins(config: dict) -> Iterator[str]:
    for name, protein in config["proteins"].items():
        key = f"proteins.{name}"
        for file_key in FILE_KEYS:
            if file_key in protein:
                yield from _missing_file(f"{key}.{file_key}", protein[file_key])
        if "url" in protein and not allowed(protein["url"], protein.get("sha256")):
            yield f"{key}.url is {shorten(repr(shown(protein['url'])))}, but {ONLY}."
        if "simulate" in protein and "trajectory" in protein:
            yield f"{key} has a trajectory and asks to simulate one; remove one of the two keys."
        if "plddt" in protein and {"trajectory", "simulate"} & protein.keys():
            yield f"{key}.plddt cannot be used with a trajectory or a simulation; remove it, or choose residues with `residues`."
        if "simulate" in protein and protein.get("ligands"):
            yield f"{key} asks for ligands, but only the protein is simulated; remove `ligands` or `simulate`."
        if "sha256" in protein and not {"url", "pdb"} & protein.keys():
            yield f"{key}.sha256 is only for a file that is downloaded; remove it."
        for other in Protein(**protein).keys_of_atoms:
            yield f"{key}.{other} applies only to structures, but this protein is a ready surface; remove it."


def _check_fields(config: dict) -> Iterator[str]:
    """Yield a sentence for each field that is not either computed from the atoms or a column of every table."""
    columns: dict[str, set[str]] = {}  # of the table of each protein
    for name, protein in config["proteins"].items():
        if os.path.isfile(protein.get("table", "")):
            from sparsurf.dot_fields.columns import columns_of  # imports pandas, which few configs need
            from sparsurf.surfaces.surface import is_field_name

            columns[name] = {*filter(is_field_name, columns_of(protein["table"]))}
            if not columns[name] & {*config["fields"]} and all(
                registry.has("field", field) for field in config["fields"]
            ):
                yield f"proteins.{name}.table: `fields` names none of its columns; name one, or remove `table`."
    for k, field in enumerate(config["fields"]):
        if registry.has("field", field):
            whose = registry.origin("field", registry.find("field", field, "fields"))
            for name in columns:
                if field in columns[name]:
                    yield (
                        f"fields.{k} is {field!r}, which is {whose} and also a column of proteins.{name}.table; rename the "
                        "column."
                    )
        elif not (columns and all(field in names for names in columns.values())):
            allowed = one_of(field, registry.names("field"), f" {OR_INSTALLED}")
            end = "" if allowed.endswith("?") else "."
            yield f"fields.{k} is {shorten(repr(field))}, but must be a column of every `table` or {allowed}{end}"


def _check_surfaces(config: dict) -> Iterator[str]:
    """Yield a sentence for each key that needs atoms where every protein is a ready surface."""
    ready = [name for name, protein in config["proteins"].items() if "surface" in protein]
    if not ready:
        return
    if len(ready) == len(config["proteins"]):
        if config["ensemble"]["run"]:
            yield "ensemble.run is true, but every protein is a ready surface without frames; remove one of the two."
        if fields := [name for name in config["fields"] if registry.has("field", name)]:
            yield f"fields names {fields[0]}, which needs atoms, but every protein is a ready surface; remove it."
    samplers = config["compare"].get("samplers", ["uniform"])
    if len(samplers) > 1 and not {"uniform", "farthest"} & {*samplers}:
        yield f"compare.samplers has neither uniform nor farthest, which proteins.{ready[0]}, a ready surface, needs; add one."


def _check_paper(config: dict) -> Iterator[str]:
    """Yield a sentence where the results could not be compared with the tables of the paper."""
    readings = config["evaluation"]["readings"]
    if not {*PUBLISHED_READINGS} & {*readings}:
        yield f"evaluation.readings is {readings}, but must include kept or full; add one of them."
    if "paper" not in config:
        return
    a1, selection = config["proteins"].get(config["paper"]), config["frames"]["selection"]
    if a1 is None:
        yield f"paper is {config['paper']!r}, which is none of the proteins {', '.join(config['proteins'])}."
    elif "surface" not in a1 and selection != "clusters":
        yield f"frames.selection is {selection}, but `paper` compares the first of the clusters; remove frames.selection."
    if not {*PUBLISHED_READINGS} <= {*readings}:
        yield f"evaluation.readings is {readings}, but `paper` needs both of [kept, full]."
    if (ranges := config["tables"]["ranges"]) != PUBLISHED_RANGES:
        yield f"tables.ranges is {ranges}, but `paper` has {PUBLISHED_RANGES} to compare with; remove tables.ranges."


def _check_sections(config: dict) -> Iterator[str]:
    compare, minimal, patches = config["compare"], config["minimal"], config["patches"]
    if compare["run"] and not config["proteins"]:
        yield "compare.run is true, but there are no surfaces to sample; name a protein under proteins."
    if len(compare.get("samplers", "ab")) == 1:
        yield f"compare.samplers names {compare['samplers'][0]} alone; name another to compare it with."
    sampled = sampled_proteins(config)
    if compare["run"] and config["proteins"] and not sampled:
        yield "sampling is false, but `compare` needs its grid; remove one of the two."
    if config.get("paper", "") in {*config["proteins"]} - {*sampled}:
        yield f"sampling is false, but `paper` needs the grid of {config['paper']}; remove one of the two."
    if "combination" in minimal and minimal["sampler"] not in registry.samplers_of_combinations():
        yield (
            f"minimal.sampler is {minimal['sampler']}, but minimal.combination is for "
            f"{' and '.join(registry.samplers_of_combinations())}; "
            "remove one of the two."
        )
    if patches["d_link"] >= min(patches["r_patch"], patches["r_zernike"]):
        yield f"patches.d_link is {patches['d_link']:g} Å, but must be smaller than r_patch and r_zernike."


def _check_batch(config: dict) -> Iterator[str]:
    """Yield a sentence for each page of a study in batches that there cannot be."""
    if "pages" in config and (config["sampling"]["run"] or not takes_batches(config)):
        yield (
            "pages applies only to a study of structures with `sampling: false`; remove it: every protein of this study has "
            "pages."
        )
        return
    batched = batched_structures(config)
    for name in config.get("pages", []):
        if name not in config["proteins"]:
            yield f"pages: {shorten(repr(name))} is none of the proteins{did_you_mean(name, config['proteins'])}."
        elif batched and name.lower() in BATCH_FOLDERS:
            yield f"pages: {name!r} is a folder of the study itself; rename the structure, or give it no page."
    files: dict[tuple[str, str], str] = {}
    for name in batched:
        path = Path(config["proteins"][name]["structure"])
        stem = path.name.lower().removesuffix(".gz").removesuffix(suffix(path))
        twin = files.setdefault((str(path.parent), stem), str(path))
        if twin != str(path):
            yield f"proteins: {twin} and {path.name} have one name; rename or remove one of the two files."


def _check_known(key: str, names: Iterable[str], config: dict) -> Iterator[str]:
    proteins = ", ".join(config["proteins"]) or "none"
    for name in names:
        if name.partition("/")[0] not in config["proteins"]:
            yield f"{key}: {name!r} is none of the proteins; these are {proteins}."


def _check_pairs(config: dict) -> Iterator[str]:
    for name, pair in config["pairs"].items():
        yield from _check_known(f"pairs.{name}", pair.get("proteins", ()), config)
        for path in [*pair.get("files", ()), *([pair["complex"]] if "complex" in pair else [])]:
            yield from _missing_file(f"pairs.{name}", path)
        partners = pair.get("proteins") or pair.get("files") or ("", None)
        if partners[0] == partners[1]:
            yield f"pairs.{name}: {partners[0]!r} is on both sides; name two partners."
        if shared := set.intersection(*map(set, pair.get("chains", [[]]))):
            yield f"pairs.{name}.chains: chain {min(shared)} is on both sides; give each chain to one partner."


def needed_conformations(config: dict) -> dict[str, list[str]]:
    """Return the proteins and conformations that pairs/<name> and changes/<name> need."""
    needed = {f"pairs/{name}": list(pair.get("proteins", ())) for name, pair in config["pairs"].items()}
    return needed | {f"changes/{name}": list(forms) for name, forms in config["changes"].items()}


def _check_changes(config: dict) -> Iterator[str]:
    for name, forms in config["changes"].items():
        yield from _check_known(f"changes.{name}", forms, config)
        for form in forms:
            protein, _, conformation = form.partition("/")
            entry = config["proteins"].get(protein, {})
            if "surface" in entry:
                yield f"changes.{name}: {form!r} is a ready surface without residues; name a structure."
            names = _known_conformations(protein, config) if entry else None
            if conformation and names and _is_absent(protein, conformation, names, config):
                single = (
                    f"changes.{name}: there is no {form!r}, as {protein} has a single form; name {protein!r}."
                )
                yield single if len(names) == 1 else absent_conformation(f"changes.{name}", form, names)
        if len({_place(form, config) for form in forms}) == 1:
            note = "" if forms[0] == forms[1] else f" ({forms[1]!r} is the same form)"
            yield f"changes.{name}: {forms[0]!r} is on both sides{note}; name another."


def _known_conformations(protein: str, config: dict) -> list[str] | None:
    """Return the names of the conformations of a protein; None where its frames must be read first."""
    entry, selection = config["proteins"][protein], config["frames"]["selection"]
    if "surface" in entry:
        return ["c1"]
    if os.path.isfile(entry.get("structure", "")) and has_one_model(Protein(**entry)):
        return ["c1" if selection == "clusters" else "f0"]
    return [f"f{number}" for number in selection] if isinstance(selection, list) else None


def _is_absent(protein: str, conformation: str, names: list[str], config: dict) -> bool:
    """Return whether none of the known names of its conformations, written with or without zeros, is this one."""
    wanted, entry = without_zeros(f"/{conformation}").removeprefix("/"), config["proteins"][protein]
    # what names no trajectory may be a single structure, whose frame is f0 whatever is selected
    may_be_single = names != ["c1"] and not {"trajectory", "simulate"} & entry.keys()
    return wanted not in names and not (may_be_single and wanted == "f0")


def _place(name: str, config: dict) -> str:
    """Return protein/conformation without leading zeros, also for a protein that stands for its first conformation."""
    if "/" in name or name not in config["proteins"]:
        return without_zeros(name)
    first = "f0" if config["frames"]["selection"] == "all" else "c1"
    return f"{name}/{(_known_conformations(name, config) or [first])[0]}"


def _check_excluded(config: dict) -> Iterator[str]:
    """Yield a sentence where `exclude` names what the study lacks, or keeps what needs an excluded part."""
    for part in config["exclude"]:
        kind, _, name = part.partition("/")
        is_listed = name in config[kind] if kind in ("pairs", "changes") else kind in config["proteins"]
        if not is_listed or (kind in config["proteins"] and name and not CONFORMATION_OR_ALL.fullmatch(name)):
            yield f"exclude: {part!r} is not part of the study; remove it, or correct its name."
        elif kind in config["proteins"] and name not in ("", "*"):
            names = _known_conformations(kind, config)
            if names and _is_absent(kind, name, names, config):
                yield absent_conformation("exclude", part, names)
    excluded = {without_zeros(part) for part in config["exclude"]}
    for part, named in needed_conformations(config).items():
        for name in named:
            if {name.partition("/")[0], _place(name, config)} & excluded and part not in config["exclude"]:
                yield f"exclude: {part} needs {name!r}, which is excluded; exclude {part} too."
                break
    left = [protein for protein in config["proteins"] if not _is_excluded(protein, excluded, config)]
    if excluded and not left and not {f"pairs/{pair}" for pair in config["pairs"]} - excluded:
        yield "exclude leaves nothing to study; keep at least one protein or one pair."


def _is_excluded(protein: str, excluded: set[str], config: dict) -> bool:
    """Return whether a protein is excluded, or each of its conformations as far as they are known."""
    conformations = _known_conformations(protein, config)
    return protein in excluded or (
        bool(conformations) and {f"{protein}/{name}" for name in conformations or ()} <= excluded
    )


CONFIG_CHECKS = (
    _check_names,
    _check_pairs,
    _check_changes,
    _check_excluded,
    _check_proteins,
    _check_fields,
    _check_surfaces,
    _check_paper,
    _check_sections,
    _check_batch,
)
