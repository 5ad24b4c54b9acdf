"""scikit-learn's DBSCAN: peer_sklearn.py kd_tree|brute FILE..."""

import struct
import sys
import time
from pathlib import Path

import numpy as np
from sklearn.cluster import DBSCAN


def main():
    for name in sys.argv[2:]:
        data = Path(name).read_bytes()
        n, d, eps, min_points = struct.unpack_from("<iidi", data)
        points = np.frombuffer(data, "<f8", offset=20).reshape(n, d)
        model = DBSCAN(eps=eps, min_samples=min_points, algorithm=sys.argv[1], n_jobs=1)
        times = []
        while len(times) < 5 or (sum(times) < 0.2 and len(times) < 5000):
            start = time.process_time()
            model.fit(points)
            times.append(time.process_time() - start)
            if sum(times) > 20.0:
                break
        labels = model.labels_
        median = sorted(times)[len(times) // 2]
        print(f"{Path(name).stem},{1e3 * median:.6f},{labels.max() + 1},{(labels < 0).sum()}",
              flush=True)


if __name__ == "__main__":
    main()
