#pragma once

#include <string>
#include <string_view>

namespace srslam::cli {

/// Decimal text with the fewest of 15 to 17 significant digits that reads back as exactly `value`.
/// The program never sets a locale, so the decimal separator is a point.
std::string shortest_text(double value);

/// `value` with `digits` decimals; "n/a" when it is not finite.
std::string fixed_text(double value, int digits);

/// Hash of any bytes (FNV-1a, 64 bits) as 16 hexadecimal digits: tells things apart, proves
/// nothing.
std::string hash_text(std::string_view bytes);

}  // namespace srslam::cli
