#pragma once

#include <cstddef>

namespace srslam::abi {

/// Layout of one type (field is null) or of one of its fields.
struct LayoutEntry {
  const char* type;
  const char* field;
  std::size_t size;
  std::size_t alignment;
  std::size_t offset;
};

struct LayoutTable {
  const LayoutEntry* entries;
  std::size_t size;
};

}  // namespace srslam::abi
