#include "cli/text_table.hpp"

#include <cctype>
#include <cstddef>

namespace srslam::cli {

std::string markdown_text(const std::string& text) {
  const auto is_word = [&text](std::size_t place) {
    return place < text.size() &&
           (std::isalnum(static_cast<unsigned char>(text[place])) != 0 || text[place] == '_');
  };
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char character = text[i];
    // An underline inside a word is a letter, brackets mean something only before a parenthesis.
    const bool is_special = std::string("\\`*<>|").find(character) != std::string::npos ||
                            (character == '_' && !(i > 0 && is_word(i - 1) && is_word(i + 1))) ||
                            text.compare(i, 2, "](") == 0;
    if (is_special) result += '\\';
    result += static_cast<unsigned char>(character) < 0x20U ? ' ' : character;
  }
  return result;
}

std::string markdown_table(const TextTable& table) {
  std::string text = "## " + markdown_text(table.title) + "\n\n";
  std::string rule;
  for (const std::string& name : table.header) {
    text += "| " + markdown_text(name) + " ";
    rule += "|---";
  }
  text += "|\n" + rule + "|\n";
  for (const TextTable::Row& row : table.rows) {
    for (const TextTable::Field& field : row) {
      const std::string shown = markdown_text(field.text);
      text += field.emphasized ? "| **" + shown + "** " : "| " + shown + " ";
    }
    text += "|\n";
  }
  return text + "\n";
}

}  // namespace srslam::cli
