#include "srslam/io/flat_yaml.hpp"

#include <algorithm>
#include <charconv>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "numbers.hpp"
#include "text_file.hpp"

namespace srslam {
namespace {

using io_detail::LineReader;
using io_detail::quote;
using io_detail::trim;

bool is_key_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || io_detail::is_digit(c) || c == '_' ||
         c == '-' || c == '.';
}

/// Reads the quoted text that `text` starts with and leaves what follows it in `text`; false when
/// the closing quote is missing or an escape is not known.
bool take_quoted(std::string_view* text, std::string* value) {
  const char delimiter = text->front();
  std::size_t i = 1;
  for (; i < text->size(); ++i) {
    const char c = (*text)[i];
    const char following = i + 1 < text->size() ? (*text)[i + 1] : '\0';
    if (c == '\\' && delimiter == '"') {
      if (following != '"' && following != '\\') return false;
      *value += following;
      ++i;
    } else if (c == delimiter) {
      if (delimiter == '"' || following != '\'') break;
      *value += '\'';  // YAML's single-quoted form doubles the quote
      ++i;
    } else {
      *value += c;
    }
  }
  if (i == text->size()) return false;
  text->remove_prefix(i + 1);
  return true;
}

/// Reads what stands after the colon; returns the reason for a refusal or an empty string.
std::string take_value(std::string_view text, const std::string& key, std::string* value) {
  text = trim(text);
  if (text.empty() || text.front() == '#') {
    return "key " + quote(key) + " has no value; expected `" + key + ": value` on one line";
  }
  if (text.front() == '"' || text.front() == '\'') {
    if (!take_quoted(&text, value)) {
      return "value of key " + quote(key) + " has no closing quote or an unknown escape";
    }
    const std::string_view rest = trim(text);
    const bool is_comment = !rest.empty() && rest.front() == '#' && !text.empty() &&
                            (text.front() == ' ' || text.front() == '\t');
    if (!rest.empty() && !is_comment) {
      return "unexpected " + quote(rest) + " after the quoted value of key " + quote(key);
    }
    return {};
  }
  if (std::string_view("[]{}&*!|>%@`,").find(text.front()) != std::string_view::npos) {
    return "value of key " + quote(key) + " is " + quote(text) +
           "; lists, maps and other YAML constructs are not supported: one plain value a key";
  }
  for (std::size_t i = 1; i < text.size(); ++i) {
    if (text[i] == '#' && (text[i - 1] == ' ' || text[i - 1] == '\t')) {
      text = trim(text.substr(0, i));
      break;
    }
  }
  *value = std::string(text);
  return {};
}

FileStatus parse_entries(LineReader* reader, std::vector<FlatYamlEntry>* entries) {
  std::unordered_map<std::string, std::size_t> line_of_key;
  bool seen_separator = false;
  bool seen_end = false;
  std::string_view line;
  while (reader->next(&line)) {
    const std::string_view text = trim(line);
    if (text.empty() || text.front() == '#') continue;
    const auto refuse = [reader](std::string reason) {
      return reader->failure(StatusCode::kCorruptData, std::move(reason));
    };
    if (seen_end) return refuse("text after the end mark `...`");
    if (line.substr(0, 5) == "%YAML" && entries->empty() && !seen_separator) continue;
    if (text == "---" && line.front() == '-') {
      if (seen_separator || !entries->empty()) return refuse("only one YAML document is expected");
      seen_separator = true;
      continue;
    }
    if (text == "..." && line.front() == '.') {
      seen_end = true;
      continue;
    }
    if (line.front() == ' ' || line.front() == '\t') {
      return refuse(
          "line is indented; nested values are not supported, write `key: value` from the "
          "first column");
    }
    std::size_t length = 0;
    while (length < line.size() && is_key_character(line[length])) ++length;
    const std::string_view rest = line.substr(length);
    const bool has_colon = !rest.empty() && rest.front() == ':' &&
                           (rest.size() == 1 || rest[1] == ' ' || rest[1] == '\t');
    if (length == 0 || !has_colon) {
      return refuse("expected `key: value` with a space after the colon, got " + quote(text));
    }
    FlatYamlEntry entry;
    entry.key = std::string(line.substr(0, length));
    entry.line = reader->line_number();
    const std::string reason = take_value(rest.substr(1), entry.key, &entry.value);
    if (!reason.empty()) return refuse(reason);
    const auto [position, is_new] = line_of_key.emplace(entry.key, entry.line);
    if (!is_new) {
      return refuse("key " + quote(entry.key) + " was already given on line " +
                    std::to_string(position->second) + "; each key may occur once");
    }
    entries->push_back(std::move(entry));
  }
  return reader->status();
}

FileStatus wrong_value(const std::string& path, const FlatYamlEntry& entry, const char* expected) {
  return FileStatus::failure(
      StatusCode::kInvalidArgument, path, entry.line,
      "value " + quote(entry.value) + " of key " + quote(entry.key) + " is not " + expected);
}

}  // namespace

FileStatus read_flat_yaml(const std::string& path, std::vector<FlatYamlEntry>* entries) {
  entries->clear();
  LineReader reader;
  FileStatus status = reader.open(path);
  if (status.ok()) status = parse_entries(&reader, entries);
  if (!status.ok()) entries->clear();
  return status;
}

bool parse_double(std::string_view text, double* value) {
  return io_detail::parse_decimal(text, value);
}

bool parse_int(std::string_view text, int* value) {
  if (!text.empty() && text.front() == '+') {
    text.remove_prefix(1);
    if (!text.empty() && text.front() == '-') return false;
  }
  int parsed = 0;
  const std::from_chars_result result =
      std::from_chars(text.data(), text.data() + text.size(), parsed);
  if (result.ec != std::errc() || result.ptr != text.data() + text.size()) return false;
  *value = parsed;
  return true;
}

bool parse_bool(std::string_view text, bool* value) {
  if (text != "true" && text != "false") return false;
  *value = text == "true";
  return true;
}

FileStatus read_value(const std::string& path, const FlatYamlEntry& entry, double* value) {
  if (parse_double(entry.value, value)) return FileStatus::success();
  return wrong_value(path, entry, "a finite decimal number such as 0.25");
}

FileStatus read_value(const std::string& path, const FlatYamlEntry& entry, int* value) {
  if (parse_int(entry.value, value)) return FileStatus::success();
  return wrong_value(path, entry, "a whole number such as 640");
}

FileStatus read_value(const std::string& path, const FlatYamlEntry& entry, bool* value) {
  if (parse_bool(entry.value, value)) return FileStatus::success();
  return wrong_value(path, entry, "`true` or `false`");
}

FileStatus unknown_key(const std::string& path, const FlatYamlEntry& entry,
                       const std::vector<std::string>& known_keys) {
  std::string reason = "unknown key " + quote(entry.key) + "; known keys:";
  for (std::size_t i = 0; i < known_keys.size(); ++i) {
    reason += (i == 0 ? " " : ", ") + known_keys[i];
  }
  return FileStatus::failure(StatusCode::kInvalidArgument, path, entry.line, std::move(reason));
}

}  // namespace srslam
