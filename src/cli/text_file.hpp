#pragma once

#include <string>

#include "srslam/core/status.hpp"

namespace srslam::cli {

/// Writes `text` to `path` so that readers see the old file or the whole new one, never a part:
/// to a hidden neighbour first, flushed to disk, then renamed. A failure leaves no neighbour.
FileStatus write_file_atomically(const std::string& path, const std::string& text);

/// Reads the whole file `path`. `text` is set on success only.
FileStatus read_text_file(const std::string& path, std::string* text);

}  // namespace srslam::cli
