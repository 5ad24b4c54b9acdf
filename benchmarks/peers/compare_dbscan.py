"""srslam's clustering against other libraries on the same files in the same run.

usage: compare_dbscan.py --programs build/release/bin [--inputs FOLDER] [--max-points N] [FILTER...]

Runs, on every input whose name holds one of the FILTERs, what there is of: peer_srslam, peer_open3d
and peer_header (built with -DSRSLAM_BENCH_PEERS=ON), scikit-learn (python3-sklearn) and R's dbscan
(r-cran-dbscan). Without --inputs the inputs are written by write_inputs. Prints a table of median
CPU times in milliseconds, one thread each, and how often faster srslam is; a row whose clusters or
noise differ says so. Every library runs on an input before the next input comes.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent


def natural(name):
    kind, dimension, size = name.split("_")
    return (kind, int(dimension[1:]), int(size[1:]))


def peers(programs):
    found = {"srslam": [str(programs / "peer_srslam")]}
    for name in ("open3d", "header"):
        if (programs / f"peer_{name}").is_file():
            found[name] = [str(programs / f"peer_{name}")]
    python = shutil.which("python3") or sys.executable
    for interpreter in ("/usr/bin/python3", python):
        known = subprocess.run([interpreter, "-c", "import sklearn"], capture_output=True, check=False)
        if known.returncode == 0:
            script = str(HERE / "peer_sklearn.py")
            found["sklearn_kd_tree"] = [interpreter, script, "kd_tree"]
            found["sklearn_brute"] = [interpreter, script, "brute"]
            break
    if shutil.which("Rscript"):
        known = subprocess.run(["Rscript", "-e", "library(dbscan)"], capture_output=True, check=False)
        if known.returncode == 0:
            found["r_dbscan"] = ["Rscript", str(HERE / "peer_dbscan.R")]
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=Path, required=True)
    parser.add_argument("--inputs", type=Path)
    parser.add_argument("--max-points", type=int, default=10000)
    parser.add_argument("filters", nargs="*")
    arguments = parser.parse_args()
    if not (arguments.programs / "peer_srslam").is_file():
        sys.exit(f"{arguments.programs}/peer_srslam is not there: configure with "
                 "-DSRSLAM_BENCH_PEERS=ON and build")
    with tempfile.TemporaryDirectory() as scratch:
        inputs = arguments.inputs
        if inputs is None:
            inputs = Path(scratch)
            subprocess.run([str(arguments.programs / "write_inputs"), scratch], check=True)
        found = peers(arguments.programs)
        environment = dict(os.environ, OMP_NUM_THREADS="1")
        print("| input | " + " | ".join(found) + " | srslam is faster than the best other by |")
        print("|---|" + "---|" * (len(found) + 1), flush=True)
        names = sorted((path.stem for path in inputs.glob("*_d*_n*.bin")), key=natural)
        for name in names:
            if natural(name)[2] > arguments.max_points:
                continue
            if arguments.filters and not any(part in name for part in arguments.filters):
                continue
            rows = {}
            for peer, command in found.items():
                if peer.startswith("sklearn_brute") and natural(name)[2] > 10000:
                    continue  # memory
                run = subprocess.run(command + [str(inputs / f"{name}.bin")], capture_output=True,
                                     text=True, env=environment, check=False)
                if run.returncode != 0:
                    sys.exit(f"{peer} failed on {name}: {run.stderr}")
                for line in run.stdout.splitlines():
                    _, ms, clusters, noise = line.split(",")
                    rows[peer] = (float(ms), int(clusters), int(noise))
            cells = []
            for peer in found:
                if peer not in rows:
                    cells.append("-")
                    continue
                ms, clusters, noise = rows[peer]
                differs = (clusters, noise) != rows["srslam"][1:]
                cells.append(f"{ms:.4g}" + (f" ({clusters} clusters, {noise} noise)" if differs else ""))
            others = [row[0] for peer, row in rows.items() if peer != "srslam"]
            ratio = f"{min(others) / rows['srslam'][0]:.1f}" if others else "-"
            print(f"| {name} | " + " | ".join(cells) + f" | {ratio} |", flush=True)


if __name__ == "__main__":
    main()
