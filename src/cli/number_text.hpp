#pragma once

#include <string>

namespace srslam::cli {

/// Decimal text with the fewest of 15 to 17 significant digits that reads back as exactly `value`.
/// The program never sets a locale, so the decimal separator is a point.
std::string shortest_text(double value);

/// `value` with `digits` decimals; "n/a" when it is not finite.
std::string fixed_text(double value, int digits);

}  // namespace srslam::cli
