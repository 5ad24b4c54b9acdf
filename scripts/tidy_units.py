#!/usr/bin/env python3
"""Translation units that show clang-tidy the given files, one a line.

    tidy_units.py <compile_commands.json> <file>...

A source stands for itself. A header is seen through the generated unit that includes it alone, or,
when it has none, through the sources that include it, directly or not. Files that no translation unit
of the build shows are named on standard error.
"""

import json
import pathlib
import re
import sys

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)


def included_names(path):
    try:
        text = path.read_text(encoding="utf-8")
    except OSError:
        return []
    return INCLUDE.findall(text)


def main(arguments):
    if not arguments:
        print(__doc__)
        return 2
    root = pathlib.Path.cwd()
    with open(arguments[0], encoding="utf-8") as file:
        units = sorted({(pathlib.Path(entry["directory"]) / entry["file"]).resolve()
                        for entry in json.load(file)})
    headers = list(root.glob("*/**/*.hpp"))
    includes = {path: included_names(path) for path in units + headers}

    def users(name):
        """Files that include a path that ends as `name` does, and those that include these."""
        found, waiting = set(), [pathlib.Path(name)]
        while waiting:
            header = waiting.pop()
            for path, names in includes.items():
                if path not in found and any(is_same(header, other) for other in names):
                    found.add(path)
                    waiting.append(path)
        return found

    def is_same(header, include):
        parts = pathlib.PurePosixPath(include).parts
        return header.parts[-len(parts):] == parts

    selected = set()
    for name in arguments[1:]:
        path = (root / name).resolve()
        if path in units:
            selected.add(path)
        elif path.suffix == ".hpp":
            relative = pathlib.PurePosixPath(name)
            alone = "_".join(relative.with_suffix("").parts[1:]) + ".cpp"
            generated = {unit for unit in units
                         if unit.name == alone and unit.parent.name == "headers"}
            shown = generated or users(path) & set(units)
            selected |= shown
            if not shown:
                print(f"tidy_units.py: no translation unit includes {name}", file=sys.stderr)
        else:
            print(f"tidy_units.py: {name} is not compiled in this build", file=sys.stderr)
    for unit in sorted(selected):
        print(unit)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
