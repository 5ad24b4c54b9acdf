#!/usr/bin/env python3
"""Table of files of culling_probe: how many features that move each way of removal finds.

    culling_scores.py [--by-file] FILE.csv...

Recall: features that move and are removed. Retention: features that do not move and are kept, on
the room and resting on movers alike; "room" is that of the room alone. F1 is that of removal:
precision (removed features that move) and recall. Sums over all frames of all files, so that a
frame counts by its features.
"""

import argparse
import csv

WAYS = ("geometry", "detection", "both", "proportion", "k_means", "convex_hull", "dbscan", "srslam")
KINDS = ("room", "resting", "moving")


def counts_of(path):
    """Features of each kind, and of those the removed ones by way."""
    totals = dict.fromkeys(KINDS, 0)
    removed = {way: dict.fromkeys(KINDS, 0) for way in WAYS}
    with open(path, encoding="utf-8") as file:
        for row in csv.DictReader(file):
            for kind in KINDS:
                totals[kind] += int(row[f"num_{kind}"])
                for way in WAYS:
                    removed[way][kind] += int(row[f"{kind}_{way}"])
    return totals, removed


def share(part, whole):
    return part / whole if whole else float("nan")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--by-file", action="store_true", help="a table for each file, too")
    parser.add_argument("files", nargs="+")
    arguments = parser.parse_args()
    all_totals = dict.fromkeys(KINDS, 0)
    all_removed = {way: dict.fromkeys(KINDS, 0) for way in WAYS}

    def show(title, totals, removed):
        print(f"{title}: {totals['moving']} features move, {totals['resting']} rest on movers, "
              f"{totals['room']} show the room")
        print(f"{'way':<14}{'recall':>8}{'retention':>11}{'room':>8}{'precision':>11}{'F1':>8}")
        still = totals["room"] + totals["resting"]
        for way in WAYS:
            gone = removed[way]
            gone_still = gone["room"] + gone["resting"]
            recall = share(gone["moving"], totals["moving"])
            precision = share(gone["moving"], gone["moving"] + gone_still)
            f1 = share(2 * precision * recall, precision + recall)
            print(f"{way:<14}{recall:>8.3f}{1 - share(gone_still, still):>11.3f}"
                  f"{1 - share(gone['room'], totals['room']):>8.3f}{precision:>11.3f}{f1:>8.3f}")

    for path in arguments.files:
        totals, removed = counts_of(path)
        if arguments.by_file:
            show(path, totals, removed)
        for kind in KINDS:
            all_totals[kind] += totals[kind]
            for way in WAYS:
                all_removed[way][kind] += removed[way][kind]
    show("together", all_totals, all_removed)


if __name__ == "__main__":
    main()
