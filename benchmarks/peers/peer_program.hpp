#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace srslam::peers {

/// A clustering input: int32 number of points, int32 dimension, float64 eps, int32 min_points (the
/// point itself included), then the coordinates as float64, point by point; little endian.
struct Input {
  std::int32_t num_points = 0;
  std::int32_t dimension = 0;
  double eps = 0.0;
  std::int32_t min_points = 0;
  std::vector<double> coordinates;
};

inline bool read_input(const std::filesystem::path& file, Input* input) {
  std::ifstream stream(file, std::ios::binary);
  const auto read = [&](void* data, std::size_t size) {
    return bool(stream.read(static_cast<char*>(data), std::streamsize(size)));
  };
  if (!read(&input->num_points, 4) || !read(&input->dimension, 4) || !read(&input->eps, 8) ||
      !read(&input->min_points, 4) || input->num_points < 0 || input->dimension < 1 ||
      input->dimension > 6) {
    return false;
  }
  input->coordinates.resize(std::size_t(input->num_points) * std::size_t(input->dimension));
  return read(input->coordinates.data(), input->coordinates.size() * sizeof(double));
}

inline double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * double(now.tv_sec) + 1e-6 * double(now.tv_nsec);
}

/// Runs a library over the files of the command line and prints, a line each, file, median CPU time
/// of a call [ms], clusters and noise points. `prepare(input)` returns a callable that clusters and
/// returns labels (negative: noise), or an empty one for inputs that the library cannot take; what
/// it prepares is not timed.
template <typename Prepare>
int run_peer(int argc, char** argv, const Prepare& prepare) {
  for (int i = 1; i < argc; ++i) {
    Input input;
    if (!read_input(argv[i], &input)) {
      std::fprintf(stderr, "%s: not a clustering input\n", argv[i]);
      return 1;
    }
    const auto cluster = prepare(input);
    if (!cluster) continue;
    std::vector<std::int32_t> labels;
    // The clock is a system call of some tenths of a microsecond, as long as the clustering of a
    // few points: a sample is as many calls as take milliseconds. Finding out how many warms up.
    std::size_t num_calls = 1;
    const auto time_calls = [&] {
      const double start_ms = cpu_ms();
      for (std::size_t call = 1; call < num_calls; ++call) cluster();
      labels = cluster();
      return cpu_ms() - start_ms;
    };
    while (time_calls() < 5.0) num_calls *= 2;
    std::vector<double> times_ms;
    double total_ms = 0.0;
    while (times_ms.size() < 5 || total_ms < 500.0) {
      const double sample_ms = time_calls();
      times_ms.push_back(sample_ms / double(num_calls));
      total_ms += sample_ms;
      if (total_ms > 20e3) break;
    }
    std::nth_element(times_ms.begin(), times_ms.begin() + std::ptrdiff_t(times_ms.size() / 2),
                     times_ms.end());
    const auto num_noise =
        std::count_if(labels.begin(), labels.end(), [](std::int32_t label) { return label < 0; });
    const std::int32_t num_clusters =
        labels.empty() ? 0 : std::max(*std::max_element(labels.begin(), labels.end()) + 1, 0);
    std::printf("%s,%.6f,%d,%td\n", std::filesystem::path(argv[i]).stem().c_str(),
                times_ms[times_ms.size() / 2], num_clusters, num_noise);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace srslam::peers
