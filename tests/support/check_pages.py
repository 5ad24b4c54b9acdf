#!/usr/bin/env python3
"""Checks that pages of runs and campaigns stand for themselves.

    check_pages.py PAGE...                      checks these
    check_pages.py --program SRSLAM DATASET     makes pages of whole and damaged copies of a dataset

Every element that opens also closes, in order; nothing is fetched: no script, no address of another
host, no source but data that is part of the page; links lead to files below the page that exist.
"""

import html.parser
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

VOID = {"meta", "img", "br", "hr", "link", "input"}


class Checker(html.parser.HTMLParser):
    def __init__(self, folder):
        super().__init__(convert_charrefs=True)
        self.folder = folder
        self.open = []
        self.problems = []
        self.num_tables = 0
        self.num_pictures = 0

    def handle_starttag(self, tag, attributes):
        if tag not in VOID:
            self.open.append(tag)
        self.num_tables += tag == "table"
        self.num_pictures += tag == "img"
        if tag in ("script", "link", "iframe", "object", "embed"):
            self.problems.append(f"element <{tag}>")
        for name, value in attributes:
            value = value or ""
            if name == "src" and not value.startswith("data:"):
                self.problems.append(f"src={value[:60]}")
            if name.startswith("on"):
                self.problems.append(f"{name}= on <{tag}>")
            if name == "href":
                if ":" in value or value.startswith("/") or not (self.folder / value).is_file():
                    self.problems.append(f"href={value[:60]}")
            if "http" in value[:60] or "url(" in value[:200]:
                self.problems.append(f"{name}={value[:60]}")

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.problems.append(f"</{tag}> at {self.getpos()} closes nothing")


def problems_of(path, min_tables=0, parts=()):
    """What is wrong with a page, printed too."""
    if not path.is_file():
        print(f"{path}: is not there")
        return 1
    text = path.read_text(encoding="utf-8")
    checker = Checker(path.parent)
    checker.feed(text)
    checker.close()
    if checker.open:
        checker.problems.append(f"not closed: {checker.open}")
    if not text.startswith("<!DOCTYPE html>"):
        checker.problems.append("no document type")
    if checker.num_tables < min_tables:
        checker.problems.append(f"{min_tables} tables expected")
    checker.problems += [f"does not say '{part}'" for part in parts if part not in text]
    for problem in checker.problems:
        print(f"{path}: {problem}")
    print(f"{path.name} of {path.parent.name}: {checker.num_tables} tables, "
          f"{checker.num_pictures} pictures, {len(checker.problems)} problems")
    return len(checker.problems)


def damaged_copy(dataset, folder, damage):
    shutil.copytree(dataset, folder)
    damage(folder)
    return folder


def truncate_images(folder, kind, every):
    for image in sorted((folder / kind).iterdir())[::every]:
        image.write_bytes(image.read_bytes()[:200])


def check_program(program, dataset):
    num_problems = 0
    with tempfile.TemporaryDirectory() as name:
        work = pathlib.Path(name)
        suite = work / "suite"
        suite.mkdir()
        some = damaged_copy(dataset, suite / "<some> & 'lost'", lambda f: truncate_images(f, "rgb", 5))
        every = damaged_copy(dataset, suite / "all", lambda f: truncate_images(f, "depth", 1))
        no_truth = damaged_copy(dataset, suite / "truth", lambda f: (f / "groundtruth.txt").unlink())
        no_path = {**os.environ, "PATH": str(work / "nowhere")}
        for label, folder, environment, parts in (
                ("whole", dataset, None, ["image/svg+xml", "image/jpeg", "largest error"]),
                ("bare", dataset, no_path, ["There are no plots: gnuplot cannot be started"]),
                ("some", some, None, ["&lt;some&gt; &amp; &#39;lost&#39;", "DAMAGED"]),
                ("every", every, None, ["nothing was tracked: every frame is damaged"]),
                ("truth", no_truth, None, ["There is no ground truth"])):
            subprocess.run([program, "run", "--dataset", folder, "--output", work / label, "--quiet"],
                           env=environment, capture_output=True, check=False)
            num_problems += problems_of(work / label / "report.html", 3, parts)
        for label, environment, part in (("campaign", None, "image/svg+xml"),
                                         ("bare_campaign", no_path, "There is no chart")):
            subprocess.run([program, "campaign", "--suite", suite, "--output", work / label,
                            "--quiet"], env=environment, capture_output=True, check=False)
            num_problems += problems_of(work / label / "report.html", 8, [part, "Failed jobs"])
    return num_problems


def main(arguments):
    if len(arguments) == 3 and arguments[0] == "--program":
        return 1 if check_program(arguments[1], pathlib.Path(arguments[2])) else 0
    if not arguments:
        print(__doc__)
        return 2
    return 1 if sum(problems_of(pathlib.Path(path)) for path in arguments) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
