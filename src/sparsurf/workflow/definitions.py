"""The definitions behind a script: what of the library its code reaches, statement by statement.

A module is a list of top-level statements, each with a digest of its syntax tree (no docstring, no comment) and with the
names that it uses. From a script these names lead to other statements, so that an edit concerns those who use it only.
"""

import ast
import hashlib
import json
import os
import sys
from collections import defaultdict
from functools import cache
from pathlib import Path

import sparsurf

LIBRARY = Path(sparsurf.__file__).resolve().parent
# The frame of every job; the glossary and where numba keeps its kernels say nothing about a result
LEFT_OUT = {LIBRARY / path for path in ("__init__.py", "kernel_cache.py", "workflow/jobs.py")}
TEMPLATES = LIBRARY / "report" / "templates"
KEPT = LIBRARY.parents[1] / ".cache" / "definitions.json"  # parsed modules, by their content
MOST_KEPT = 1000
LONGEST = 100  # letters of a string that may name a file or a module
VERSION = hashlib.sha256(Path(__file__).read_bytes() + sys.version.encode()).digest()


def reached(script, but=()):
    """Statements and data files behind a script, as {path: sorted digests}; nothing of, and behind, files with one of `but` in
    their path.

    A name that leads to no statement stands for its whole module. Expressions count whenever something of their module is
    used; what a decorator enters in a table counts, in all modules of its package, whenever the table is used.
    """
    start = (Path(script), None)
    found, waiting, seen, folder = defaultdict(set), [start], {start}, Path(script).parent
    while waiting:
        place = waiting.pop()
        digests, places = _followed(*place, folder)
        found[place[0]] |= digests
        places = {each for each in places - seen if not any(part in str(each[0]) for part in but)}
        waiting += places
        seen |= places
    return {path: sorted(digests) for path, digests in found.items()}


@cache
def _followed(path, name, folder):
    """Digests of what a name of a file stands for, and the places (path, name) that it leads to."""
    statements = _statements(path, name)
    uses = {use for _, used in statements for use in used}
    places = {place for use in uses for place in _places(use, path, folder)}
    return {digest for digest, _ in statements}, places


def _statements(path, name):
    """(digest, uses) of each statement that a name of a file stands for; of all of them where it is None."""
    if path.suffix != ".py":
        return [_data(path)]
    module = parsed(path)
    numbers = module["names"].get(name)
    if name in module["imports"] and not numbers:  # it comes from elsewhere
        return [("", module["imports"][name])]
    return (
        [module["statements"][k] for k in {*numbers, *module["always"]}] if numbers else module["statements"]
    )


def _data(path):
    """(digest, uses) of a data file; a template may name others."""
    content = path.read_bytes()
    words = content.decode().replace("'", '"').split('"') if path.suffix == ".j2" else []
    return hashlib.sha256(content).hexdigest(), [f"={word}" for word in words if word.endswith(".j2")]


def _places(use, path, folder):
    """(path, name) that a use in the file `path` may mean; the name is None for a whole file."""
    if use.startswith("."):
        return [(path, use[1:])]
    if use.startswith("="):
        return [(each, None) for each in (path.with_name(use[1:]), TEMPLATES / use[1:]) if each.is_file()]
    if use.startswith("@"):
        return [
            (beside, name)
            for beside in path.parent.glob("*.py")
            for name in parsed(beside)["decorated"].get(
                use if beside == path else f"{_dotted(path)}.{use[1:]}", ()
            )
        ]
    place = _module(use, folder)
    return [place] if place and place[0] not in LEFT_OUT else []


def _dotted(path):
    return ".".join(path.relative_to(LIBRARY.parent).with_suffix("").parts)


@cache
def _module(dotted, folder):
    """(path, name in it or None) of a dotted name; None of what is neither in the library nor beside the script."""
    first, *rest = dotted.split(".")
    if first == "sparsurf" and rest and rest[0] in sparsurf.CALLS:  # what users call
        return _module(f"sparsurf.{sparsurf.CALLS[rest[0]]}.{rest[0]}", folder)
    place = (LIBRARY.parent if first == "sparsurf" else folder) / first
    while rest and not place.with_suffix(".py").is_file():
        place /= rest.pop(0)
    module = place.with_suffix(".py")
    return (module, rest[0] if rest else None) if module.is_file() else None


@cache
def parsed(path):
    """The statements of a module, as `parse` finds them."""
    content = path.read_bytes()
    key = hashlib.sha256(content + VERSION).hexdigest()
    if key not in _kept():
        _kept()[key] = parse(content)
        _kept()["new"] = True
    return _kept()[key]


@cache
def _kept():
    try:
        known = json.loads(KEPT.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return known if len(known) < MOST_KEPT else {}


def keep():
    """Store the modules that were parsed for the next time, which takes a tenth of it then."""
    if not _kept().pop("new", False):
        return
    part = KEPT.with_name(f"{KEPT.name}.{os.getpid()}")
    try:
        KEPT.parent.mkdir(exist_ok=True)
        part.write_text(json.dumps(_kept()), encoding="utf-8")
        os.replace(part, KEPT)
    except OSError:  # it is a matter of time only
        part.unlink(missing_ok=True)


def parse(text):
    """What a module consists of.

    Parameters
    ----------
    text : str or bytes

    Returns
    -------
    dict
        statements : list of [digest, uses]; a use is '.name' in the module, a dotted name elsewhere, '=file' beside it, or
            '@name': what stands under this decorator of the module
        names : dict of name to the numbers of the statements that bind it
        imports : dict of name to the dotted names that it stands for, wherever in the module
        decorated : dict of a decorator, as dotted name or '@name', to the names of what stands under it
        always : numbers of the statements that count whatever is used
    """
    tree = ast.parse(text)
    imports, names, decorated, statements = _imports(tree), defaultdict(list), defaultdict(list), []
    for node in ast.walk(tree):
        _drop_docstring(node)
    own = [each for each in tree.body if not isinstance(each, (ast.Import, ast.ImportFrom))]
    for number, each in enumerate(own):
        for name in _bound(each):
            names[name].append(number)
    for each in own:
        uses = {use for name in _used(each) for use in _meant(name, names, imports)}
        digest = hashlib.sha256(ast.dump(each).encode()).hexdigest()[:16]
        statements.append((digest, uses | _texts(each)))
        for use in _above(each, names, imports):
            decorated[use].append(each.name)
    for each in own:
        for table in _filled(each, names):
            for number in names[table]:
                statements[number][1].add(f"@{each.name}")
    return {
        "statements": [(digest, sorted(uses)) for digest, uses in statements],
        "names": names,
        "imports": imports,
        "decorated": decorated,
        "always": [number for number, each in enumerate(own) if not _bound(each)],
    }


def _imports(tree):
    found = defaultdict(list)
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                found[alias.asname or alias.name.split(".")[0]].append(alias.name)
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                found[alias.asname or alias.name].append(f"{node.module}.{alias.name}")
    return found


def _drop_docstring(node):
    match node:
        case ast.AST(body=[ast.Expr(value=ast.Constant(value=str())), *_]):
            del node.body[0]


def _bound(statement):
    """Names that a definition or an assignment of the top level binds."""
    if isinstance(statement, (ast.FunctionDef, ast.ClassDef)):
        return [statement.name]
    if not isinstance(statement, (ast.Assign, ast.AnnAssign, ast.AugAssign)):
        return []
    return [n.id for n in ast.walk(statement) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]


def _used(node):
    """Names in a node, with the attribute that is asked of them."""
    inner = list(ast.walk(node))
    asked = {id(n.value): f".{n.attr}" for n in inner if isinstance(n, ast.Attribute)}
    return {n.id + asked.get(id(n), "") for n in inner if isinstance(n, ast.Name)}


def _meant(used, names, imports):
    """Uses that a name, perhaps with an attribute, stands for."""
    name, _, attribute = used.partition(".")
    own = [f".{name}"] if name in names else []
    return own + [f"{dotted}.{attribute}".rstrip(".") for dotted in imports.get(name, ())]


def _texts(node):
    """Uses by strings: names of files beside the module, and of modules of the library."""
    texts = {n.value for n in ast.walk(node) if isinstance(n, ast.Constant) and isinstance(n.value, str)}
    named = {text for text in texts if "." in text[1:-1] and len(text) < LONGEST and not {*"/ \n"} & {*text}}
    return {text if text.startswith("sparsurf.") else f"={text}" for text in named}


def _above(statement, names, imports):
    """Decorators above a definition, as they are called in `decorated`."""
    used = {name for each in getattr(statement, "decorator_list", ()) for name in _used(each)}
    return {
        use.replace(".", "@", 1) if use[0] == "." else use
        for name in used
        for use in _meant(name, names, imports)
    }


def _filled(statement, names):
    """Tables of the module that a function enters something in."""
    inner = ast.walk(statement) if isinstance(statement, ast.FunctionDef) else ()
    entries = [n for n in inner if isinstance(n, ast.Subscript) and isinstance(n.ctx, ast.Store)]
    return {n.value.id for n in entries if isinstance(n.value, ast.Name)} & {*names}
