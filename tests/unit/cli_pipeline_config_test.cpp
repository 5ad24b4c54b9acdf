#include "cli/pipeline_config.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "support/io_test_dataset.hpp"

namespace srslam::cli {
namespace {

using srslam::test::TempFolder;
using srslam::test::write_text;

/// Stands for a value of any type, to count the members of an aggregate.
struct AnyValue {
  template <typename T>
  operator T() const;  // NOLINT(google-explicit-constructor)
};

// Clang warns of the members that an attempt leaves out.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
template <typename Aggregate, std::size_t... kIndices>
constexpr auto takes(std::index_sequence<kIndices...>)
    -> decltype(Aggregate{(static_cast<void>(kIndices), AnyValue{})...}, true) {
  return true;
}
#pragma GCC diagnostic pop
template <typename Aggregate>
constexpr bool takes(...) {
  return false;
}

/// Number of members of an aggregate: how many values it can be made of.
template <typename Aggregate, std::size_t kCount = 0>
constexpr std::size_t count_members() {
  if constexpr (takes<Aggregate>(std::make_index_sequence<kCount + 1>{})) {
    return count_members<Aggregate, kCount + 1>();
  } else {
    return kCount;
  }
}

std::size_t count_keys(const std::string& prefix) {
  std::size_t count = 0;
  for (const PipelineOption& option : pipeline_option_table()) {
    if (std::string(option.key).compare(0, prefix.size(), prefix) == 0) ++count;
  }
  return count;
}

const PipelineOption& option_named(const std::string& key) {
  for (const PipelineOption& option : pipeline_option_table()) {
    if (option.key == key) return option;
  }
  ADD_FAILURE() << "no option " << key;
  return pipeline_option_table().front();
}

/// Another value of this option, in its range or not.
void change(const PipelineOption& option, PipelineOptions* options) {
  if (const auto* choice = std::get_if<ChoiceOption>(&option.value)) {
    choice->set(*options, (choice->get(*options) + 1) % static_cast<int>(choice->names.size()));
    return;
  }
  if (const auto* names = std::get_if<NamesOption>(&option.value)) {
    names->field(*options).emplace_back("dog");
    return;
  }
  std::visit(
      [options](const auto& value) {
        if constexpr (!std::is_same_v<std::decay_t<decltype(value)>, NamesOption> &&
                      !std::is_same_v<std::decay_t<decltype(value)>, ChoiceOption>) {
          auto& field = value.field(*options);
          field = static_cast<std::decay_t<decltype(field)>>(field + 1);
        }
      },
      option.value);
}

class ConfigFile : public testing::Test {
 protected:
  FileStatus read(const std::string& text) {
    write_text(path_, text);
    return read_pipeline_config(path_, &options_);
  }

  void expect_refused(const std::string& text, std::size_t line, const std::string& reason_part) {
    const PipelineOptions before = options_;
    const FileStatus status = read(text);
    EXPECT_FALSE(status.ok()) << text;
    EXPECT_EQ(status.file, path_);
    EXPECT_EQ(status.line, line) << status.message();
    EXPECT_NE(status.reason.find(reason_part), std::string::npos)
        << "expected '" << reason_part << "' in: " << status.message();
    EXPECT_EQ(config_file_text(options_), config_file_text(before)) << "changed by a refused file";
  }

  TempFolder folder_;
  std::string path_ = folder_ / "config.yaml";
  PipelineOptions options_;
};

TEST(PipelineOptionTable, HoldsEveryFieldOfTheOptions) {
  const char* message = "a field was added or removed: pipeline_option_table() must follow";
  EXPECT_EQ(count_keys("features."), count_members<FeatureOptions>()) << message;
  EXPECT_EQ(count_keys("tracking."), count_members<TrackingOptions>()) << message;
  EXPECT_EQ(count_keys("keyframes."), count_members<KeyframeOptions>()) << message;
  EXPECT_EQ(count_keys("mapping."), count_members<MappingOptions>()) << message;
  // The six groups and num_threads.
  EXPECT_EQ(count_members<PipelineOptions>(), 7U) << message;
  // Of modules S and D those that somebody who runs the program has a use for.
  EXPECT_EQ(count_keys("scene."), scene_option_table().size());
  EXPECT_EQ(count_keys("culling."), culling_option_table().size());
  EXPECT_EQ(pipeline_option_table().size(),
            count_members<FeatureOptions>() + count_members<TrackingOptions>() +
                count_members<KeyframeOptions>() + count_members<MappingOptions>() +
                scene_option_table().size() + culling_option_table().size() + 1)
      << message;
}

TEST(PipelineOptionTable, KeysAreUniqueAndExplained) {
  std::set<std::string> keys;
  for (const PipelineOption& option : pipeline_option_table()) {
    EXPECT_TRUE(keys.insert(option.key).second) << option.key << " occurs twice";
    EXPECT_GT(std::string(option.meaning).size(), 10U) << option.key;
  }
}

TEST(PipelineOptionTable, EveryKeyLeadsToAFieldOfItsOwn) {
  // A slip in an accessor would let two keys share a field: then setting one changes two values.
  for (const PipelineOption& option : pipeline_option_table()) {
    PipelineOptions options;
    change(option, &options);
    for (const PipelineOption& other : pipeline_option_table()) {
      const bool changed = value_text(other, options) != value_text(other, {});
      EXPECT_EQ(changed, &other == &option) << option.key << " and " << other.key;
    }
  }
}

TEST_F(ConfigFile, ChoicesAreReadByName) {
  ASSERT_TRUE(read("scene.factor: rational\nscene.compensation: none\n").ok());
  EXPECT_EQ(options_.scene.assessor.factor, ResidualFactorForm::kRational);
  EXPECT_EQ(options_.scene.assessor.residual.compensation, MotionCompensation::kNone);
  expect_refused("num_threads: 1\nscene.factor: steep\n", 2,
                 "expected one of exponential, rational, clip, linear, literal");
}

TEST_F(ConfigFile, ListsOfNamesAreReadAndWritten) {
  ASSERT_TRUE(read("culling.classes: person, teddy bear\n").ok());
  EXPECT_EQ(options_.culling.regions.classes, (std::vector<std::string>{"person", "teddy bear"}));
  EXPECT_EQ(value_text(option_named("culling.classes"), options_), "person,teddy bear");
  expect_refused("culling.classes: person,,dog\n", 1, "has an empty name");
  ASSERT_TRUE(read("culling.classes: movable\nculling.depth_test: on\n").ok());
  EXPECT_TRUE(options_.culling.regions.classes.empty());
  EXPECT_TRUE(options_.culling.regions.use_depth);
}

TEST(PipelineOptionTable, DefaultsLieInTheRanges) {
  for (const PipelineOption& option : pipeline_option_table()) {
    TempFolder folder;
    const std::string path = folder / "one.yaml";
    write_text(path, std::string(option.key) + ": " + value_text(option, {}) + "\n");
    PipelineOptions options;
    const FileStatus status = read_pipeline_config(path, &options);
    EXPECT_TRUE(status.ok()) << status.message();
  }
}

TEST_F(ConfigFile, SetsWhatItNamesAndNothingElse) {
  const FileStatus status = read(
      "# fewer features\n"
      "features.num_features: 750\n"
      "\n"
      "tracking.max_depth_m: 4.5   # a small room\r\n"
      "num_threads: 1\n");
  ASSERT_TRUE(status.ok()) << status.message();
  PipelineOptions expected;
  expected.features.num_features = 750;
  expected.tracking.max_depth_m = 4.5;
  expected.num_threads = 1;
  EXPECT_EQ(config_file_text(options_), config_file_text(expected));
  EXPECT_EQ(options_.features.num_features, 750);
  EXPECT_EQ(options_.tracking.max_depth_m, 4.5);
}

TEST_F(ConfigFile, WhatIsWrittenIsReadBackExactly) {
  PipelineOptions written;
  written.features.scale_factor = 1.1 + 1e-13;
  written.tracking.min_depth_m = 1.0 / 3.0;
  written.tracking.seed = 123456789;
  written.keyframes.weak_ratio = 0.1;
  written.mapping.window_size = 17;
  const FileStatus status = read(config_file_text(written));
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(options_.features.scale_factor, written.features.scale_factor);
  EXPECT_EQ(options_.tracking.min_depth_m, written.tracking.min_depth_m);
  EXPECT_EQ(options_.tracking.seed, written.tracking.seed);
  EXPECT_EQ(options_.keyframes.weak_ratio, written.keyframes.weak_ratio);
  EXPECT_EQ(options_.mapping.window_size, written.mapping.window_size);
  EXPECT_EQ(config_hash(options_), config_hash(written));
}

TEST_F(ConfigFile, AnEmptyFileKeepsTheDefaults) {
  ASSERT_TRUE(read("# nothing\n").ok());
  EXPECT_EQ(config_file_text(options_), config_file_text({}));
}

TEST_F(ConfigFile, RefusesAMissingFile) {
  const FileStatus status = read_pipeline_config(folder_ / "absent.yaml", &options_);
  EXPECT_EQ(to_string(status.code), std::string("not_found"));
  EXPECT_EQ(status.file, folder_ / "absent.yaml");
}

TEST_F(ConfigFile, RefusesAnUnknownKeyAndListsTheKnownOnes) {
  expect_refused("num_threads: 1\nfeatures.number: 5\n", 2, "features.number");
  expect_refused("num_features: 500\n", 1, "features.num_features, features.num_levels");
}

TEST_F(ConfigFile, RefusesAnotherType) {
  expect_refused("num_threads: 1\n\nfeatures.num_features: many\n", 3, "whole number");
  expect_refused("features.num_features: 1e3\n", 1, "whole number");
  expect_refused("features.num_features: 800.0\n", 1, "whole number");
  expect_refused("features.scale_factor: big\n", 1, "decimal number");
  expect_refused("features.scale_factor: nan\n", 1, "decimal number");
  expect_refused("tracking.seed: 1.5\n", 1, "whole number");
}

TEST_F(ConfigFile, RefusesValuesOutOfRangeAndSaysTheRange) {
  expect_refused("features.num_features: 10\n", 1, "expected 50 to 20000");
  expect_refused("features.num_levels: 13\n", 1, "expected 1 to 12");
  expect_refused("keyframes.weak_ratio: 0\n", 1, "expected above 0 to 1");
  expect_refused("keyframes.weak_ratio: 1.01\n", 1, "expected above 0 to 1");
  expect_refused("tracking.min_depth_m: -0.1\n", 1, "expected 0 to 1000");
  expect_refused("tracking.seed: -1\n", 1, "expected 0 to 2147483647");
  expect_refused("num_threads: 3\n", 1, "expected 1 to 2");
}

TEST_F(ConfigFile, RefusesValuesThatContradictEachOther) {
  expect_refused("tracking.min_depth_m: 5\ntracking.max_depth_m: 4\n", 0, "min_depth_m");
  expect_refused("features.fast_threshold: 5\n", 0, "min_fast_threshold");
}

TEST_F(ConfigFile, RefusesRepeatedKeysAndOtherYaml) {
  expect_refused("num_threads: 1\nnum_threads: 2\n", 2, "already given on line 1");
  expect_refused("features:\n  num_features: 500\n", 1, "no value");
  expect_refused("num_threads\n", 1, "key: value");
}

TEST_F(ConfigFile, RefusesWhatThePipelineRefuses) {
  // The table's ranges may be narrower than the pipeline's, never wider.
  for (const PipelineOption& option : pipeline_option_table()) {
    const auto check = [&](const auto& limits, auto value) {
      PipelineOptions options;
      auto& field = limits.field(options);
      field = static_cast<std::decay_t<decltype(field)>>(value);
      const Status valid = options.validate();
      const std::string reason = valid.reason;
      // Bounds that follow from another option are not the table's business.
      if (!valid.ok() && reason.find("at least tracking.") == std::string::npos &&
          reason.find("1..fast_threshold") == std::string::npos &&
          reason.find("min_depth_m < max_depth_m") == std::string::npos &&
          reason.find("must not be below min_age_frames") == std::string::npos &&
          reason.find("depth thresholds must be") == std::string::npos) {
        ADD_FAILURE() << option.key << " = " << value << ": " << reason;
      }
    };
    if (const auto* whole = std::get_if<IntOption>(&option.value)) {
      check(*whole, whole->min);
      check(*whole, whole->max);
    } else if (const auto* real = std::get_if<RealOption>(&option.value)) {
      check(*real, real->min_is_exclusive ? real->min + 1e-12 : real->min);
      check(*real, real->max);
    }
  }
}

TEST(ConfigHash, IsStableAndFollowsWhatCanChangeTheResult) {
  const std::string hash = config_hash({});
  EXPECT_EQ(hash.size(), 16U);
  EXPECT_EQ(hash.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_EQ(config_hash({}), hash);
  std::set<std::string> hashes = {hash};
  for (const PipelineOption& option : pipeline_option_table()) {
    PipelineOptions options;
    change(option, &options);
    if (option.affects_result) {
      EXPECT_TRUE(hashes.insert(config_hash(options)).second) << option.key;
    } else {
      EXPECT_EQ(config_hash(options), hash) << option.key;
    }
  }
}

TEST(ConfigHash, ThreadsAloneDoNotAffectTheResult) {
  for (const PipelineOption& option : pipeline_option_table()) {
    EXPECT_EQ(option.affects_result, std::string(option.key) != "num_threads") << option.key;
  }
}

TEST(OptionTableText, ShowsEveryOptionWithItsValue) {
  PipelineOptions options;
  options.features.num_features = 777;
  const std::string table = option_table_text(options);
  for (const PipelineOption& option : pipeline_option_table()) {
    EXPECT_NE(table.find("`" + std::string(option.key) + "`"), std::string::npos) << option.key;
    EXPECT_NE(table.find(option.meaning), std::string::npos) << option.key;
  }
  EXPECT_NE(table.find("| 777 "), std::string::npos);
  EXPECT_EQ(value_text(option_named("features.num_features"), options), "777");
}

}  // namespace
}  // namespace srslam::cli
