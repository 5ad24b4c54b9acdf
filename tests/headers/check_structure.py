#!/usr/bin/env python3
"""Checks the source tree against the components that CMake was told of.

    check_structure.py <project folder> <components.txt>

- Every public header and every source belongs to exactly one component.
- A lower stage never includes a later one, and only what it declares in DEPENDS.
- Headers of components that need Eigen alone include Eigen, the standard library and srslam;
  headers of compiled components include no other library either.
- A library is included only by a component that declares it.
- The umbrella header includes every header of the components that it stands for.

components.txt has lines `<component> <KEY> <value;value...>`, written by CMake.
"""

import pathlib
import re
import sys

# The flow of a frame; a component may build on those of a lower rank only.
RANKS = {
    "core": 0,
    "scene": 1,
    "culling": 2,
    "align": 3,
    "keyframe": 4,
    "weighting": 5,
    "evaluation": 6,
    "srslam": 7,
    "opencv": 7,
    "ceres": 7,
    "nanoflann": 7,
    "io": 8,
    "detection": 9,
    "synthetic": 9,
    "pipeline": 10,
    "cli": 11,
}
# Trajectories and their errors stand beside the flow: they know nothing of it.
EVALUATION_CLOSURE = {"core", "evaluation"}

STANDARD_HEADERS = set(
    """algorithm any array atomic bitset charconv chrono codecvt complex condition_variable deque
    exception execution filesystem forward_list fstream functional future initializer_list iomanip
    ios iosfwd iostream istream iterator limits list locale map memory memory_resource mutex new
    numeric optional ostream queue random ratio regex scoped_allocator set shared_mutex sstream
    stack stdexcept streambuf string string_view system_error thread tuple type_traits typeindex
    typeinfo unordered_map unordered_set utility valarray variant vector cassert cctype cerrno
    cfenv cfloat cinttypes climits clocale cmath csetjmp csignal cstdarg cstddef cstdint cstdio
    cstdlib cstring ctime cuchar cwchar cwctype""".split()
)
STANDARD_HEADERS.add("emmintrin.h")  # of every x86 compiler: SSE2
# Start of an include path -> library as components declare it.
LIBRARIES = {
    "Eigen/": "Eigen3",
    "unsupported/Eigen/": "Eigen3",
    "ceres/": "Ceres",
    "glog/": "Ceres",
    "nanoflann": "nanoflann",
    "CLI/": "CLI11",
    "nlohmann/": "nlohmann_json",
}

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
GENERATED = {"srslam/version.hpp": "core"}


def read_manifest(path):
    """{component: {key: [value, ...]}}"""
    components = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        name, key, value = (line.split(" ", 2) + [""])[:3]
        components.setdefault(name, {})[key] = [item for item in value.split(";") if item]
    return components


def library_of(include):
    """Library that an include path belongs to, or None; OpenCV with its module."""
    if include.startswith("opencv2/"):
        return "OpenCV:" + re.split(r"[/.]", include[len("opencv2/"):])[0]
    for start, library in LIBRARIES.items():
        if include.startswith(start):
            return library
    return None


def declared_libraries(specifications):
    """{"OpenCV:core,imgproc"} -> {"OpenCV:core", "OpenCV:imgproc"}"""
    libraries = set()
    for specification in specifications:
        name, _, modules = specification.partition(":")
        libraries.update(f"{name}:{module}" for module in modules.split(",") if module)
        if not modules:
            libraries.add(name)
    return libraries


class Checker:
    def __init__(self, root, components):
        self.root = root
        self.absent = set(components.pop("-", {}).get("ABSENT", []))
        self.components = components
        self.problems = []
        self.num_files = 0
        self.num_includes = 0
        self.owner = dict(GENERATED)  # public header -> component

    def problem(self, text):
        self.problems.append(text)

    def check_lists(self):
        for name, facts in self.components.items():
            for header in facts.get("HEADERS", []):
                if header in self.owner:
                    self.problem(f"include/{header} is listed by {self.owner[header]} and {name}")
                self.owner[header] = name
                if not (self.root / "include" / header).is_file():
                    self.problem(f"include/{header} is listed by component {name} but absent")
        include = self.root / "include"
        interop = {f"srslam/interop/{name}.hpp" for name in self.absent}
        for path in sorted(include.rglob("*")):
            if not path.is_file():
                continue
            header = path.relative_to(include).as_posix()
            parts = header.split("/")
            if header in self.owner or header in interop:
                continue
            if len(parts) > 2 and parts[1] in self.absent:
                continue
            self.problem(f"include/{header} belongs to no component (src/CMakeLists.txt or "
                         "src/<component>/CMakeLists.txt)")

        for folder in sorted(path for path in (self.root / "src").iterdir() if path.is_dir()):
            name = folder.name
            if name in self.absent or (name == "cli" and name not in self.components):
                continue
            listed = {folder / source
                      for source in self.components.get(name, {}).get("SOURCES", [])}
            for source in sorted(folder.rglob("*.cpp")):
                if source not in listed:
                    self.problem(f"src/{name}/{source.relative_to(folder).as_posix()} is not "
                                 f"listed in src/{name}/CMakeLists.txt")

    def check_flow(self):
        for name, facts in self.components.items():
            if name not in RANKS:
                self.problem(f"component {name} has no place in the flow; add it to RANKS in "
                             "check_structure.py")
                continue
            closure = set(facts.get("CLOSURE", []))
            for other in closure - {name}:
                if other in RANKS and RANKS[other] >= RANKS[name]:
                    self.problem(f"component {name} depends on {other}, which is not before it")
            if name == "evaluation" and closure - EVALUATION_CLOSURE:
                self.problem("component evaluation may depend on core only, not on "
                             + ", ".join(sorted(closure - EVALUATION_CLOSURE)))

    def allowed_libraries(self, name, with_private):
        libraries = set()
        for member in self.components[name].get("CLOSURE", [name]):
            if member == name and not with_private:
                continue
            if member == name or not self.components[member].get("SOURCES"):
                libraries |= declared_libraries(self.components[member].get("ALL_PACKAGES", []))
        return libraries

    def check_file(self, path, name, is_public):
        """Includes of one file of component `name`."""
        shown = path.relative_to(self.root).as_posix()
        closure = set(self.components[name].get("CLOSURE", []))
        compiled = bool(self.components[name].get("SOURCES"))
        libraries = self.allowed_libraries(name, with_private=not (is_public and compiled))
        self.num_files += 1
        for match in INCLUDE.finditer(path.read_text(encoding="utf-8")):
            self.num_includes += 1
            quote, include = match.groups()
            if include.startswith("srslam/"):
                owner = self.owner.get(include)
                if owner is None:
                    if include.split("/")[1] not in self.absent:
                        self.problem(f"{shown} includes {include}, which no component lists")
                elif owner != name and owner not in closure:
                    # The sources of a compiled component may use the glue header of a library
                    # that they link.
                    glue = include.startswith("srslam/interop/") and not is_public
                    glue_packages = declared_libraries(
                        self.components[owner].get("ALL_PACKAGES", []))
                    if not (glue and glue_packages <= libraries):
                        self.problem(f"{shown} ({name}) includes {include} ({owner}), which "
                                     f"{name} does not depend on")
                continue
            if quote == '"':
                if is_public:
                    self.problem(f'{shown} includes "{include}": public headers use the full path '
                                 "from include/")
                elif not ((path.parent / include).is_file()
                          or include.startswith(f"{name}/")
                          and (self.root / "src" / include).is_file()):
                    self.problem(f'{shown} includes "{include}", which is not a file of '
                                 f"component {name}")
                continue
            library = library_of(include)
            if library is not None:
                if library not in libraries:
                    self.problem(f"{shown} ({name}) includes <{include}>, but may not use "
                                 f"{library}")
            elif include not in STANDARD_HEADERS:
                # What remains are headers of the operating system: for sources only.
                if is_public or not compiled or not include.endswith(".h"):
                    self.problem(f"{shown} includes <{include}>, which is neither of the standard "
                                 "library nor of a declared library")

    def check_includes(self):
        for name, facts in self.components.items():
            for header in facts.get("HEADERS", []):
                path = self.root / "include" / header
                if path.is_file():
                    self.check_file(path, name, is_public=True)
            folder = self.root / "src" / name
            if folder.is_dir():
                for path in sorted(folder.rglob("*")):
                    if path.suffix in (".cpp", ".hpp"):
                        self.check_file(path, name, is_public=False)

    def check_umbrella(self):
        facts = self.components["srslam"]
        umbrella = self.root / "include" / "srslam" / "srslam.hpp"
        if not umbrella.is_file():
            return  # reported as an absent header
        included = {match.group(2) for match in INCLUDE.finditer(umbrella.read_text("utf-8"))}
        for header, name in sorted(self.owner.items()):
            if name != "srslam" and name in facts["CLOSURE"] and header not in included:
                self.problem(f"include/srslam/srslam.hpp does not include {header}")
        for name in facts["CLOSURE"]:
            libraries = declared_libraries(self.components[name].get("ALL_PACKAGES", []))
            if libraries - {"Eigen3", "Threads"}:  # threads belong to the standard library
                self.problem(f"srslam::srslam must need Eigen alone, but {name} needs "
                             + ", ".join(sorted(libraries)))

    def run(self):
        self.check_lists()
        self.check_flow()
        self.check_includes()
        self.check_umbrella()
        return self.problems


def main(arguments):
    if len(arguments) != 2:
        print(__doc__)
        return 2
    checker = Checker(pathlib.Path(arguments[0]), read_manifest(pathlib.Path(arguments[1])))
    for problem in checker.run():
        print(problem)
    print(f"{len(checker.components)} components, {checker.num_files} files, "
          f"{checker.num_includes} includes, {len(checker.problems)} problems")
    return 1 if checker.problems or checker.num_includes == 0 else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
