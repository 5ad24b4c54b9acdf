#include <cstdio>
#include <cstring>

#include "layout_table.hpp"

namespace srslam::abi {

extern const LayoutTable layout_default;
#ifdef SRSLAM_HAS_LAYOUT_AVX2
extern const LayoutTable layout_avx2;
#endif
#ifdef SRSLAM_HAS_LAYOUT_AVX512F
extern const LayoutTable layout_avx512f;
#endif

namespace {

constexpr int kSkipped = 77;

bool same_text(const char* a, const char* b) {
  return a == nullptr || b == nullptr ? a == b : std::strcmp(a, b) == 0;
}

bool same_layout(const LayoutEntry& a, const LayoutEntry& b) {
  return a.size == b.size && a.alignment == b.alignment && a.offset == b.offset;
}

void print(const char* flags, const LayoutEntry& entry) {
  std::printf("  %-8s size %zu, alignment %zu, offset %zu\n", flags, entry.size, entry.alignment,
              entry.offset);
}

/// Whether `table` lists `type` (and its `field`, unless null).
bool lists(const LayoutTable& table, const char* type, const char* field) {
  for (std::size_t i = 0; i < table.size; ++i) {
    if (same_text(table.entries[i].type, type) && same_text(table.entries[i].field, field)) {
      return true;
    }
  }
  std::printf("not listed: %s %s; the generator of the list misses it\n", type,
              field == nullptr ? "" : field);
  return false;
}

/// Number of differences between the layouts, the control entries aside; -1 when the control does
/// not differ.
int compare(const char* flags, const LayoutTable& table) {
  int differences = 0;
  bool control_differs = false;
  if (table.size != layout_default.size) {
    std::printf("tables of %zu and %zu entries\n", layout_default.size, table.size);
    return 1;
  }
  for (std::size_t i = 0; i < table.size; ++i) {
    const LayoutEntry& expected = layout_default.entries[i];
    const LayoutEntry& actual = table.entries[i];
    if (!same_text(expected.type, actual.type) || !same_text(expected.field, actual.field)) {
      std::printf("entry %zu is not of the same type\n", i);
      ++differences;
    } else if (same_layout(expected, actual)) {
      continue;
    } else if (same_text(expected.type, "Control")) {
      control_differs = true;
    } else {
      std::printf("%s %s changes with %s:\n", expected.type,
                  expected.field == nullptr ? "" : expected.field, flags);
      print("default", expected);
      print(flags, actual);
      ++differences;
    }
  }
  std::printf("%s: %zu entries compared, %d differ\n", flags, table.size, differences);
  if (differences == 0 && !control_differs) return -1;
  return differences;
}

int run() {
  int num_compared = 0;
  int num_vacuous = 0;
  int differences = 0;
  if (!lists(layout_default, "Pose", nullptr) || !lists(layout_default, "PinholeCamera", "fx_px") ||
      !lists(layout_default, "Feature", "octave")) {
    ++differences;
  }
  const auto add = [&](int result) {
    ++num_compared;
    if (result < 0) {
      ++num_vacuous;
    } else {
      differences += result;
    }
  };
#ifdef SRSLAM_HAS_LAYOUT_AVX2
  add(compare("-mavx2", layout_avx2));
#endif
#ifdef SRSLAM_HAS_LAYOUT_AVX512F
  add(compare("-mavx512f", layout_avx512f));
#endif
  if (differences > 0) return 1;
  if (num_compared == 0) {
    std::printf("skipped: the compiler accepts neither -mavx2 nor -mavx512f\n");
    return kSkipped;
  }
  if (num_vacuous == num_compared) {
    std::printf(
        "skipped: an aligned Eigen matrix does not change with these flags either, so "
        "they are on by default in this build and nothing is shown\n");
    return kSkipped;
  }
  return 0;
}

}  // namespace
}  // namespace srslam::abi

int main() { return srslam::abi::run(); }
