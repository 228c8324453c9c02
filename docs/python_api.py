"""Makes the reference of the Python package from the docstrings of the installed wheel.

    python_api.py FOLDER

The package is compiled, so pdoc finds no types in it; they stand in `_starbreak.pyi`, for a module that
nobody imports by that name. So pdoc gets that file as the types of the package itself. It runs the file,
where a type checker only reads it: names that stand for types come last then, after the classes in them,
of overloads the last one stays, which is the most general, and types are those that a reader would name.
"""

from __future__ import annotations

import importlib.util
import pathlib
import re
import sys
import tempfile

import pdoc

MODULES = ["starbreak", "starbreak.carla", "starbreak.transforms"]


def runnable(stub: str) -> str:
    """A file of types, as a program."""
    lines = [line for line in stub.splitlines() if line.strip() != "@overload"]
    is_alias = [": TypeAlias = " in line for line in lines]
    body = [line for line, alias in zip(lines, is_alias) if not alias]
    aliases = [line for line, alias in zip(lines, is_alias) if alias]
    # After the docstring, before all else.
    program = "\n".join([body[0], "from __future__ import annotations", *body[1:], *aliases, ""])
    program = re.sub(r"(?<=: )SupportsIndex|(?<=\[)SupportsIndex(?=\])", "int", program)
    return re.sub(r"npt\.NDArray\[np\.\w+(\[\w+\])?\]", "np.ndarray", program)


def main() -> None:
    """Makes it."""
    (folder,) = sys.argv[1:]
    package = pathlib.Path(importlib.util.find_spec("starbreak").origin).parent
    with tempfile.TemporaryDirectory() as temporary:
        types = pathlib.Path(temporary, "starbreak-stubs/__init__.pyi")
        types.parent.mkdir()
        types.write_text(runnable((package / "_starbreak.pyi").read_text()))
        sys.path.append(temporary)
        pdoc.render.configure(docformat="markdown", show_source=False)
        pdoc.pdoc(*MODULES, output_directory=pathlib.Path(folder))


if __name__ == "__main__":
    main()
