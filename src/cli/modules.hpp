#pragma once

#include <string>
#include <vector>

namespace srslam::cli {

/// A part of the paper that can be switched on its own. To add one: mark it built here, map it to
/// its pipeline option where run_command.cpp applies the selection.
struct Module {
  char letter = '\0';
  const char* name = "";
  bool built = false;             ///< whether this version of the program contains it
  const char* requirements = "";  ///< letters that must be selected with it
};

/// Every module of the paper in the order of the flow: S, P, D, B.
const std::vector<Module>& known_modules();

/// Modules that a run uses: letters in table order, empty for the baseline.
struct ModuleSelection {
  std::string letters;

  bool has(char letter) const { return letters.find(letter) != std::string::npos; }
  /// `none`, or the letters separated by commas, as `--modules` takes them.
  std::string text() const;
};

/// Every module that `modules` marks as built.
ModuleSelection default_modules(const std::vector<Module>& modules);

/// Reads what `--modules` was given: `none` or letters separated by commas, such as `S,P`. Unknown
/// and repeated letters, modules that are not built and missing requirements are errors.
/// Returns an empty string, or the reason; `selection` is set on success only.
std::string parse_modules(const std::string& text, const std::vector<Module>& modules,
                          ModuleSelection* selection);

}  // namespace srslam::cli
