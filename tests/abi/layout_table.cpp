// Compiled once for each set of -m flags, under another SRSLAM_LAYOUT_NAME each time. Data only:
// nothing in the object may run, since the processor of the test machine need not know the flags.

#include "layout_table.hpp"

#define SRSLAM_LAYOUT_TYPE(type) \
  { #type, nullptr, sizeof(type), alignof(type), 0 }
#define SRSLAM_LAYOUT_FIELD(type, field) \
  { #type, #field, sizeof(type::field), alignof(decltype(type::field)), offsetof(type, field) }

// The generated file starts with the includes of the headers that it lists.
#define SRSLAM_LAYOUT_INCLUDES
#include "layout_entries.inc"
#undef SRSLAM_LAYOUT_INCLUDES

#include <Eigen/Core>

namespace srslam::abi {
namespace {

// A type that is known to change with the flags: if it does not, the comparison shows nothing.
struct Control {
  bool flag;
  Eigen::Matrix4d matrix;
};

constexpr LayoutEntry kEntries[] = {
    SRSLAM_LAYOUT_TYPE(Control),
    SRSLAM_LAYOUT_FIELD(Control, matrix),
#include "layout_entries.inc"
};

}  // namespace

extern const LayoutTable SRSLAM_LAYOUT_NAME;
constexpr LayoutTable SRSLAM_LAYOUT_NAME = {kEntries, sizeof(kEntries) / sizeof(kEntries[0])};

}  // namespace srslam::abi
