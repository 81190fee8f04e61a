"""The config of a study: schema, defaults, and what a schema cannot say, in sentences."""

import math
import os
import re
from pathlib import Path

from jsonschema import Draft202012Validator

from sparsurf import InputError
from sparsurf.molecules.formats import STRUCTURES, suffix
from sparsurf.texts import short
from sparsurf.workflow import listing
from sparsurf.workflow.code_digests import HOME
from sparsurf.workflow.download import ONLY, allowed, variable
from sparsurf.workflow.files_of_sites import asked_for, named_in
from sparsurf.workflow.jobs import plain
from sparsurf.workflow.needs import too_large
from sparsurf.workflow.registries import names, surface_suffixes
from sparsurf.workflow.schema import SCHEMA, Protein, keys_of_protein, whole, with_defaults
from sparsurf.workflow.sentences import sentence
from sparsurf.workflow.yaml_file import read_config

# What a run has of its own beside its proteins: folders, and endings of files.
OWN_FOLDERS = ("logs", "pairs", "sites")
OF_PAPER = ("as_coded", "as_written")  # readings that its verdict needs
ROWS = 10  # of its Table I
OWN_FILES = (".csv", ".md", ".png", ".svg", ".html", ".json", ".zip")
WISHES = ("floor", "n_S_percent", "n_S", "Z", "combination")  # `minimal` takes one of them
STRUCTURES_HERE = "SPARSURF_STRUCTURES"  # environment variable: a folder of structures called like PDB ids
OF_FRAME = re.compile(
    r"([cf]\d+|\*)(/\w+)?"
)  # a conformation, or what is over all, and perhaps one of its jobs
MOST_TOLD = 20  # mistakes
# Samplers that may stand beside a combination: those that draw by one, and the default, which asks for nothing.
WITH_COMBINATION = ("farthest", *names("samplers", "choosing"))
FILES = keys_of_protein("file")
LISTS = (
    ("pairs", listing.pairs_from_table, listing.pairs_from_folder),
    ("proteins", listing.from_table, listing.from_folder),
)


def completed(config, home):
    """A config that says what to study; of one that does not, each key takes the place of the default study's."""
    if not {"proteins", "pairs"}.isdisjoint(config):
        return config
    own = Path("config.yaml")
    return read_config(own if own.is_file() else Path(home) / own) | config


def checked(config, files, home, here=True):
    """As `check`; a mistake ends the program with its sentences."""
    try:
        return check(config, files, home, here)
    except InputError as error:
        raise SystemExit(f"\n{error}\n") from None


def check(config, files=(), home=".", here=True):
    """Return a checked copy of `config` with every default filled in.

    Parameters
    ----------
    config : dict
    files : iterable of paths
        The files the config was read from, searched for keys given twice.
    home : path
        Where files lie that are not in the working directory: the folder of the Snakefile, with the embedded example.
    here : bool
        Whether jobs run on this machine: its memory is compared with what the grid asks for.

    Raises
    ------
    InputError
        One sentence per mistake: the key, what was given, what is allowed.
    """
    for path in files:
        read_config(path)
    errors = list(_no_values(config))
    if not errors:
        config = whole(with_defaults(_with_listed_proteins(config)))
        if isinstance(config["minimal"], dict) and not set(WISHES) & set(config["minimal"]):
            config["minimal"]["floor"] = SCHEMA["properties"]["minimal"]["default"]["floor"]
        config = _with_files_at_home(_with_local_copies(config), Path(home))
        found = _but_own_fields([*Draft202012Validator(SCHEMA).iter_errors(config)], config)
        errors = [sentence(error) for error in found]
    errors = errors or list(_second_check(config)) + list(too_large(config) if here else ())
    if errors:
        told = [*dict.fromkeys(errors)]
        more = [f"{len(told) - MOST_TOLD} more mistakes."] if len(told) > MOST_TOLD else []
        raise InputError("config: " + "\n        ".join(told[:MOST_TOLD] + more))
    return config


def _with_listed_proteins(config):
    """Copy of the config in which a table or a folder of proteins or pairs has become their mapping."""
    for key, from_table, from_folder in LISTS:
        if isinstance(config.get(key), str):
            config = config | {key: from_table(config[key])}
        elif folder := _folder(config.get(key), key):
            config = config | {key: from_folder(folder)}
    return {"proteins": {}} | config if config.get("pairs") else config  # pairs of files need no proteins


def _folder(listed, key):
    """The folder that `proteins` or `pairs` name in place of entries; None where they do not."""
    if not (isinstance(listed, dict) and isinstance(listed.get("folder"), str)):
        return None
    others = [str(name) for name in listed if name != "folder"]
    if others:
        raise InputError(
            f"config: {key}.folder stands alone, but {', '.join(others)} stands beside it; name every entry, or give a table."
        )
    return listed["folder"]


def with_comparison(given):
    """A config as given, with the comparison of samplers asked for."""
    asked = given.get("compare")
    return given | {"compare": (asked if isinstance(asked, dict) else {}) | {"run": True}}


def _with_local_copies(config):
    """Copy of the config in which a file named by an environment variable replaces one from the network."""
    if not isinstance(config.get("proteins"), dict):
        return config
    proteins = dict(config["proteins"])
    for name, protein in proteins.items():
        if not (isinstance(protein, dict) and {"url", "pdb"} & set(protein)):
            continue
        if type(protein.get("pdb")) is int:  # YAML reads the id 4530 as a number
            proteins[name] = protein = protein | {"pdb": str(protein["pdb"])}
        own = os.environ.get(variable(str(name))) if variable(str(name)) != STRUCTURES_HERE else None
        path = own or _by_id(protein.get("pdb"))
        if path:
            kind = "surface" if suffix(path) in surface_suffixes() else "structure"
            rest = (
                {}
                if kind == "surface"
                else {k: v for k, v in protein.items() if k not in ("url", "pdb", "sha256")}
            )
            proteins[name] = rest | {kind: path}
    return config | {"proteins": proteins}


def _by_id(pdb):
    """The structure called like a PDB id in the folder that SPARSURF_STRUCTURES names, if there is one."""
    folder = os.environ.get(STRUCTURES_HERE)
    if not (folder and isinstance(pdb, str)):
        return None
    if not Path(folder).is_dir():
        raise InputError(f"{STRUCTURES_HERE} is {folder!r}, but there is no such folder.")
    names = {pdb.lower() + ending for ending in STRUCTURES}
    found = [
        path for path in sorted(Path(folder).iterdir()) if path.name.lower().removesuffix(".gz") in names
    ]
    return str(found[0]) if found else None


def _with_files_at_home(config, home):
    """Copy of the config in which a file that is only in `home` has its path from there."""
    if not isinstance(config.get("proteins"), dict):
        return config

    def found(key, value):
        here = key not in FILES or not isinstance(value, str) or os.path.exists(value)
        return value if here or not os.path.isfile(home / value) else str(home / value)

    proteins = {
        name: {key: found(key, value) for key, value in protein.items()}
        if isinstance(protein, dict)
        else protein
        for name, protein in config["proteins"].items()
    }
    return config | {"proteins": proteins}


def _no_values(value, key="the config"):
    """Sentences for keys that are not strings, and NaN, wherever they stand."""
    if isinstance(value, float) and not math.isfinite(value):
        yield f"{key} is {value}, but must be a number."
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for name, each in inside:
        if isinstance(value, dict) and not isinstance(name, str):
            comma = value[name] is None  # {residues: A:57,102}
            what = "has no value; put a value with commas" if comma else "is not read as a string; put it"
            yield f"the key {name!r} in {key} {what} in quotes."
        yield from _no_values(each, f"{key}.{name}".removeprefix("the config."))


def _but_own_fields(errors, config):
    """Errors of the schema without those of a field that is a column of every protein's table, of one at least."""
    unknown = [error for error in errors if error.validator == "enum" and error.absolute_path[0] == "fields"]
    if len(unknown) < len(errors):
        return [error for error in errors if error not in unknown]  # a table may be among the mistakes
    tables = [entry["table"] for entry in config["proteins"].values() if "table" in entry] if unknown else []
    if tables:
        from sparsurf.dot_fields.columns import TAKEN, columns_of  # here: pandas, which few configs need
    own = [[name for name in columns_of(path) if name not in TAKEN] for path in tables]
    return [error for error in unknown if not (own and all(error.instance in names for names in own))]


def _second_check(config):
    """Sentences for what the schema cannot say."""
    if not config["proteins"] and not config["pairs"]:
        yield "proteins is empty; name at least one protein."
    yield from _check_names(config)
    yield from _check_pairs(config)
    yield from _check_sites(config)
    yield from _check_left_out(config)
    for name, protein in config["proteins"].items():
        for key in FILES:
            if key in protein and not os.path.isfile(protein[key]):
                yield f"proteins.{name}.{key}: there is no file {short(repr(protein[key]))} (paths start at {Path.cwd()})."
        if "url" in protein and not allowed(protein["url"], protein.get("sha256")):
            yield f"proteins.{name}.url is {short(repr(protein['url']))}, but {ONLY}."
        if "simulate" in protein and "trajectory" in protein:
            yield f"proteins.{name} has a trajectory and asks to simulate one; remove one of the two keys."
        if "simulate" in protein and protein.get("ligands"):
            yield f"proteins.{name} asks for ligands, but a simulation is of the protein alone; remove `ligands` or `simulate`."
        if "table" in protein and "surface" not in protein and not {*config["fields"]} - {*names("fields")}:
            yield f"proteins.{name}.table: `fields` names none of its columns; name one, or remove `table`."
        if "sha256" in protein and not {"url", "pdb"} & protein.keys():
            yield f"proteins.{name}.sha256 is what a fetched file must have, and this one is not fetched; remove it."
        for key in Protein(**protein).without_meaning:
            yield f"proteins.{name}: remove `{key}`: it applies to structures, and this protein is a ready surface."
    if "paper" in config:
        a1 = config["proteins"].get(config["paper"])
        if a1 is None:
            yield f"paper is {config['paper']!r}, which is none of the proteins {', '.join(config['proteins'])}."
        elif "surface" not in a1 and config["frames"]["use"] != "clusters":
            use = config["frames"]["use"]
            yield f"frames.use is {use}, but `paper` compares the first of the clusters; leave frames.use out."
        if not set(OF_PAPER) <= set(config["evaluation"]["readings"]):
            yield f"evaluation.readings is {config['evaluation']['readings']}, but `paper` needs both of [as_coded, as_written]."
        if config["tables"]["ranges"] != ROWS:
            yield f"tables.ranges is {config['tables']['ranges']}, but `paper` has {ROWS} to compare with; leave it out."
    if not set(OF_PAPER) & set(config["evaluation"]["readings"]):
        yield f"evaluation.readings is {config['evaluation']['readings']}, but needs as_coded or as_written."
    if config["compare"]["run"] and not config["proteins"]:
        yield "compare.run is true, but there are no surfaces to sample; name a protein under proteins."
    ready = [name for name, protein in config["proteins"].items() if "surface" in protein]
    if ready and len(ready) == len(config["proteins"]):
        if config["ensemble"]["run"]:
            yield "ensemble.run is true, but every protein is a ready surface without frames; remove one of the two."
        if own := [name for name in config["fields"] if name in names("fields")]:
            yield f"fields names {own[0]}, which follows from atoms, but every protein is a ready surface; remove it."
    compared = config["compare"].get("samplers", ["uniform", "farthest"])
    if len(compared) == 1:
        yield f"compare.samplers names {compared[0]} alone; name another to compare it with."
    elif ready and not {"uniform", "farthest"} & set(compared):
        yield f"compare.samplers has neither uniform nor farthest, which proteins.{ready[0]}, a ready surface, needs; add one."
    radii = config["surface"]["radii"]
    if config["surface"]["method"] == "dms" and radii != "dms":
        yield f"surface.radii is {radii}, but the program DMS of surface.method takes its own; remove one of the two."
    if not config["sampling"]["run"]:
        for key, asked in {"compare": config["compare"]["run"], "paper": "paper" in config}.items():
            if asked:
                yield f"sampling is false, but `{key}` needs its grid; remove one of the two."
    if Path("results", config["run"]).exists() and not Path("results", config["run"]).is_dir():
        yield f"run is {config['run']!r}, but results/{config['run']} is a file; choose another name."
    requests = [key for key in WISHES if key in config["minimal"]]
    if len(requests) > 1:
        yield f"minimal needs exactly one of {', '.join(WISHES[:-1])} and {WISHES[-1]}, but has {', '.join(requests)}."
    sampler = config["minimal"]["sampler"]
    if "combination" in requests and sampler not in WITH_COMBINATION:
        yield f"minimal.sampler is {sampler}, but minimal.combination is of the paper's; leave out one of the two."
    floor = config["minimal"].get("floor", "")
    if floor.startswith("atoms") and ready:
        yield f"minimal.floor is {floor!r}, but proteins.{ready[0]} is a ready surface without atoms; take fresh dots or turned."
    patches = config["patches"]
    if patches["D_link"] >= min(patches["R_patch"], patches["R_zernike"]):
        yield f"patches.D_link is {patches['D_link']:g} Å, but must be smaller than R_patch and R_zernike."


def _check_names(config):
    """Sentences for names that are folders of results: unlike in more than case, and not the study's own."""
    for key in ("proteins", "pairs", "sites"):
        names = {}
        for name in config[key]:
            twin = names.setdefault(name.lower(), name)
            if twin != name:
                yield f"{key} {twin!r} and {name!r} differ in upper and lower case only; rename one of them."
            if name.lower().endswith(OWN_FILES) or name.lower() in OWN_FOLDERS:
                yield f"{key}: {name!r} is what the study calls a file or folder of its own; choose another name."


def _check_pairs(config):
    """Sentences for what the schema cannot say of pairs."""
    for name, pair in config["pairs"].items():
        for protein in pair.get("proteins", ()):
            if protein not in config["proteins"]:
                known = ", ".join(config["proteins"]) or "none"
                yield f"pairs.{name}: {protein!r} is none of the proteins; these are {known}."
        for path in [*pair.get("files", ()), *([pair["complex"]] if "complex" in pair else [])]:
            if not os.path.isfile(path):
                yield f"pairs.{name}: there is no file {short(repr(path))} (paths start at {Path.cwd()})."
        sides = pair.get("proteins") or pair.get("files") or ()
        if len(sides) == 2 and sides[0] == sides[1]:
            yield f"pairs.{name}: {sides[0]!r} stands on both sides; name two partners."
        both = set.intersection(*map(set, pair["chains"])) if "chains" in pair else ()
        if both:
            yield f"pairs.{name}.chains: chain {sorted(both)[0]} stands on both sides; give each chain to one partner."
    thinning = config["complementarity"]["thinning"]
    if thinning["run"] and not config["pairs"]:
        yield "complementarity.thinning.run is true, but there are no pairs to thin; name one under pairs."


def _check_sites(config):
    """Sentences for what the schema cannot say of sites."""
    for name, site in config["sites"].items():
        named = named_in(site)
        for each in named:
            if each.partition("/")[0] not in config["proteins"]:
                known = ", ".join(config["proteins"]) or "none"
                yield f"sites.{name}: {each!r} is none of the proteins; these are {known}."
        for each in named if "changes" in site else named[:1]:
            if "surface" in config["proteins"].get(each.partition("/")[0], ()):
                yield f"sites.{name}: {each!r} is a ready surface without residues; it can only be a target."
        if named[0] in named[1:]:
            yield f"sites.{name}: {named[0]!r} stands on both sides; name another."


def _check_left_out(config):
    """Sentences for places to leave out that the config does not have; a job over all proteins is called like its script."""
    jobs = tuple(path.stem for path in (HOME / "scripts").glob("*.py"))
    for place in config["without"]:
        kind, _, name = place.partition("/")
        if kind in ("pairs", "sites") and name:
            known = name in config[kind]
        else:
            known = kind in config["proteins"] and (not name or OF_FRAME.fullmatch(name))
        if not known and (name or not place.startswith(jobs)):
            yield f"without: {place!r} is no part of the study; remove it, or correct its name."
    first = "c1" if config["frames"]["use"] == "clusters" else "f0"  # of a protein, which stands for it
    without = {plain(place) for place in config["without"]}
    for place, proteins in asked_for(config).items():
        own = {
            each: {plain(each), each.partition("/")[0], *([] if "/" in each else [f"{each}/{first}"])}
            for each in proteins
        }
        gone = [each for each in proteins if own[each] & without]
        if gone and place not in config["without"]:
            yield f"without: {place} needs {gone[0]!r}, which is left out; leave {place} out, too."
