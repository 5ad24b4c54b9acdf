"""dbscan() against scikit-learn on random cases: check_against_sklearn.py CLUSTER_CASES

The same core points, the same clusters of them with the same numbers, the same noise; a border point
is in the cluster of its nearest core point. Returns 77 (skipped) without scikit-learn, which Debian
has as python3-sklearn.
"""

import struct
import subprocess
import sys

NUM_CASES = 300

try:
    import numpy as np
    from sklearn.cluster import DBSCAN
except ImportError as error:
    print(f"SKIPPED: {error}; install python3-sklearn to compare with scikit-learn")
    sys.exit(77)


def make_case(rng):
    d = int(rng.integers(1, 7))
    n = int(rng.integers(1, 700))
    kind = rng.integers(0, 4)
    if kind == 0:
        points = rng.random((n, d))
        eps = (rng.uniform(2, 12) / n) ** (1 / d) * 0.6
    elif kind == 1:
        centers = rng.random((max(1, n // 50), d))
        points = centers[rng.integers(0, len(centers), n)] + 0.03 * rng.normal(size=(n, d))
        eps = rng.uniform(0.01, 0.08)
    elif kind == 2:  # numbers without rounding, many of them equal, many exactly eps apart
        points = rng.integers(0, 1 + int(n ** (1 / d)), (n, d)) * 0.25
        eps = 0.25 * rng.integers(1, 3)
    else:
        points = rng.random((n, 1)) @ rng.normal(size=(1, d)) + 1000.0
        eps = rng.uniform(0.001, 0.02)
    return points, float(eps), int(rng.integers(1, 9))


def check(points, eps, min_points, labels, kinds, num_clusters, what):
    model = DBSCAN(eps=eps, min_samples=min_points, algorithm="brute").fit(points)
    core = np.zeros(len(points), bool)
    core[model.core_sample_indices_] = True
    assert (core == (kinds == 2)).all(), f"{what}: core points differ"
    assert ((model.labels_ < 0) == (labels < 0)).all(), f"{what}: noise differs"
    assert (model.labels_[core] == labels[core]).all(), f"{what}: clusters differ"
    assert num_clusters == model.labels_.max() + 1, f"{what}: number of clusters differs"
    for i in np.flatnonzero(kinds == 1):
        distance = ((points[core] - points[i]) ** 2).sum(axis=1)
        nearest = labels[core][distance <= distance.min() * (1 + 1e-12)]
        assert labels[i] in nearest, f"{what}: border point {i} is not with its nearest core point"


def main():
    rng = np.random.default_rng(20)
    cases = [make_case(rng) for _ in range(NUM_CASES)]
    stream = b"".join(
        struct.pack("<iidi", points.shape[1], len(points), eps, min_points)
        + np.ascontiguousarray(points, "<f8").tobytes() for points, eps, min_points in cases)
    run = subprocess.run([sys.argv[1]], input=stream, capture_output=True, check=True)
    numbers = np.frombuffer(run.stdout, "<i4")
    at = 0
    sizes = []
    for number, (points, eps, min_points) in enumerate(cases):
        for search in ("brute force", "sweep", "grid"):
            n = len(points)
            pairs = numbers[at + 1:at + 1 + 2 * n].reshape(n, 2)
            check(points, eps, min_points, pairs[:, 0], pairs[:, 1], numbers[at],
                  f"case {number} ({n} points, {points.shape[1]} dimensions, {search})")
            sizes.append(numbers[at])
            at += 1 + 2 * n
    assert at == len(numbers), "more answers than cases"
    assert max(sizes) > 5 and min(sizes) == 0, "the cases are all alike"
    print(f"{NUM_CASES} cases, {at} numbers agree with scikit-learn")


if __name__ == "__main__":
    main()
