#!/usr/bin/env python3
"""Checks pages that must stand for themselves: check_page.py PAGE...

Every element that opens also closes, in order; nothing is fetched: no script, no address of another
host, no source but data that is part of the page; links lead to files below the page that exist.
"""

import html.parser
import pathlib
import sys

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


def main(paths):
    failed = False
    for path in map(pathlib.Path, paths):
        text = path.read_text(encoding="utf-8")
        checker = Checker(path.parent)
        checker.feed(text)
        checker.close()
        if checker.open:
            checker.problems.append(f"not closed: {checker.open}")
        if not text.startswith("<!DOCTYPE html>"):
            checker.problems.append("no document type")
        for problem in checker.problems:
            print(f"{path}: {problem}")
        print(f"{path}: {checker.num_tables} tables, {checker.num_pictures} pictures, "
              f"{len(checker.problems)} problems")
        failed |= bool(checker.problems)
    return 1 if failed or not paths else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
