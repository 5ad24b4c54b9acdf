#!/usr/bin/env python3
"""Table of files of culling_probe: how many features on movers each way of removal finds.

    culling_scores.py [--by-file] FILE.csv...

Recall: features on movers that are removed. Retention: features on what stands still that are kept.
F1 is that of removal: precision (removed features that are on movers) and recall. Sums over all
frames of all files, so that a frame counts by its features.
"""

import argparse
import csv

WAYS = ("geometry", "detection", "both", "proportion", "k_means", "convex_hull", "dbscan", "srslam")


def counts_of(path):
    totals = dict.fromkeys(("static", "dynamic"), 0)
    removed = {way: [0, 0] for way in WAYS}
    with open(path, encoding="utf-8") as file:
        for row in csv.DictReader(file):
            totals["static"] += int(row["num_static"])
            totals["dynamic"] += int(row["num_dynamic"])
            for way in WAYS:
                removed[way][0] += int(row[f"static_{way}"])
                removed[way][1] += int(row[f"dynamic_{way}"])
    return totals, removed


def share(part, whole):
    return part / whole if whole else float("nan")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--by-file", action="store_true", help="a table for each file, too")
    parser.add_argument("files", nargs="+")
    arguments = parser.parse_args()
    all_totals = {"static": 0, "dynamic": 0}
    all_removed = {way: [0, 0] for way in WAYS}

    def show(title, totals, removed):
        print(f"{title}: {totals['dynamic']} features on movers, {totals['static']} on the rest")
        print(f"{'way':<14}{'recall':>8}{'retention':>11}{'precision':>11}{'F1':>8}")
        for way in WAYS:
            still, moving = removed[way]
            recall = share(moving, totals["dynamic"])
            precision = share(moving, moving + still)
            f1 = share(2 * precision * recall, precision + recall)
            print(f"{way:<14}{recall:>8.3f}{1 - share(still, totals['static']):>11.3f}"
                  f"{precision:>11.3f}{f1:>8.3f}")

    for path in arguments.files:
        totals, removed = counts_of(path)
        if arguments.by_file:
            show(path, totals, removed)
        for kind in all_totals:
            all_totals[kind] += totals[kind]
        for way in WAYS:
            for k in range(2):
                all_removed[way][k] += removed[way][k]
    show("together", all_totals, all_removed)


if __name__ == "__main__":
    main()
