#!/usr/bin/env python3
"""Turns the code blocks of a Markdown file into a project and has it built and run.

    readme_snippets.py <README.md> <output folder> -- <command that builds and runs it>...

Every ```cpp and ```cmake block needs an HTML comment on the line before it that says what becomes of
it; a block without one is an error, and so is a file without any block to compile.

    <!-- compile: components=core,evaluation -->        cpp: compiled as a consumer that links these
    <!-- compile: components=core,evaluation run -->    ... and run; it must return 0
    <!-- compile: project -->                           cmake: the CMakeLists.txt that builds the
                                                        next cpp block, which is its main.cpp
    <!-- not compiled: why -->                          left out; the reason is printed

A cpp block without main() is put into one, its #include lines before it. A cpp block that a cmake
block builds says `<!-- compile: main.cpp -->` or `<!-- compile: main.cpp run -->`.
"""

import pathlib
import re
import shutil
import subprocess
import sys

BLOCK = re.compile(r"^```(\w+)[^\n]*\n(.*?)^```$", re.MULTILINE | re.DOTALL)
MARKER = re.compile(r"<!-- (compile|not compiled):((?:(?!-->).)*)-->\s*\Z", re.DOTALL)
COMPONENTS = re.compile(r"components=([\w,]+)( run)?")
LANGUAGES = ("cpp", "cmake")


class SnippetError(Exception):
    """A block that does not say what becomes of it, or says it wrongly."""


def find_blocks(text):
    """[(line, language, code, kind, instruction)]; kind is None without a marker."""
    blocks = []
    for match in BLOCK.finditer(text):
        language, code = match.groups()
        if language not in LANGUAGES:
            continue
        line = text.count("\n", 0, match.start()) + 1
        marker = MARKER.search(text[:match.start()])
        kind, instruction = marker.groups() if marker else (None, "")
        instruction = " ".join(instruction.split())
        blocks.append((line, language, code, kind, instruction))
    return blocks


def as_program(code):
    """A whole program from a block."""
    if re.search(r"\bint main\(", code):
        return code
    lines = code.splitlines()
    includes = [line for line in lines if line.startswith("#include")]
    body = [line for line in lines if not line.startswith("#include")]
    return "\n".join(includes + ["int main() {"] + body + ["return 0;", "}", ""])


def snippet_projects(text):
    """[(folder name, CMakeLists.txt, main.cpp)] and [(line, why)] of what is left out."""
    projects, left_out = [], []
    pending_cmake = None  # (line, code) of a cmake block that waits for its main.cpp
    for line, language, code, kind, instruction in find_blocks(text):
        if kind is None:
            raise SnippetError(f"line {line}: this {language} block says neither `compile:` nor "
                               "`not compiled:` in an HTML comment before it")
        if kind == "not compiled":
            if not instruction:
                raise SnippetError(f"line {line}: `not compiled:` without a reason")
            left_out.append((line, instruction))
            continue
        name = f"line_{line}"
        if language == "cmake":
            if instruction != "project":
                raise SnippetError(f"line {line}: a cmake block takes `compile: project`, "
                                   f"not `compile: {instruction}`")
            pending_cmake = (line, code)
            continue
        if instruction in ("main.cpp", "main.cpp run"):
            if pending_cmake is None:
                raise SnippetError(f"line {line}: `main.cpp` without a cmake block before it")
            cmake = pending_cmake[1]
            pending_cmake = None
        elif COMPONENTS.fullmatch(instruction):
            components = COMPONENTS.fullmatch(instruction).group(1).split(",")
            targets = " ".join(f"srslam::{component}" for component in components)
            cmake = (f"find_package(srslam REQUIRED COMPONENTS {' '.join(components)})\n"
                     f"add_executable({name} main.cpp)\n"
                     f"target_link_libraries({name} PRIVATE {targets})\n")
        else:
            raise SnippetError(f"line {line}: cannot read `compile: {instruction}`")
        if not instruction.endswith(" run"):
            # Only what is in bin/ is run.
            cmake = "set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})\n" + cmake
        projects.append((name, cmake, as_program(code)))
    if pending_cmake is not None:
        raise SnippetError(f"line {pending_cmake[0]}: no cpp block with `compile: main.cpp` follows")
    if not projects:
        raise SnippetError("there is no block to compile")
    return projects, left_out


def write_projects(projects, folder):
    shutil.rmtree(folder, ignore_errors=True)
    top = ["cmake_minimum_required(VERSION 3.16)", "project(snippets LANGUAGES CXX)",
           "file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/empty.cpp \"int main() { return 0; }\")",
           "add_executable(snippets_are_built ${CMAKE_CURRENT_BINARY_DIR}/empty.cpp)"]
    for name, cmake, code in projects:
        (folder / name).mkdir(parents=True)
        (folder / name / "CMakeLists.txt").write_text(cmake, encoding="utf-8")
        (folder / name / "main.cpp").write_text(code, encoding="utf-8")
        top.append(f"add_subdirectory({name})")
    (folder / "CMakeLists.txt").write_text("\n".join(top) + "\n", encoding="utf-8")


def main(arguments):
    if len(arguments) < 4 or arguments[2] != "--":
        print(__doc__)
        return 2
    readme, folder, command = pathlib.Path(arguments[0]), pathlib.Path(arguments[1]), arguments[3:]
    if not readme.is_file():
        print(f"{readme} does not exist")
        return 1
    try:
        projects, left_out = snippet_projects(readme.read_text(encoding="utf-8"))
    except SnippetError as error:
        print(f"{readme}: {error}")
        return 1
    for line, reason in left_out:
        print(f"{readme}:{line}: left out: {reason}")
    print(f"{len(projects)} blocks to compile: {', '.join(name for name, _, _ in projects)}",
          flush=True)
    write_projects(projects, folder)
    return subprocess.run(command, check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
