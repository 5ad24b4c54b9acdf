#pragma once

// Damages a copy of a dataset folder at random, but in the same way for the same seed.
// Needs the standard library alone, so that corrupt_dataset.cpp builds anywhere.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

namespace srslam::test {

/// One thing that was done to a file.
struct Damage {
  std::string file;  ///< relative to the folder
  std::string what;
};

/// Damages files of one dataset folder.
class DatasetCorrupter {
 public:
  DatasetCorrupter(std::filesystem::path folder, std::uint64_t seed)
      : folder_(std::move(folder)), state_(seed * 0x9E3779B97F4A7C15ULL + 0x1234567ULL) {}

  /// Applies one to three damages.
  std::vector<Damage> corrupt() {
    std::vector<Damage> damages;
    const std::size_t count = 1 + below(3);
    while (damages.size() < count) {
      const std::string file = pick_file();
      if (file.empty()) break;
      damages.push_back({file, damage(file)});
    }
    return damages;
  }

 private:
  // SplitMix64.
  std::uint64_t random() {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31U);
  }
  std::size_t below(std::size_t end) { return static_cast<std::size_t>(random() % end); }

  static bool is_text(const std::string& file) {
    const std::string extension = std::filesystem::path(file).extension().string();
    return extension == ".txt" || extension == ".yaml";
  }

  /// Two times in three a text file, else an image; empty when nothing is left.
  std::string pick_file() {
    std::vector<std::string> texts;
    std::vector<std::string> images;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_)) {
      if (!entry.is_regular_file()) continue;
      const std::string file = entry.path().lexically_relative(folder_).generic_string();
      (is_text(file) ? texts : images).push_back(file);
    }
    std::sort(texts.begin(), texts.end());
    std::sort(images.begin(), images.end());
    const bool from_texts = images.empty() || (!texts.empty() && below(3) < 2);
    const std::vector<std::string>& files = from_texts ? texts : images;
    return files.empty() ? std::string() : files[below(files.size())];
  }

  std::string read(const std::string& file) const {
    std::ifstream stream(folder_ / file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  }

  /// Writes a new file in the place of the old one, which may be a link into another folder.
  void replace(const std::string& file, const std::string& bytes) const {
    std::filesystem::remove(folder_ / file);
    std::ofstream stream(folder_ / file, std::ios::binary);
    stream << bytes;
  }

  std::string damage(const std::string& file) {
    const std::size_t num_kinds = is_text(file) ? 18 : 8;
    switch (below(num_kinds)) {
      case 0:
        return cut(file);
      case 1:
        std::filesystem::remove(folder_ / file);
        return "removed";
      case 2:
        replace(file, "");
        return "emptied";
      case 3:
        std::filesystem::remove(folder_ / file);
        std::filesystem::create_directory(folder_ / file);
        return "replaced by a folder";
      case 4:
        return append_noise(file);
      case 5:
        return take_content_of_another(file);
      case 6:
      case 7:
        return flip_bytes(file);
      default:
        return damage_lines(file);
    }
  }

  std::string cut(const std::string& file) {
    std::string bytes = read(file);
    bytes.resize(below(bytes.size() + 1));
    replace(file, bytes);
    return "cut to " + std::to_string(bytes.size()) + " bytes";
  }

  std::string append_noise(const std::string& file) {
    std::string bytes = read(file);
    const std::size_t count = 1 + below(200);
    for (std::size_t i = 0; i < count; ++i) bytes += static_cast<char>(random() & 0xFFU);
    replace(file, bytes);
    return "appended " + std::to_string(count) + " random bytes";
  }

  std::string take_content_of_another(const std::string& file) {
    const std::string other = pick_file();
    replace(file, read(other));
    return "given the content of " + other;
  }

  std::string flip_bytes(const std::string& file) {
    std::string bytes = read(file);
    const std::size_t count = bytes.empty() ? 0 : 1 + below(16);
    for (std::size_t i = 0; i < count; ++i) {
      // Half of them near the start, where headers are.
      const std::size_t end =
          below(2) == 0 ? bytes.size() : std::min<std::size_t>(bytes.size(), 64);
      char& byte = bytes[below(end)];
      byte = static_cast<char>(static_cast<unsigned char>(byte) ^ (1U + below(255)));
    }
    replace(file, bytes);
    return "flipped bits in " + std::to_string(count) + " bytes";
  }

  static std::vector<std::string> split_lines(const std::string& text) {
    std::vector<std::string> lines;
    for (std::size_t start = 0; start < text.size();) {
      const std::size_t end = std::min(text.find('\n', start), text.size());
      lines.push_back(text.substr(start, end - start));
      start = end + 1;
    }
    return lines;
  }

  /// Replaces one word of `line`.
  void replace_word(std::string* line) {
    static const std::array<const char*, 24> kWords = {
        "nan",   "-nan",      "inf",      "-inf",
        "1e308", "-1e308",    "1e-320",   "1e999",
        "0",     "-1",        "0x1p3",    "1,5",
        "",      "none",      "\xFF\xFE", "99999999999999999999",
        "../..", "/dev/zero", "rgb",      "a b",
        "'",     "[1]",       "1e17",     "4294967296"};
    std::vector<std::pair<std::size_t, std::size_t>> words;
    for (std::size_t i = 0; i < line->size();) {
      const std::size_t start = line->find_first_not_of(" \t", i);
      if (start == std::string::npos) break;
      const std::size_t end = std::min(line->find_first_of(" \t", start), line->size());
      words.emplace_back(start, end - start);
      i = end;
    }
    const std::string word = kWords[below(kWords.size())];
    if (words.empty()) {
      *line = word;
      return;
    }
    const auto [start, length] = words[below(words.size())];
    line->replace(start, length, word);
  }

  std::string damage_lines(const std::string& file) {
    std::vector<std::string> lines = split_lines(read(file));
    if (lines.empty()) lines.emplace_back();
    const std::size_t at = below(lines.size());
    const auto position = lines.begin() + static_cast<std::ptrdiff_t>(at);
    const std::string place = " line " + std::to_string(at + 1);
    std::string what;
    std::string line_end = "\n";
    switch (below(10)) {
      case 0:
        for (std::size_t i = lines.size(); i > 1; --i) std::swap(lines[i - 1], lines[below(i)]);
        what = "shuffled all lines";
        break;
      case 1:
        std::swap(lines[at], lines[below(lines.size())]);
        what = "swapped" + place + " with another";
        break;
      case 2: {
        const std::string copy = *position;
        lines.insert(position, copy);
        what = "doubled" + place;
        break;
      }
      case 3:
        lines.erase(position);
        what = "removed" + place;
        break;
      case 4:
        lines.insert(position, std::string(1 + below(200000), 'x'));
        what = "inserted a long line at" + place;
        break;
      case 5:
        *position += " surplus";
        what = "lengthened" + place;
        break;
      case 6:
        line_end = "\r\n";
        what = "gave all lines carriage returns";
        break;
      default:
        replace_word(&*position);
        what = "replaced a word of" + place;
        break;
    }
    std::string text;
    for (const std::string& line : lines) text += line + line_end;
    replace(file, text);
    return what;
  }

  std::filesystem::path folder_;
  std::uint64_t state_;
};

}  // namespace srslam::test
