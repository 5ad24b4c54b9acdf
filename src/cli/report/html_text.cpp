#include "cli/report/html_text.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace srslam::cli {
namespace {

constexpr const char* kStyle = R"(
:root { color-scheme: light dark; --text: #1d2129; --soft: #5c6470; --page: #ffffff; --band: #f4f5f7;
  --line: #d9dce1; --mark: #0b6b3a; }
@media (prefers-color-scheme: dark) {
  :root { --text: #e4e6ea; --soft: #a2a9b4; --page: #16181d; --band: #20242b; --line: #3a3f48;
    --mark: #6fd39b; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 90rem; padding: 1rem; color: var(--text);
  background: var(--page); font: 15px/1.5 system-ui, sans-serif; overflow-wrap: anywhere; }
h1 { font-size: 1.5rem; line-height: 1.25; margin: .5rem 0; }
h2 { font-size: 1.1rem; margin: 1.6rem 0 .5rem; }
p, li { color: var(--soft); margin: .3rem 0; }
a { color: inherit; }
ul { padding-left: 1.2rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; overflow-wrap: normal; }
th, td { padding: .25rem .7rem; border-bottom: 1px solid var(--line); text-align: left;
  vertical-align: top; }
td { max-width: 40rem; }
th { background: var(--band); font-weight: 600; }
td b { color: var(--mark); }
.grid { display: grid; gap: 1rem; grid-template-columns: repeat(auto-fit, minmax(min(100%, 26rem), 1fr)); }
figure { margin: 0; }
figure img { display: block; width: 100%; height: auto; background: #ffffff; border: 1px solid var(--line);
  border-radius: 6px; }
figcaption { color: var(--soft); font-size: .9rem; margin-top: .2rem; }
.key { display: inline-block; width: .8em; height: .8em; border-radius: 50%; margin: 0 .3em 0 .8em; }
)";

}  // namespace

std::string html_text(const std::string& text) {
  std::string result;
  for (const char character : text) {
    switch (character) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\'':
        result += "&#39;";
        break;
      default:
        // Control characters are not allowed in a page.
        result +=
            static_cast<unsigned char>(character) < 0x20U || character == 0x7F ? ' ' : character;
    }
  }
  return result;
}

std::string html_table(const TextTable& table) {
  std::string text = "<h2>" + html_text(table.title) + "</h2>\n<div class=\"scroll\"><table>\n<tr>";
  for (const std::string& name : table.header) text += "<th>" + html_text(name) + "</th>";
  text += "</tr>\n";
  for (const TextTable::Row& row : table.rows) {
    text += "<tr>";
    for (const TextTable::Field& field : row) {
      text += "<td>";
      if (!field.link.empty()) text += "<a href=\"" + html_text(field.link) + "\">";
      if (field.emphasized) text += "<b>";
      text += html_text(field.text);
      if (field.emphasized) text += "</b>";
      if (!field.link.empty()) text += "</a>";
      text += "</td>";
    }
    text += "</tr>\n";
  }
  return text + "</table></div>\n";
}

std::string base64(const std::string& bytes) {
  constexpr std::array<char, 65> kDigits = {
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"};
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = bytes.size() - i < 3 ? bytes.size() - i : 3;
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = bits << 8U | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= count ? kDigits[bits >> (18U - 6U * k) & 63U] : '=';
    }
  }
  return text;
}

std::string html_picture(const std::string& media_type, const std::string& bytes,
                         const std::string& description, const std::string& caption) {
  return "<figure><img alt=\"" + html_text(description) + "\" src=\"data:" + media_type +
         ";base64," + base64(bytes) + "\">" +
         (caption.empty() ? "" : "<figcaption>" + html_text(caption) + "</figcaption>") +
         "</figure>\n";
}

std::string html_page(const std::string& title, const std::string& body) {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         html_text(title) + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<h1>" +
         html_text(title) + "</h1>\n" + body + "</body>\n</html>\n";
}

}  // namespace srslam::cli
