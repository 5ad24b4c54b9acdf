#include "cli/gnuplot.hpp"

#include <stdlib.h>  // NOLINT(modernize-deprecated-headers): mkdtemp() is POSIX, not <cstdlib>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "cli/child_process.hpp"
#include "cli/number_text.hpp"
#include "cli/text_file.hpp"

namespace srslam::cli {
namespace {

constexpr double kGnuplotTimeout_s = 60.0;
constexpr const char* kScriptName = "plot.gp";
constexpr const char* kLogName = "gnuplot.log";

/// First line of the file that says anything, for the reason of a failure.
std::string first_line(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line;
  while (std::getline(stream, line)) {
    if (line.find_first_not_of(" \t\r^") != std::string::npos) return line;
  }
  return {};
}

/// A new hidden folder that is removed with the object.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const std::filesystem::path& parent) {
    std::string name = (parent / ".plot-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
      error_number_ = errno;
    } else {
      path_ = name;
    }
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  int error_number() const { return error_number_; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int error_number_ = 0;
};

}  // namespace

std::string gnuplot_quoted(const std::string& text) {
  std::string result = "'";
  for (const char character : text) {
    if (static_cast<unsigned char>(character) < 0x20U || character == 0x7F) {
      result += ' ';
    } else if (character == '\'') {
      result += "''";
    } else {
      result += character;
    }
  }
  return result + "'";
}

std::string gnuplot_picture(PlotFormat format, int width_px, int height_px,
                            const std::string& name) {
  const std::string size =
      " noenhanced size " + std::to_string(width_px) + "," + std::to_string(height_px);
  std::string script = "set encoding utf8\n";
  script += format == PlotFormat::kPng
                ? "set terminal pngcairo" + size + " font ',11'\n"
                : "set terminal svg" + size + " font 'sans-serif,11' background '#ffffff'\n";
  script += "set output " + gnuplot_quoted(name) + "\n";
  script += "set datafile separator whitespace\n";
  script += "set tics nomirror\nset border 3\nset grid lc rgb '#e6e6e6' lt 1 lw 1\n";
  return script;
}

std::string gnuplot_box(const PlotBox& box, const std::string& title) {
  return "set lmargin at screen " + shortest_text(box.left) + "\nset rmargin at screen " +
         shortest_text(box.right) + "\nset bmargin at screen " + shortest_text(box.bottom) +
         "\nset tmargin at screen " + shortest_text(box.top) + "\nset label 1 " +
         gnuplot_quoted(title) + " at screen " + shortest_text(box.left) + "," +
         shortest_text(box.top + 0.033) + " left font ',12'\n";
}

FileStatus run_gnuplot(const std::string& script, const std::string& parent,
                       const std::string& subject, const std::vector<std::string>& names,
                       std::vector<std::string>* contents) {
  const auto fail = [&subject](const std::string& reason) {
    return FileStatus::failure(StatusCode::kIoError, subject, 0, reason);
  };
  std::error_code error;
  const std::filesystem::path absolute_parent =
      std::filesystem::absolute(parent.empty() ? "." : parent, error);
  if (error) return fail(error.message());
  const TemporaryFolder folder(absolute_parent);
  if (folder.path().empty()) {
    return fail("no folder for the drawing can be made: " +
                std::generic_category().message(folder.error_number()));
  }
  const FileStatus written = write_file_atomically((folder.path() / kScriptName).string(), script);
  if (!written.ok()) return fail(written.message());
  const std::string log_file = (folder.path() / kLogName).string();
  const std::string reason = run_child_process({"gnuplot", kScriptName}, folder.path().string(),
                                               log_file, kGnuplotTimeout_s);
  if (!reason.empty()) {
    const std::string detail = first_line(log_file);
    return fail(detail.empty() ? reason : reason + ": " + detail);
  }
  std::vector<std::string> result;
  for (const std::string& name : names) {
    std::string content;
    if (!read_text_file((folder.path() / name).string(), &content).ok() || content.empty()) {
      return fail("gnuplot wrote no picture");
    }
    result.push_back(content);
  }
  *contents = result;
  return FileStatus::success();
}

}  // namespace srslam::cli
