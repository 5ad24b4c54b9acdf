#pragma once

#include <string>

namespace srslam::cli {

/// What the program was built with, for the record of a run.
struct LibraryVersions {
  std::string srslam;
  std::string eigen;
  std::string opencv;
  std::string ceres;
  std::string compiler;
};
LibraryVersions library_versions();

/// The machine that the program runs on, without which times mean nothing.
struct Machine {
  std::string cpu;  ///< "unknown" where the system does not say
  unsigned num_logical_cores = 0;
};
Machine this_machine();

/// Largest memory that the process has held so far [MiB], as the system counts it.
double peak_memory_mib();

}  // namespace srslam::cli
