#!/usr/bin/env python3
"""Share of frames that two runs of reliability_probe put in the same class.

    class_agreement.py [--threshold R] [--max-age FRAMES] FILE.csv OTHER.csv [FILE.csv OTHER.csv]...
"""

import argparse
import csv


def reliabilities(path, age):
    with open(path, encoding="utf-8") as file:
        return {int(row["frame"]): float(row[f"R_{age}"]) for row in csv.DictReader(file)}


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--threshold", type=float, default=0.20)
    parser.add_argument("--max-age", type=int, default=6)
    parser.add_argument("files", nargs="+")
    arguments = parser.parse_args()
    if len(arguments.files) % 2:
        parser.error("files come in pairs")
    same, total = 0, 0
    for path, other_path in zip(arguments.files[::2], arguments.files[1::2]):
        one = reliabilities(path, arguments.max_age)
        other = reliabilities(other_path, arguments.max_age)
        frames = sorted(one.keys() & other.keys())
        differing = [frame for frame in frames
                     if (one[frame] >= arguments.threshold) != (other[frame] >= arguments.threshold)]
        same += len(frames) - len(differing)
        total += len(frames)
        print(f"{path}: {len(frames) - len(differing)} of {len(frames)} frames in the same class"
              + (f"; not {differing}" if differing else ""))
    print(f"together: {same} of {total}, {100.0 * same / max(total, 1):.1f} %")


if __name__ == "__main__":
    main()
