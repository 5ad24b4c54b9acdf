#pragma once

#include <string>
#include <utility>
#include <vector>

namespace srslam::cli {

/// A table for people, whatever it is written in.
struct TextTable {
  struct Field {
    Field(std::string content, bool stands_out = false)  // NOLINT: fields are mostly plain text
        : text(std::move(content)), emphasized(stands_out) {}

    std::string text;
    bool emphasized = false;
    std::string link;  ///< relative, for pages
  };
  using Row = std::vector<Field>;

  std::string title;
  std::vector<std::string> header;
  std::vector<Row> rows;
};

/// Text that Markdown shows as it is, on one line.
std::string markdown_text(const std::string& text);

/// `table` as a heading and a table in Markdown.
std::string markdown_table(const TextTable& table);

}  // namespace srslam::cli
