#pragma once

#include <string>
#include <vector>

namespace srslam::cli {

/// Parts between commas without the blanks around them; empty parts are kept, to be refused.
std::vector<std::string> split_at_commas(const std::string& text);

/// `parts` with ", " or another separator between them.
std::string joined(const std::vector<std::string>& parts, const char* separator = ", ");

/// A field of a CSV line, quoted when it holds commas, quotes or line ends.
std::string csv_text(const std::string& text);

}  // namespace srslam::cli
