#include "cli/library_versions.hpp"

#include <ceres/version.h>
#include <sys/resource.h>

#include <Eigen/Core>
#include <fstream>
#include <iterator>
#include <opencv2/core/version.hpp>
#include <thread>

#include "cli/number_text.hpp"
#include "srslam/synthetic/synthetic_options.hpp"
#include "srslam/version.hpp"

namespace srslam::cli {

LibraryVersions library_versions() {
  LibraryVersions versions;
  versions.srslam = SRSLAM_VERSION_STRING;
  versions.eigen = std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) +
                   "." + std::to_string(EIGEN_MINOR_VERSION);
  versions.opencv = CV_VERSION;
  versions.ceres = CERES_VERSION_STRING;
#if defined(__clang__)
  versions.compiler = std::string("clang ") + __clang_version__;
#elif defined(__GNUC__)
  versions.compiler = std::string("gcc ") + __VERSION__;
#else
  versions.compiler = "unknown";
#endif
  return versions;
}

const std::string& program_identity() {
  static const std::string identity = [] {
    std::ifstream file("/proc/self/exe", std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    return std::string(SRSLAM_VERSION_STRING) + " (program " + hash_text(bytes) +
           ", synthetic world " + std::to_string(kSyntheticWorldVersion) + ")";
  }();
  return identity;
}

Machine this_machine() {
  Machine machine;
  machine.num_logical_cores = std::thread::hardware_concurrency();
  machine.cpu = "unknown";
  std::ifstream cpuinfo("/proc/cpuinfo");
  std::string line;
  while (std::getline(cpuinfo, line)) {
    const std::size_t colon = line.find(": ");
    if (line.compare(0, 10, "model name") != 0 || colon == std::string::npos) continue;
    machine.cpu = line.substr(colon + 2);
    break;
  }
  return machine;
}

double peak_memory_mib() {
  rusage usage = {};
  if (::getrusage(RUSAGE_SELF, &usage) != 0) return 0.0;
#if defined(__APPLE__)
  constexpr double kUnitsPerMib = 1024.0 * 1024.0;  // bytes there, KiB elsewhere
#else
  constexpr double kUnitsPerMib = 1024.0;
#endif
  return static_cast<double>(usage.ru_maxrss) / kUnitsPerMib;
}

}  // namespace srslam::cli
