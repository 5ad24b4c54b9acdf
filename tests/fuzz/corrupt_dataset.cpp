// corrupt_dataset SRC DST SEED: makes a damaged copy of a dataset folder, for run_corruptions.sh.
// Text files are copied, images linked, and what is damaged is written anew, so that copies are
// cheap and SRC is never touched. Prints what was done, one damage a line.

#include <charconv>
#include <cstdint>
#include <cstring>
#include <exception>
#include <filesystem>
#include <iostream>
#include <string>
#include <system_error>

#include "dataset_corruption.hpp"

namespace {

namespace fs = std::filesystem;

void copy_dataset(const fs::path& source, const fs::path& target) {
  fs::create_directories(target);
  for (const auto& entry : fs::recursive_directory_iterator(source)) {
    const fs::path copy = target / entry.path().lexically_relative(source);
    const std::string extension = entry.path().extension().string();
    if (entry.is_directory()) {
      fs::create_directories(copy);
    } else if (extension == ".txt" || extension == ".yaml") {
      fs::copy_file(entry.path(), copy);
      fs::permissions(copy, fs::perms::owner_write, fs::perm_options::add);
    } else {
      fs::create_symlink(entry.path(), copy);
    }
  }
}

int run(const char* source_argument, const char* target_argument, const char* seed_argument) {
  const fs::path source = fs::canonical(source_argument);
  const fs::path target = target_argument;
  std::uint64_t seed = 0;
  const char* seed_end = seed_argument + std::strlen(seed_argument);
  const std::from_chars_result result = std::from_chars(seed_argument, seed_end, seed);
  if (result.ec != std::errc() || result.ptr != seed_end) {
    std::cerr << "corrupt_dataset: SEED must be a whole number, got '" << seed_argument << "'\n";
    return 2;
  }
  if (!fs::is_directory(source) || fs::exists(target)) {
    std::cerr << "corrupt_dataset: SRC must be a folder, and DST must not exist yet\n";
    return 2;
  }
  copy_dataset(source, target);
  srslam::test::DatasetCorrupter corrupter(target, seed);
  for (const srslam::test::Damage& damage : corrupter.corrupt()) {
    std::cout << damage.file << ": " << damage.what << "\n";
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: corrupt_dataset SRC DST SEED\n";
    return 2;
  }
  try {
    return run(argv[1], argv[2], argv[3]);
  } catch (const std::exception& exception) {
    std::cerr << "corrupt_dataset: " << exception.what() << "\n";
    return 1;
  }
}
