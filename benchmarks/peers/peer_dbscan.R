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
  # The clock has a resolution of a millisecond: a sample is as many calls as take half a second, so
  # that three digits mean something.
  repeats <- 1
  sample_ms <- function() {
    spent <- system.time(for (i in seq_len(repeats)) found <<- dbscan(points, eps, min_points))
    1e3 * (spent[["user.self"]] + spent[["sys.self"]])
  }
  repeat {
    spent_ms <- sample_ms()  # warms up, too
    if (spent_ms >= 500) break
    repeats <- if (spent_ms < 20) repeats * 10 else ceiling(repeats * 550 / spent_ms)
  }
  times <- c()
  while (length(times) < 5 && sum(times) * repeats < 20e3) times <- c(times, sample_ms() / repeats)
  cat(sprintf("%s,%.6f,%d,%d\n", sub("[.]bin$", "", basename(name)), median(times),
              max(found$cluster), sum(found$cluster == 0)))
}
