#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "srslam/core/status.hpp"

namespace srslam::cli {

enum class PlotFormat : std::uint8_t { kPng, kSvg };

/// Part of a picture, in shares of its width and height, origin at the lower left.
struct PlotBox {
  double left;
  double right;
  double bottom;
  double top;
};

/// A single-quoted gnuplot string, in which nothing but the quote itself has a meaning.
std::string gnuplot_quoted(const std::string& text);

/// `set` commands that begin a picture of this size in the file `name`.
std::string gnuplot_picture(PlotFormat format, int width_px, int height_px,
                            const std::string& name);

/// `set` commands that put the next plot into `box`, and its title above it.
std::string gnuplot_box(const PlotBox& box, const std::string& title);

/// Runs `script` with the program `gnuplot` in a hidden folder in `parent`, which is removed again,
/// and hands over the files `names` that the script writes into its working folder. Fails with
/// `subject` as file when gnuplot is not there, fails, or writes less.
FileStatus run_gnuplot(const std::string& script, const std::string& parent,
                       const std::string& subject, const std::vector<std::string>& names,
                       std::vector<std::string>* contents);

}  // namespace srslam::cli
