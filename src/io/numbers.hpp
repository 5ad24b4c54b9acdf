#pragma once

// Locale-independent conversion between numbers and text. std::from_chars and std::to_chars do it
// without allocating; libstdc++ before 11 lacks them for double, so streams with the classic locale
// stand in there. Both ways are always compiled, so that tests compare them.

#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <locale>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>

namespace srslam::io_detail {

#if defined(__cpp_lib_to_chars)
inline constexpr bool kHasFloatCharconv = true;
#else
inline constexpr bool kHasFloatCharconv = false;
#endif

constexpr bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }

/// Whether `text` is `[+-]digits[.digits][(e|E)[+-]digits]` with at least one digit before the
/// exponent; `has_nonzero_digit` is that of the part before the exponent.
constexpr bool is_decimal_number(std::string_view text, bool* has_nonzero_digit) noexcept {
  std::size_t i = 0;
  if (i < text.size() && (text[i] == '+' || text[i] == '-')) ++i;
  std::size_t num_digits = 0;
  *has_nonzero_digit = false;
  bool seen_point = false;
  for (; i < text.size(); ++i) {
    if (text[i] == '.' && !seen_point) {
      seen_point = true;
    } else if (is_digit(text[i])) {
      ++num_digits;
      if (text[i] != '0') *has_nonzero_digit = true;
    } else {
      break;
    }
  }
  if (num_digits == 0) return false;
  if (i == text.size()) return true;
  if (text[i] != 'e' && text[i] != 'E') return false;
  ++i;
  if (i < text.size() && (text[i] == '+' || text[i] == '-')) ++i;
  if (i == text.size()) return false;
  for (; i < text.size(); ++i) {
    if (!is_digit(text[i])) return false;
  }
  return true;
}

/// Fallback of parse_decimal(): `text` is a decimal number by is_decimal_number().
inline bool parse_decimal_by_stream(std::string_view text, double* value) {
  std::istringstream stream{std::string(text)};
  stream.imbue(std::locale::classic());
  double parsed = 0.0;
  if (!(stream >> parsed) || stream.peek() != std::istringstream::traits_type::eof()) return false;
  *value = parsed;
  return true;
}

#if defined(__cpp_lib_to_chars)
inline bool parse_decimal_by_chars(std::string_view text, double* value) {
  if (text.front() == '+') text.remove_prefix(1);  // std::from_chars knows no plus sign
  double parsed = 0.0;
  const std::from_chars_result result =
      std::from_chars(text.data(), text.data() + text.size(), parsed);
  if (result.ec != std::errc() || result.ptr != text.data() + text.size()) return false;
  *value = parsed;
  return true;
}
#endif

/// Strict finite decimal number; false (and `value` untouched) for anything else, for overflow and
/// for a non-zero number that underflows to zero.
inline bool parse_decimal(std::string_view text, double* value) {
  bool has_nonzero_digit = false;
  if (!is_decimal_number(text, &has_nonzero_digit)) return false;
  double parsed = 0.0;
#if defined(__cpp_lib_to_chars)
  if (!parse_decimal_by_chars(text, &parsed)) return false;
#else
  if (!parse_decimal_by_stream(text, &parsed)) return false;
#endif
  if (!std::isfinite(parsed) || (parsed == 0.0 && has_nonzero_digit)) return false;
  *value = parsed;
  return true;
}

/// How append_number() writes: `kFixed` with `digits` decimals, `kGeneral` with `digits`
/// significant ones.
enum class NumberFormat : unsigned char { kFixed, kGeneral };

inline void append_number_by_stream(double value, NumberFormat format, int digits,
                                    std::string* text) {
  std::ostringstream stream;
  stream.imbue(std::locale::classic());
  if (format == NumberFormat::kFixed) stream.setf(std::ios::fixed, std::ios::floatfield);
  stream.precision(digits);
  stream << value;
  *text += stream.str();
}

#if defined(__cpp_lib_to_chars)
inline void append_number_by_chars(double value, NumberFormat format, int digits,
                                   std::string* text) {
  // Longest fixed form: sign, 309 digits, point, decimals.
  char buffer[400];
  const std::to_chars_result result = std::to_chars(
      buffer, buffer + sizeof(buffer), value,
      format == NumberFormat::kFixed ? std::chars_format::fixed : std::chars_format::general,
      digits);
  text->append(buffer, static_cast<std::size_t>(result.ptr - buffer));
}
#endif

/// Appends a finite number; `digits` <= 17.
inline void append_number(double value, NumberFormat format, int digits, std::string* text) {
#if defined(__cpp_lib_to_chars)
  append_number_by_chars(value, format, digits, text);
#else
  append_number_by_stream(value, format, digits, text);
#endif
}

/// Appends the first of the given precisions whose text reads back as the same bits.
inline void append_round_trip(double value, NumberFormat format, int min_digits, int max_digits,
                              std::string* text) {
  const std::size_t start = text->size();
  for (int digits = min_digits; digits <= max_digits; ++digits) {
    text->resize(start);
    append_number(value, format, digits, text);
    double parsed = 0.0;
    if (parse_decimal(std::string_view(*text).substr(start), &parsed) && parsed == value) return;
  }
  // Only tiny numbers need more decimals than a fixed format was allowed.
  text->resize(start);
  append_number(value, NumberFormat::kGeneral, std::numeric_limits<double>::max_digits10, text);
}

/// Shortest of 15 to 17 significant digits that reads back exactly.
inline void append_exact(double value, std::string* text) {
  append_round_trip(value, NumberFormat::kGeneral, 15, 17, text);
}

/// A time stamp with as many decimals, at least six, as it takes to read it back exactly.
inline void append_timestamp(double value_s, std::string* text) {
  append_round_trip(value_s, NumberFormat::kFixed, 6, 17, text);
}

}  // namespace srslam::io_detail
