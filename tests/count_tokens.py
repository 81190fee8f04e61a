"""Count the tokens of the Python code of folders, without comments and docstrings: `count_tokens.py src scripts`."""

import ast
import io
import sys
import tokenize
from pathlib import Path

NO_CODE = {
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER
}  # fmt: skip


def tokens(text: str) -> int:
    docstrings = {
        (node.body[0].lineno, node.body[0].col_offset)
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
        and ast.get_docstring(node) is not None
    }
    found = tokenize.generate_tokens(io.StringIO(text).readline)
    return sum(each.type not in NO_CODE and each.start not in docstrings for each in found)


if __name__ == "__main__":
    for folder in sys.argv[1:]:
        paths = [*Path(folder).rglob("*.py")]
        print(
            folder,
            sum(tokens(path.read_text(encoding="utf-8")) for path in paths),
            "tokens in",
            len(paths),
            "files",
        )
