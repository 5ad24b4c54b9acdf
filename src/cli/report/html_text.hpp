#pragma once

#include <string>

#include "cli/text_table.hpp"

namespace srslam::cli {

/// `text` as HTML shows it, inside and outside of quoted attributes.
std::string html_text(const std::string& text);

/// A heading and a table that scrolls sideways where the window is narrow.
std::string html_table(const TextTable& table);

/// Base64 (RFC 4648) of `bytes`.
std::string base64(const std::string& bytes);

/// A picture that is part of the page. `media_type` such as image/svg+xml; `description` is for who
/// does not see it, `caption` stands below.
std::string html_picture(const std::string& media_type, const std::string& bytes,
                         const std::string& description, const std::string& caption);

/// A whole page around `body`, which is HTML already. It needs nothing but itself.
std::string html_page(const std::string& title, const std::string& body);

}  // namespace srslam::cli
