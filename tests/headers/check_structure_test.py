#!/usr/bin/env python3
"""The structure check finds what it is there to find: one small tree a violation."""

import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from check_structure import Checker  # noqa: E402

SOUND_FILES = {
    "include/srslam/core/a.hpp": "#include <Eigen/Core>\n#include <vector>\n",
    "include/srslam/evaluation/b.hpp": '#include "srslam/core/a.hpp"\n',
    "include/srslam/interop/opencv.hpp":
        '#include <opencv2/core.hpp>\n#include "srslam/core/a.hpp"\n',
    "include/srslam/io/c.hpp": '#include "srslam/evaluation/b.hpp"\n',
    "include/srslam/srslam.hpp":
        '#include "srslam/core/a.hpp"\n#include "srslam/evaluation/b.hpp"\n'
        '#include "srslam/version.hpp"\n',
    "src/io/c.cpp":
        '#include "srslam/io/c.hpp"\n#include <opencv2/core.hpp>\n#include <fcntl.h>\n'
        '#include "io/private.hpp"\n#include "srslam/interop/opencv.hpp"\n',
    "src/io/private.hpp": "#include <string>\n",
}


def sound_components():
    return {
        "core": {"HEADERS": ["srslam/core/a.hpp"], "CLOSURE": ["core"],
                 "ALL_PACKAGES": ["Eigen3"]},
        "evaluation": {"HEADERS": ["srslam/evaluation/b.hpp"],
                       "CLOSURE": ["core", "evaluation"]},
        "srslam": {"HEADERS": ["srslam/srslam.hpp"],
                   "CLOSURE": ["core", "evaluation", "srslam"]},
        "opencv": {"HEADERS": ["srslam/interop/opencv.hpp"], "CLOSURE": ["core", "opencv"],
                   "ALL_PACKAGES": ["OpenCV:core"]},
        "io": {"HEADERS": ["srslam/io/c.hpp"], "SOURCES": ["c.cpp"],
               "CLOSURE": ["core", "evaluation", "io"],
               "ALL_PACKAGES": ["OpenCV:core,imgproc", "Threads"]},
        "-": {"ABSENT": ["pipeline"]},
    }


class CheckStructureTest(unittest.TestCase):
    def problems(self, changed_files=None, components=None):
        files = dict(SOUND_FILES)
        files.update(changed_files or {})
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name, text in files.items():
                if text is None:
                    continue
                path = root / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text, encoding="utf-8")
            return Checker(root, components or sound_components()).run()

    def assert_one_problem(self, fragment, changed_files=None, components=None):
        problems = self.problems(changed_files, components)
        self.assertEqual(len(problems), 1, problems)
        self.assertIn(fragment, problems[0])

    def test_sound_tree(self):
        self.assertEqual(self.problems(), [])

    def test_header_that_no_component_lists(self):
        self.assert_one_problem("belongs to no component",
                                {"include/srslam/core/new.hpp": "\n"})

    def test_listed_header_that_is_absent(self):
        components = sound_components()
        components["io"]["HEADERS"].append("srslam/io/gone.hpp")
        self.assert_one_problem("but absent", components=components)

    def test_header_of_an_absent_component_is_no_problem(self):
        self.assertEqual(self.problems({"include/srslam/pipeline/p.hpp": "\n"}), [])

    def test_source_that_is_not_listed(self):
        self.assert_one_problem("src/io/new.cpp is not listed", {"src/io/new.cpp": "\n"})

    def test_lower_stage_includes_later_one(self):
        self.assert_one_problem(
            "(core) includes srslam/io/c.hpp",
            {"include/srslam/core/a.hpp": '#include "srslam/io/c.hpp"\n'})

    def test_dependency_against_the_flow(self):
        components = sound_components()
        components["core"]["CLOSURE"] = ["evaluation", "core"]
        self.assert_one_problem("component core depends on evaluation", components=components)

    def test_evaluation_depends_on_more_than_core(self):
        components = sound_components()
        components["scene"] = {"HEADERS": ["srslam/scene/s.hpp"], "CLOSURE": ["core", "scene"]}
        components["evaluation"]["CLOSURE"] = ["core", "scene", "evaluation"]
        self.assert_one_problem("may depend on core only",
                                {"include/srslam/scene/s.hpp": "\n"}, components)

    def test_component_without_a_rank(self):
        components = sound_components()
        components["novel"] = {"CLOSURE": ["novel"]}
        self.assert_one_problem("no place in the flow", components=components)

    def test_foreign_library_in_an_eigen_only_header(self):
        self.assert_one_problem(
            "may not use OpenCV:core",
            {"include/srslam/evaluation/b.hpp": "#include <opencv2/core.hpp>\n"})

    def test_operating_system_header_in_a_public_header(self):
        self.assert_one_problem("neither of the standard library",
                                {"include/srslam/io/c.hpp": "#include <unistd.h>\n"})

    def test_foreign_library_in_a_compiled_components_header(self):
        self.assert_one_problem("may not use OpenCV:core",
                                {"include/srslam/io/c.hpp": "#include <opencv2/core.hpp>\n"})

    def test_undeclared_module_in_a_source(self):
        self.assert_one_problem("may not use OpenCV:calib3d",
                                {"src/io/c.cpp": "#include <opencv2/calib3d.hpp>\n"})

    def test_private_header_of_another_component(self):
        self.assert_one_problem("not a file of component io",
                                {"src/io/c.cpp": '#include "pipeline/map.hpp"\n',
                                 "src/pipeline/map.hpp": "\n"})

    def test_umbrella_without_a_header(self):
        self.assert_one_problem(
            "does not include srslam/evaluation/b.hpp",
            {"include/srslam/srslam.hpp":
             '#include "srslam/core/a.hpp"\n#include "srslam/version.hpp"\n'})

    def test_umbrella_that_needs_more_than_eigen(self):
        components = sound_components()
        components["evaluation"]["ALL_PACKAGES"] = ["Ceres"]
        self.assert_one_problem("must need Eigen alone", components=components)


if __name__ == "__main__":
    unittest.main()
