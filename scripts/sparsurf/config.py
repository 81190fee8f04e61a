"""The config of a study: schema, defaults, and what a schema cannot say, in sentences."""

import difflib
import os
from pathlib import Path

import yaml
from jsonschema import Draft202012Validator

from sparsurf import InputError, listing
from sparsurf.download import variable

SCHEMA = yaml.safe_load((Path(__file__).parents[1] / "config.schema.yaml").read_text())
OF_STRUCTURES = ("trajectory", "selection", "chains", "residues", "model", "altloc", "hydrogens", "ligands")


def check(config, files=()):
    """Return a checked copy of `config` with every default filled in.

    Parameters
    ----------
    config : dict
    files : iterable of paths
        The files the config was read from, searched for keys given twice.

    Raises
    ------
    InputError
        One sentence per mistake: the key, what was given, what is allowed.
    """
    for path in files:
        refuse_double_keys(path)
    config = _with_local_copies(_with_defaults(_with_listed_proteins(config), SCHEMA))
    errors = [_sentence(e) for e in Draft202012Validator(SCHEMA).iter_errors(config)]
    errors = errors or list(_second_check(config))
    if errors:
        raise InputError("config: " + "\n        ".join(dict.fromkeys(errors)))
    return config


def _with_listed_proteins(config):
    """Copy of the config in which a table or a folder of proteins has become their mapping."""
    proteins = config.get("proteins")
    if isinstance(proteins, str):
        return config | {"proteins": listing.from_table(proteins)}
    if isinstance(proteins, dict) and isinstance(proteins.get("folder"), str) and len(proteins) == 1:
        return config | {"proteins": listing.from_folder(proteins["folder"])}
    return config


def _with_local_copies(config):
    """Copy of the config in which a file named by an environment variable replaces one from the network."""
    if not isinstance(config.get("proteins"), dict):
        return config
    proteins = dict(config["proteins"])
    for name, protein in proteins.items():
        path = os.environ.get(variable(str(name)))
        if path and isinstance(protein, dict) and {"url", "pdb"} & set(protein):
            kind = (
                "surface"
                if path.lower().removesuffix(".gz").endswith((".dms", ".csv", ".npz"))
                else "structure"
            )
            rest = (
                {}
                if kind == "surface"
                else {k: v for k, v in protein.items() if k not in ("url", "pdb", "sha256")}
            )
            proteins[name] = rest | {kind: path}
    return config | {"proteins": proteins}


def _with_defaults(value, schema):
    """Copy of a mapping in which missing keys of the schema take their defaults."""
    if not isinstance(value, dict):
        return value
    out = dict(value)
    for key, rule in schema.get("properties", {}).items():
        if key not in out and "default" in rule:
            out[key] = rule["default"]
        if key in out:
            out[key] = _with_defaults(out[key], rule)
    return out


def _sentence(error):
    """A schema error as one sentence for the person who wrote the config."""
    key = ".".join(map(str, error.absolute_path)) or "the config"
    if error.validator == "additionalProperties":
        known = list(error.schema.get("properties", {}))
        unknown = sorted(set(error.instance) - set(known))[0]
        near = difflib.get_close_matches(unknown, known, 1, 0.5)
        hint = f"did you mean {near[0]!r}?" if near else f"the keys here are {', '.join(known)}."
        return f"unknown key {unknown!r} in {key}; {hint}"
    if error.validator == "required":
        return f"{key} lacks the key {error.message.split()[0]}."
    if error.validator == "oneOf":
        return f"{key} needs exactly one of 'structure' (with or without 'trajectory'), 'pdb', 'url' and 'surface'."
    if error.validator == "minProperties":
        return f"{key} is empty; name at least one protein."
    if error.validator == "minItems":
        least = error.validator_value
        return f"{key} is {error.instance}, but needs at least {least} value{'s' if least > 1 else ''}."
    if error.validator == "uniqueItems":
        return f"{key} holds a value twice: {error.instance}."
    named = "propertyNames" in error.absolute_schema_path or key == "run"
    if named and error.validator == "pattern":
        return f"{error.instance!r} in {key} cannot name a folder; use letters, digits, '_', '-' and '.', not '.' first."
    meaning = (
        error.schema.get("description", "") or error.parent.schema.get("description", "")
        if error.parent
        else error.schema.get("description", "")
    )
    return f"{key} is {error.instance!r}, but must be {_allowed(error)}" + (
        f" ({meaning.rstrip('.')})." if meaning else "."
    )


def _allowed(error):
    """What a schema keyword allows, in words."""
    rule = error.validator_value
    words = {
        "type": f"of type {rule}",
        "enum": f"one of {', '.join(map(str, rule)) if isinstance(rule, list) else rule}",
        "const": f"{rule!r}",
        "minimum": f"{rule} or more",
        "maximum": f"{rule} or less",
        "exclusiveMinimum": f"more than {rule}",
        "minLength": "a text that is not empty",
        "pattern": f"of the form {rule}",
    }
    return words.get(error.validator, "one of the forms that config.yaml describes")


def _second_check(config):
    """Sentences for what the schema cannot say."""
    names = {}
    for name, protein in config["proteins"].items():
        twin = names.setdefault(name.lower(), name)
        if twin != name:
            yield f"proteins {twin!r} and {name!r} differ in upper and lower case only; rename one of them."
        for key in ("structure", "trajectory", "surface"):
            if key in protein and not Path(protein[key]).is_file():
                yield f"proteins.{name}.{key}: there is no file {protein[key]!r} (paths start at the folder of the Snakefile)."
        if "surface" in protein:
            for key in OF_STRUCTURES:
                if key in protein:
                    yield f"proteins.{name}.{key} has no meaning for a ready surface; remove it."
    if "paper" in config and config["paper"] not in config["proteins"]:
        yield f"paper is {config['paper']!r}, which is none of the proteins {', '.join(config['proteins'])}."
    wishes = [key for key in ("n_S_percent", "n_S", "Z", "combination") if key in config["minimal"]]
    if len(wishes) != 1:
        yield f"minimal needs exactly one of n_S_percent, n_S, Z and combination, but has {', '.join(wishes) or 'none'}."
    patches = config["patches"]
    if patches["D_link"] >= min(patches["R_patch"], patches["R_zernike"]):
        yield f"patches.D_link is {patches['D_link']:g} Å, but must be smaller than R_patch and R_zernike."


class _Strict(yaml.SafeLoader):
    """YAML that refuses a key given twice instead of forgetting the first."""

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key, _ in node.value:
            name = self.construct_object(key)
            if name in seen:
                raise InputError(
                    f"config: the key {name!r} stands twice, the second time in line {key.start_mark.line + 1} "
                    f"of {Path(node.start_mark.name).name}; remove or rename one."
                )
            seen.add(name)
        return super().construct_mapping(node, deep)


def refuse_double_keys(path):
    """Raise InputError where a YAML file gives a key twice or is no YAML at all."""
    with open(path, encoding="utf-8") as stream:
        try:
            yaml.load(stream, _Strict)
        except yaml.YAMLError as error:
            where = f" in line {error.problem_mark.line + 1}" if getattr(error, "problem_mark", None) else ""
            raise InputError(
                f"config: {Path(path).name} is not valid YAML{where}: {error.problem}."
            ) from error
