#!/usr/bin/env python3
"""What readme_snippets.py makes of blocks, right and wrong."""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from readme_snippets import SnippetError, snippet_projects  # noqa: E402


def block(language, code, marker=None):
    return (f"<!-- {marker} -->\n" if marker else "") + f"```{language}\n{code}\n```\n\ntext\n\n"


class ReadmeSnippetsTest(unittest.TestCase):
    def test_statements_become_a_program(self):
        projects, _ = snippet_projects(
            block("cpp", '#include "a.hpp"\nf();', "compile: components=core,evaluation run"))
        name, cmake, code = projects[0]
        self.assertEqual(name, "line_2")
        self.assertIn("COMPONENTS core evaluation", cmake)
        self.assertIn("PRIVATE srslam::core srslam::evaluation", cmake)
        self.assertNotIn("RUNTIME_OUTPUT_DIRECTORY", cmake)
        self.assertEqual(code.splitlines(), ['#include "a.hpp"', "int main() {", "f();",
                                             "return 0;", "}"])

    def test_a_program_stays_as_it_is_and_runs_only_when_asked(self):
        projects, _ = snippet_projects(
            block("cpp", "int main() { return 1; }", "compile: components=core"))
        self.assertEqual(projects[0][2], "int main() { return 1; }\n")
        self.assertIn("RUNTIME_OUTPUT_DIRECTORY", projects[0][1])

    def test_cmake_block_builds_the_next_cpp_block(self):
        projects, _ = snippet_projects(
            block("cmake", "add_executable(x main.cpp)", "compile: project")
            + block("cpp", "int main() {}", "compile: main.cpp run"))
        self.assertEqual(projects[0][1], "add_executable(x main.cpp)\n")

    def test_left_out_with_a_reason(self):
        _, left_out = snippet_projects(
            block("cpp", "...", "not compiled: pseudo code")
            + block("cpp", "f();", "compile: components=core"))
        self.assertEqual(left_out, [(2, "pseudo code")])

    def test_other_languages_need_no_marker(self):
        projects, _ = snippet_projects(
            block("sh", "ls") + block("cpp", "f();", "compile: components=core"))
        self.assertEqual(len(projects), 1)

    def test_refused(self):
        good = block("cpp", "f();", "compile: components=core")
        for text, fragment in (
            ("no code at all\n", "no block to compile"),
            (block("sh", "ls"), "no block to compile"),
            (block("cpp", "f();", "not compiled: because"), "no block to compile"),
            (good + block("cpp", "g();"), "neither"),
            (good + block("cmake", "project(x)"), "neither"),
            (good + "<!-- compile: components=core -->\nbetween\n" + block("cpp", "g();"),
             "neither"),
            (good + block("cpp", "g();", "not compiled:"), "without a reason"),
            (good + block("cpp", "g();", "compile: component=core"), "cannot read"),
            (good + block("cpp", "g();", "compile: main.cpp"), "without a cmake block"),
            (good + block("cmake", "x", "compile: components=core"), "compile: project"),
            (good + block("cmake", "x", "compile: project"), "no cpp block"),
        ):
            with self.subTest(fragment=fragment, text=text):
                with self.assertRaisesRegex(SnippetError, fragment):
                    snippet_projects(text)


if __name__ == "__main__":
    unittest.main()
