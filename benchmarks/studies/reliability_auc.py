#!/usr/bin/env python3
"""How well each term of the reliability predicts a large frame error, as a table in Markdown.

    reliability_auc.py --limit METRES FILE.csv[:FIRST-LAST]...

The files are those of reliability_probe, frames FIRST to LAST of each. A frame's error is large
above the limit. Each figure is the area under the ROC curve (0.5: chance) with the interval that
holds 95 % of 400 resamples of the frames in blocks of 15, neighbours being alike.
"""

import argparse
import csv
import math
import random

BLOCK = 15
RESAMPLES = 400
INITIAL_FRAMES = 5


def read_rows(argument):
    path, _, span = argument.rpartition(":")
    if not path:
        path, span = argument, ""
    first, last = (int(part) for part in span.split("-")) if span else (0, 10**9)
    with open(path, encoding="utf-8") as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    return [row for row in rows
            if max(first, INITIAL_FRAMES) <= row["frame"] <= last and not math.isnan(row["error_m"])]


def area(scored):
    """Of (score, is_large) pairs, a high score standing for a small error; NaN without both."""
    scored = sorted(scored)
    num_large = sum(1 for _, large in scored if large)
    num_small = len(scored) - num_large
    if num_large == 0 or num_small == 0:
        return math.nan
    rank_sum, begin = 0.0, 0
    while begin < len(scored):
        end = begin
        while end < len(scored) and scored[end][0] == scored[begin][0]:
            end += 1
        rank = 0.5 * (begin + end + 1)
        rank_sum += rank * sum(1 for _, large in scored[begin:end] if not large)
        begin = end
    return (rank_sum - num_small * (num_small + 1) / 2) / (num_large * num_small)


def interval(blocks, stream):
    areas = []
    for _ in range(RESAMPLES):
        sample = [pair for _ in blocks for pair in stream.choice(blocks)]
        value = area(sample)
        if not math.isnan(value):
            areas.append(value)
    areas.sort()
    if not areas:
        return math.nan, math.nan
    return areas[int(0.025 * len(areas))], areas[int(0.975 * len(areas)) - 1]


FACTORS = {
    "exponential": lambda x: math.exp(-x),
    "rational": lambda x: 1.0 / (1.0 + x),
    "clip": lambda x: min(1.0, 1.0 / x) if x > 0.0 else 1.0,
    "linear": lambda x: max(0.0, 1.0 - x),
    "literal": lambda x: x,
}
SCALES = {"none": 60.0, "affine": 5.0, "rigid": 5.0}


def scores(age):
    """Name and function of a row for everything that is compared."""
    def column(name, missing=0.0):
        def value(row):
            return missing if math.isnan(row[name]) else row[name]
        return value

    def negative(name):
        return lambda row: -1e9 if math.isnan(row[name]) else -row[name]

    def eq7(variant, factor):
        def value(row):
            residual = row[f"residual_{variant}_{age}"]
            x = 1.0 if math.isnan(residual) else residual / SCALES[variant]
            return row["current"] * FACTORS[factor](x)
        return value

    # A frame without detections has neither of their metrics and counts like an average one.
    yield "confidence (Eq. 2)", column("confidence", 0.75)
    yield "spatial (Eq. 3)", column("spatial", 0.85)
    yield "feature (Eq. 4)", column("feature")
    yield "depth (Eq. 5)", column("depth")
    yield "R_c (Eq. 1)", column("current")
    for variant in SCALES:
        yield f"residual, {variant} (Eq. 6)", negative(f"residual_{variant}_{age}")
        if variant != "none":
            yield f"share of inliers, {variant}", column(f"inliers_{variant}_{age}")
    yield "share of tracks alive", column(f"alive_{age}")
    yield "certainty of the motion", column(f"certainty_rigid_{age}")
    for variant in SCALES:
        for factor in FACTORS:
            yield f"R_c times factor {factor}, {variant} (Eq. 7)", eq7(variant, factor)
    yield "**R as shipped**", column(f"R_{age}")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--limit", type=float, required=True)
    parser.add_argument("--max-age", type=int, default=6)
    parser.add_argument("files", nargs="+")
    arguments = parser.parse_args()
    sequences = [read_rows(argument) for argument in arguments.files]
    rows = [row for sequence in sequences for row in sequence]
    num_large = sum(1 for row in rows if row["error_m"] > arguments.limit)
    print(f"{len(rows)} frames, {num_large} with an error above {arguments.limit:g} m\n")
    print("| Score | AUC | 95 % |\n|---|---|---|")
    for name, score in scores(arguments.max_age):
        blocks = []
        for sequence in sequences:
            pairs = [(score(row), row["error_m"] > arguments.limit) for row in sequence]
            blocks += [pairs[i:i + BLOCK] for i in range(0, len(pairs), BLOCK)]
        low, high = interval(blocks, random.Random(1))
        whole = area([pair for block in blocks for pair in block])
        print(f"| {name} | {whole:.3f} | {low:.3f}–{high:.3f} |")


if __name__ == "__main__":
    main()
