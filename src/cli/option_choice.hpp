#pragma once

#include <type_traits>
#include <utility>
#include <vector>

#include "cli/pipeline_config.hpp"

namespace srslam::cli {

/// Bound that exists only so that a slip of the keyboard is caught.
constexpr double kMuch = 1e6;

/// Accessors of an enumeration, or a flag, whose values are numbered from 0 in the order of
/// `names`. `Access::of(options)` gives the field.
template <typename Access>
ChoiceOption choice(Access, std::vector<const char*> names) {
  using Value = std::decay_t<decltype(Access::of(std::declval<PipelineOptions&>()))>;
  ChoiceOption option;
  option.get = [](const PipelineOptions& options) {
    PipelineOptions copy = options;  // the accessor gives a mutable reference
    return static_cast<int>(Access::of(copy));
  };
  option.set = [](PipelineOptions& options, int value) {
    Access::of(options) = static_cast<Value>(value);
  };
  option.names = std::move(names);
  return option;
}

}  // namespace srslam::cli
