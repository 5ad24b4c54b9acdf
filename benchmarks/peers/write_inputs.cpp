// Writes the inputs that peers are compared on: write_inputs FOLDER

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "support/cluster_inputs.hpp"

namespace {

template <std::size_t D>
bool write_inputs(const std::filesystem::path& folder) {
  using srslam::test::ClusterInput;
  for (const ClusterInput kind :
       {ClusterInput::kSlam, ClusterInput::kUniform, ClusterInput::kBlob}) {
    for (const std::size_t n : {100U, 300U, 1000U, 3000U, 10000U, 100000U}) {
      srslam::DbscanOptions options;
      const auto points = srslam::test::cluster_input<double, D>(kind, n, &options);
      std::ofstream stream(folder / (srslam::test::to_string(kind) + "_d" + std::to_string(D) +
                                     "_n" + std::to_string(n) + ".bin"),
                           std::ios::binary);
      const auto write = [&](const auto& value) {
        stream.write(reinterpret_cast<const char*>(&value), sizeof(value));
      };
      write(std::int32_t(n));
      write(std::int32_t(D));
      write(options.eps);
      write(std::int32_t(options.min_points));
      for (const auto& point : points) write(point);
      if (!stream.flush()) return false;
    }
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 || !std::filesystem::is_directory(argv[1])) {
    std::fprintf(stderr, "usage: write_inputs FOLDER   (the folder exists)\n");
    return 2;
  }
  if (write_inputs<2>(argv[1]) && write_inputs<3>(argv[1]) && write_inputs<4>(argv[1]) &&
      write_inputs<5>(argv[1])) {
    return 0;
  }
  std::fprintf(stderr, "%s: cannot be written to\n", argv[1]);
  return 1;
}
