"""Mistakes that could be planted in a file: small changes of its text, found in the syntax tree or line by line.

`mistakes(path, text)` gives them all; each is (line, what, text of the changed file). Sources of the operators: those of
mutation testing in general (Jia and Harman 2011, doi 10.1109/TSE.2010.62), and for rules what was once forgotten in one.
"""

import ast
import re

SWAPPED = {
    ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "==",
    ast.Is: "is not", ast.IsNot: "is", ast.In: "not in", ast.NotIn: "in",
    ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.FloorDiv: "*", ast.Mod: "*", ast.Pow: "*",
    ast.And: "or", ast.Or: "and",
}  # fmt: skip
OTHER_NAMES = {
    "min": "max", "max": "min", "any": "all", "all": "any", "argmin": "argmax", "argmax": "argmin", "sum": "mean",
    "mean": "median", "floor": "ceil", "ceil": "floor", "minimum": "maximum", "maximum": "minimum", "first": "last",
    "sin": "cos", "cos": "sin", "nanmax": "nanmin", "nanmin": "nanmax", "cumsum": "cumprod", "low": "high", "high": "low",
}  # fmt: skip
SILENT = ("log", "print", "warnings", "message", "parser", "field")  # calls whose words are for people
HARMLESS = {  # of arguments
    "cache", "fastmath", "nogil", "ensure_ascii", "encoding", "indent", "exist_ok", "strict", "dpi", "fontsize", "help",
    "metavar",
}  # fmt: skip
RULE_LINE = re.compile(
    r"^(\s+)(\w+=.*|\*\*.*|[\w.]+\(.*\)|f?\".*\"),\s*$"
)  # an argument of a rule, on a line of its own
NUMBER = re.compile(r"-?[\d.]+(e-?\d+)? is ")  # what `of_python` calls a number that became another
RULE_PARTS = {"input", "output", "params"}


def mistakes(path, text):
    """The mistakes of one file, by its ending: Python, rules, or the viewer's script."""
    if path.suffix == ".py":
        drawn = "figures" in path.parts  # a millimetre more or less is no mistake there
        yield from (each for each in of_python(text) if not (drawn and NUMBER.match(each[1])))
    elif path.suffix == ".js":
        yield from of_script(text)
    else:
        yield from of_rules(text)


def of_python(text):
    """Changes of operators, numbers, truth values, arguments, conditions and names."""
    tree = ast.parse(text)
    skipped = set()
    for node in ast.walk(tree):
        if id(node) in skipped or _is_for_people(node):
            skipped |= {id(each) for each in ast.walk(node)}
            continue
        for what, piece, new in _changes(node, text):
            changed = _replaced(text, piece, new)
            if changed != text and _compiles(changed):
                yield piece[0], what, changed


def _is_for_people(node):
    """Whether a node is a message, an import, a decorator's settings, or what runs a script by hand."""
    if isinstance(node, (ast.Import, ast.ImportFrom, ast.JoinedStr, ast.Raise, ast.Assert)):
        return True
    if isinstance(node, ast.If) and "__name__" in ast.unparse(node.test):
        return True
    if isinstance(node, ast.Call):
        name = ast.unparse(node.func)
        return name.split(".")[0] in SILENT or name in ("njit", "add_argument")
    return False


def _changes(node, text):
    """(what, place, new text) of a node; a place is (line, first byte, last line, end byte)."""
    if isinstance(node, ast.Compare):
        yield _between(node, node.left, node.comparators[0], SWAPPED.get(type(node.ops[0])), text)
    elif isinstance(node, ast.BinOp) and not isinstance(node.left, ast.Constant | ast.JoinedStr):
        new = SWAPPED.get(type(node.op))
        if new:
            yield _between(node, node.left, node.right, new, text)
    elif isinstance(node, ast.BoolOp):
        yield _between(node, node.values[0], node.values[1], SWAPPED[type(node.op)], text)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        yield "no longer negated", _place(node), ast.get_source_segment(text, node.operand)
    elif isinstance(node, ast.Constant) and type(node.value) in (int, float, bool):
        yield f"{node.value} is {_other(node.value)}", _place(node), _other(node.value)
    elif isinstance(node, ast.If | ast.IfExp | ast.While):
        test = ast.get_source_segment(text, node.test)
        yield "condition negated", _place(node.test), f"(not ({test}))"
    elif isinstance(node, ast.Call):
        yield from _of_call(node, text)
    elif isinstance(node, ast.Attribute) and node.attr in OTHER_NAMES:
        old = ast.get_source_segment(text, node)
        new = old[: len(old) - len(node.attr)] + OTHER_NAMES[node.attr]
        yield f"{node.attr} is {OTHER_NAMES[node.attr]}", _place(node), new


def _of_call(node, text):
    """An argument dropped, two swapped, another function of the same kind."""
    segment = ast.get_source_segment(text, node)
    for keyword in node.keywords:
        if keyword.arg and keyword.arg not in HARMLESS:
            call = ast.parse(ast.unparse(node), mode="eval").body
            call.keywords = [each for each in call.keywords if each.arg != keyword.arg]
            yield f"argument {keyword.arg} dropped", _place(node), ast.unparse(call)
    if len(node.args) > 1 and not any(isinstance(each, ast.Starred) for each in node.args[:2]):
        call = ast.parse(ast.unparse(node), mode="eval").body
        call.args[:2] = call.args[1::-1]
        if ast.dump(call.args[0]) != ast.dump(call.args[1]):
            yield "first two arguments swapped", _place(node), ast.unparse(call)
    if isinstance(node.func, ast.Name) and node.func.id in OTHER_NAMES:
        new = OTHER_NAMES[node.func.id]
        yield f"{node.func.id} is {new}", _place(node), new + segment[len(node.func.id) :]


def _other(value):
    """Another value of the same type, as text."""
    if isinstance(value, bool):
        return str(not value)
    return str(value + 1) if isinstance(value, int) else repr(value * 1.5 or 1.0)


def _place(node):
    return node.lineno, node.col_offset, node.end_lineno, node.end_col_offset


def _between(node, left, right, new, text):
    """The operator between two operands, replaced."""
    place = left.end_lineno, left.end_col_offset, right.lineno, right.col_offset
    old = _cut(text, place)
    operator = re.search(r"[^\s()]+(?: not| in)?", old.replace("(", " ").replace(")", " "))
    changed = old[: operator.start()] + new + old[operator.end() :] if operator else old
    return f"{operator.group() if operator else old} is {new}", place, changed


def _cut(text, place):
    a, b = _offsets(text, place)
    return text.encode()[a:b].decode()


def _replaced(text, place, new):
    a, b = _offsets(text, place)
    return (text.encode()[:a] + new.encode() + text.encode()[b:]).decode()


def _offsets(text, place):
    """First and last byte of a place in the text."""
    starts = [0]
    for line in text.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    line, column, last, end = place
    return starts[line - 1] + column, starts[last - 1] + end


def _compiles(text):
    try:
        compile(text, "planted", "exec")
    except (SyntaxError, ValueError):
        return False
    return True


def of_rules(text):
    """Of each rule's inputs, outputs and params a line dropped; of `made_by` and `needs` an argument."""
    lines, part = text.splitlines(keepends=True), None
    for k, line in enumerate(lines):
        if opened := re.match(r"^\s+(\w+):\s*$", line):
            part = opened.group(1)
        elif not line.strip() or not line.startswith(" "):
            part = None
        if part in RULE_PARTS and RULE_LINE.match(line):
            yield k + 1, f"dropped: {line.strip()}", "".join(lines[:k] + lines[k + 1 :])
        if "made_by(" in line or "needs(" in line:
            for argument in re.finditer(r", (\"[\w.]+\"|\*?\w+(?:=\w+)?|1 / \w+)(?=[,)])", line):
                rest = line[: argument.start()] + line[argument.end() :]
                yield (
                    k + 1,
                    f"dropped: {argument.group(1)} of {line.strip()}",
                    "".join([*lines[:k], rest, *lines[k + 1 :]]),
                )


def of_script(text):
    """A number or a comparison of the viewer's script changed."""
    for found in re.finditer(r"(?<![\w.#\"'])\d+\.?\d*(?![\w.\"'%])| [<>] ", text):
        old = found.group()
        new = {" < ": " > ", " > ": " < "}.get(old) or str(float(old) + 1).removesuffix(".0")
        line = text.count("\n", 0, found.start()) + 1
        yield line, f"{old.strip()} is {new.strip()}", text[: found.start()] + new + text[found.end() :]
