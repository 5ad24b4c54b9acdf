# R's package dbscan (ANN kd-tree): Rscript peer_dbscan.R FILE...
suppressPackageStartupMessages(library(dbscan))
for (name in commandArgs(trailingOnly = TRUE)) {
  stream <- file(name, "rb")
  shape <- readBin(stream, "integer", 2, size = 4, endian = "little")
  eps <- readBin(stream, "double", 1, size = 8, endian = "little")
  min_points <- readBin(stream, "integer", 1, size = 4, endian = "little")
  points <- matrix(readBin(stream, "double", shape[1] * shape[2], size = 8, endian = "little"),
                   ncol = shape[2], byrow = TRUE)
  close(stream)
  times <- c()
  # The clock has a resolution of a millisecond: small inputs are timed many at once.
  repeats <- max(1, 20000 %/% shape[1])
  while (length(times) < 5 || (sum(times) * repeats < 200 && length(times) < 200)) {
    spent <- system.time(for (i in seq_len(repeats)) found <- dbscan(points, eps, min_points))
    times <- c(times, 1e3 * (spent[["user.self"]] + spent[["sys.self"]]) / repeats)
    if (sum(times) * repeats > 20e3) break
  }
  cat(sprintf("%s,%.6f,%d,%d\n", sub("[.]bin$", "", basename(name)), median(times),
              max(found$cluster), sum(found$cluster == 0)))
}
