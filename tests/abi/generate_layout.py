#!/usr/bin/env python3
"""Lists the types and fields whose layout crosses the compiled boundary.

    generate_layout.py <include folder> <output> <header>...

Reads the given headers and all of the project's that they include. For each class, struct and type
alias in namespace srslam it writes one line, and one for each public field; class templates are
listed for the arguments that these headers use. Relies on the layout that clang-format gives the
code: definitions start in the first column and fields are indented by two.
"""

import pathlib
import re
import sys

INCLUDE = re.compile(r'^#include "(srslam/[^"]+)"', re.MULTILINE)
NAMESPACE = re.compile(r"^namespace ([\w:]+) \{")
NAMESPACE_END = re.compile(r"^\}  // namespace")
DEFINITION = re.compile(r"^(struct|class) (\w+)[^;]*\{$")
ALIAS = re.compile(r"^using (\w+) =")
ACCESS = re.compile(r"^ (public|private|protected):")
TEMPLATE = re.compile(r"\btemplate <(.*?)>$", re.MULTILINE | re.DOTALL)
PARAMETER = re.compile(r"\b(?:typename|class|int|std::size_t)\s+(\w+)")
FIELD = re.compile(r"^  (?!static |using |friend |return |typedef |explicit |virtual |template )"
                   r"[\w:][\w:<>,&\* ]*[\w>&\*] (\w+)( = [^;]*|\{[^;]*\})?;")


def include_closure(folder, roots):
    headers = []
    waiting = list(roots)
    while waiting:
        header = waiting.pop(0)
        if header in headers or not (folder / header).is_file():
            continue  # the second: generated, holds macros only
        headers.append(header)
        waiting += INCLUDE.findall((folder / header).read_text(encoding="utf-8"))
    return headers


def strip_comment(line):
    return re.sub(r"\s*//.*$", "", line)


def read_types(text):
    """[(name, is_template, [public field])] of one header, in namespace srslam itself."""
    types = []
    namespaces = []
    current = None
    is_template = is_public = False
    for raw in text.splitlines():
        line = strip_comment(raw) if not NAMESPACE_END.match(raw) else raw
        if NAMESPACE.match(line):
            namespaces.append(NAMESPACE.match(line).group(1))
        elif NAMESPACE_END.match(line):
            namespaces.pop()
        elif line.startswith("template <"):
            is_template = True
        elif DEFINITION.match(line) and namespaces == ["srslam"]:
            kind, name = DEFINITION.match(line).groups()
            current = (name, is_template, [])
            is_public = kind == "struct"
            types.append(current)
            is_template = False
        elif ALIAS.match(line) and namespaces == ["srslam"]:
            types.append((ALIAS.match(line).group(1), is_template, []))
            is_template = False
        elif current is not None and line.startswith("};"):
            current = None
        elif current is not None and ACCESS.match(line):
            is_public = ACCESS.match(line).group(1) == "public"
        elif current is not None and is_public and FIELD.match(line):
            current[2].append(FIELD.match(line).group(1))
        elif line and not line.startswith((" ", "#")):
            is_template = False
    return types


def public_text(text):
    """The lines that stand in namespace srslam itself, not in one within it."""
    lines, namespaces = [], []
    for line in text.splitlines():
        if NAMESPACE.match(line):
            namespaces.append(NAMESPACE.match(line).group(1))
        elif NAMESPACE_END.match(line):
            namespaces.pop()
        elif namespaces == ["srslam"]:
            lines.append(strip_comment(line))
    return "\n".join(lines)


def instantiations(name, texts):
    """Arguments that a template of one argument is used with, other than parameters of templates."""
    arguments = set()
    for text in texts:
        parameters = {parameter for template in TEMPLATE.findall(text)
                      for parameter in PARAMETER.findall(template)}
        for argument in re.findall(rf"\b{name}<([^<>]+)>", text):
            if not parameters & set(re.findall(r"\w+", argument)) and "std::remove" not in argument:
                arguments.add(argument)
    return sorted(arguments)


def main(arguments):
    folder, output, roots = pathlib.Path(arguments[0]), pathlib.Path(arguments[1]), arguments[2:]
    headers = include_closure(folder, roots)
    texts = [(folder / header).read_text(encoding="utf-8") for header in headers]
    public = [public_text(text) for text in texts]
    types = [entry for text in texts for entry in read_types(text)]
    lines = ["#ifdef SRSLAM_LAYOUT_INCLUDES"]
    lines += [f'#include "{header}"' for header in headers]
    lines += ["#else"]
    for name, is_template, fields in types:
        full_names = [name]
        if is_template:
            full_names = [f"{name}<{argument}>" for argument in instantiations(name, public)]
        for full_name in full_names:
            lines.append(f"SRSLAM_LAYOUT_TYPE({full_name}),")
            lines += [f"SRSLAM_LAYOUT_FIELD({full_name}, {field})," for field in fields]
    lines += ["#endif", ""]
    output.write_text("\n".join(lines), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
