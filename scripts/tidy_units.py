#!/usr/bin/env python3
"""Translation units that show clang-tidy the given files, one a line.

    tidy_units.py <compile_commands.json> <file>...

A source stands for itself. A header is seen through one unit that includes it: the generated one
that includes nothing else, or the source of the same name, or any, directly if possible. Files that
no translation unit of the build shows are named on standard error.
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

    def is_same(header, include):
        parts = pathlib.PurePosixPath(include).parts
        return header.parts[-len(parts):] == parts

    def one_user(header):
        """A unit that includes the header, by the shortest way; None without any."""
        seen, level = set(), [header]
        while level:
            users = sorted(path for path, names in includes.items() if path not in seen
                           and any(is_same(item, name) for item in level for name in names))
            shown = [path for path in users if path in units]
            if shown:
                return min(shown, key=lambda path: path.stem != header.stem)
            seen.update(users)
            level = users
        return None

    selected = set()
    for name in arguments[1:]:
        path = (root / name).resolve()
        if path in units:
            selected.add(path)
        elif path.suffix == ".hpp":
            relative = pathlib.PurePosixPath(name)
            alone = "_".join(relative.with_suffix("").parts[1:]) + ".cpp"
            generated = [unit for unit in units
                         if unit.name == alone and unit.parent.name == "headers"]
            shown = generated[0] if generated else one_user(path)
            if shown is None:
                print(f"tidy_units.py: no translation unit includes {name}", file=sys.stderr)
            else:
                selected.add(shown)
        else:
            print(f"tidy_units.py: {name} is not compiled in this build", file=sys.stderr)
    for unit in sorted(selected):
        print(unit)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
