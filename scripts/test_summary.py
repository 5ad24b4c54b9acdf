#!/usr/bin/env python3
"""Sums up a run of ctest: which tests failed, which were skipped and why, and how many.

    test_summary.py <JUnit report of ctest> <exit status of ctest>

The last line is `N passed, N failed, N skipped`. Fails when a test failed, when ctest did, or when
no test passed.
"""

import pathlib
import re
import sys
import xml.etree.ElementTree

MAX_REASON_LINES = 3


def skip_reason(case):
    """Why a test was skipped, in its own words."""
    if case.get("status") == "disabled":
        return "disabled in the source"
    output = case.findtext("system-out") or ""
    # GoogleTest prints `file:line: Skipped` and then the message of GTEST_SKIP().
    match = re.search(r": Skipped\n(.*?)(?:\n\s*\n|\n\[|\Z)", output, re.DOTALL)
    if match:
        return " ".join(match.group(1).split())
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    return " / ".join(lines[-MAX_REASON_LINES:]) or "no reason given"


def main(arguments):
    if len(arguments) != 2:
        print(__doc__)
        return 2
    report, ctest_status = pathlib.Path(arguments[0]), int(arguments[1])
    cases = []
    if report.is_file():
        cases = list(xml.etree.ElementTree.parse(report).iter("testcase"))
    passed = [case for case in cases if case.get("status") == "run"]
    skipped = [case for case in cases
               if case.get("status") == "disabled"
               or case.get("status") == "notrun" and case.find("skipped") is not None]
    failed = [case for case in cases if case not in passed and case not in skipped]

    print()
    if skipped:
        reasons = {}
        for case in skipped:
            reasons.setdefault(skip_reason(case), []).append(case.get("name"))
        print("SKIPPED:")
        for reason, names in reasons.items():
            print(f"  {reason}")
            for name in names:
                print(f"    {name}")
    if failed:
        print("FAILED:")
        for case in failed:
            print(f"  {case.get('name')}")
    if not passed:
        print("FAILED: no test ran")
    elif ctest_status != 0 and not failed:
        print(f"FAILED: ctest ended with status {ctest_status}")
    print(f"{len(passed)} passed, {len(failed)} failed, {len(skipped)} skipped")
    return 1 if failed or not passed or ctest_status != 0 else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
