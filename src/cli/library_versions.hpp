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

/// Version of srslam and of its synthetic world, and a hash of the running program's own file:
/// results of programs that differ in it were not made by the same code. Computed once.
const std::string& program_identity();

/// The machine that the program runs on, without which times mean nothing.
struct Machine {
  std::string cpu;  ///< "unknown" where the system does not say
  unsigned num_logical_cores = 0;
};
Machine this_machine();

/// Largest memory that the process has held so far [MiB], as the system counts it.
double peak_memory_mib();

}  // namespace srslam::cli
