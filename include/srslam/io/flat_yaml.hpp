#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "srslam/core/status.hpp"

namespace srslam {

/// One `key: value` line of a flat YAML file.
struct FlatYamlEntry {
  std::string key;
  std::string value;     ///< text without quotes, comment and surrounding white space
  std::size_t line = 0;  ///< 1-based
};

/// Reads the flat subset of YAML that camera and configuration files use: one `key: value` a line.
/// Keys start in the first column and consist of letters, digits, `_`, `-` and `.`; values are
/// plain, 'single-' or "double-quoted" (in double quotes `\"` and `\\` are the only escapes).
/// `#` comments, blank lines, a leading `%YAML` line, `---` and a final `...` are accepted, with
/// LF or CRLF ends. Nesting, lists, repeated keys, a key without value, lines that are not UTF-8
/// or are longer than 4096 bytes fail with file, line and reason. Entries keep the file's order; a
/// file without any gives an empty list and success. On failure `entries` is empty.
FileStatus read_flat_yaml(const std::string& path, std::vector<FlatYamlEntry>* entries);

/// Strict parsers of a whole text: no surrounding white space, no trailing characters, nothing
/// locale-dependent. They return false, and leave `value` alone, for anything else.
/// Decimal notation with optional sign and exponent; NaN, infinities, hexadecimal numbers and
/// numbers that a double cannot hold are refused.
bool parse_double(std::string_view text, double* value);
/// Decimal integer with optional sign, in the range of int.
bool parse_int(std::string_view text, int* value);
/// `true` or `false`.
bool parse_bool(std::string_view text, bool* value);

/// Values of an entry with a complete error: on failure the status has the file, the entry's line
/// and a reason that names the key, quotes the text and says what would be right.
FileStatus read_value(const std::string& path, const FlatYamlEntry& entry, double* value);
FileStatus read_value(const std::string& path, const FlatYamlEntry& entry, int* value);
FileStatus read_value(const std::string& path, const FlatYamlEntry& entry, bool* value);

/// The failure for an entry whose key is none of `known_keys`; the reason lists them.
FileStatus unknown_key(const std::string& path, const FlatYamlEntry& entry,
                       const std::vector<std::string>& known_keys);

}  // namespace srslam
