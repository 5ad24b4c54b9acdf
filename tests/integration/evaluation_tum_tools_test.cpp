// The figures that the TUM RGB-D benchmark's own evaluate_ate and evaluate_rpe print for three real
// pairs of trajectories, digit by digit. Needs the development data: see SRSLAM_DATA_DIR below.

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "srslam/evaluation/trajectory_error.hpp"
#include "srslam/io/trajectory_file.hpp"

namespace srslam {
namespace {

/// As the tools print: "%f".
std::string printed(double value) {
  char text[64];
  std::snprintf(text, sizeof(text), "%f", value);
  return text;
}

/// Text between the braces of the object that follows `"key":`, empty when there is none. Enough
/// for a file of nested objects, numbers and strings without braces or quotes.
std::string json_object(const std::string& json, const std::string& key) {
  const std::size_t name = json.find("\"" + key + "\"");
  const std::size_t begin = name == std::string::npos ? name : json.find('{', name);
  if (begin == std::string::npos) return {};
  int depth = 0;
  for (std::size_t i = begin; i < json.size(); ++i) {
    if (json[i] == '{') ++depth;
    if (json[i] == '}' && --depth == 0) return json.substr(begin + 1, i - begin - 1);
  }
  return {};
}

double json_number(const std::string& object, const std::string& key) {
  const std::size_t name = object.find("\"" + key + "\"");
  const std::size_t colon = name == std::string::npos ? name : object.find(':', name);
  if (colon == std::string::npos) {
    ADD_FAILURE() << "the expected figures lack " << key;
    return -1.0;
  }
  return std::strtod(object.c_str() + colon + 1, nullptr);
}

void expect_printed(const ErrorStatistics& statistics, const std::string& expected,
                    const std::string& prefix) {
  const auto figure = [&](const char* name) {
    return printed(json_number(expected, prefix + "." + name));
  };
  EXPECT_EQ(printed(statistics.rmse), figure("rmse")) << prefix;
  EXPECT_EQ(printed(statistics.mean), figure("mean")) << prefix;
  EXPECT_EQ(printed(statistics.median), figure("median")) << prefix;
  EXPECT_EQ(printed(statistics.std), figure("std")) << prefix;
  EXPECT_EQ(printed(statistics.min), figure("min")) << prefix;
  EXPECT_EQ(printed(statistics.max), figure("max")) << prefix;
}

/// One line of the table in docs/evaluation.md: the default definition beside the tool's.
struct DocumentedRpe {
  RpeDelta unit;
  std::size_t num_pairs;
  const char* translation_rmse;
  const char* rotation_rmse;
};

struct Case {
  const char* key;
  const char* groundtruth;
  const char* estimate;
  std::size_t num_repeated_lines;  ///< in the published ground truth
  std::vector<DocumentedRpe> documented;
};

std::vector<Case> cases() {
  return {
      {"fr1_xyz_rgbdslam",
       "fr1_xyz_groundtruth.txt",
       "fr1_xyz_rgbdslam.txt",
       0,
       {{RpeDelta::kFrames, 784, "0.005756", "0.352781"},
        {RpeDelta::kSeconds, 759, "0.021486", "0.932710"}}},
      {"fr2_desk_orb",
       "fr2_desk_groundtruth.txt",
       "fr2_desk_orb.txt",
       1,
       {{RpeDelta::kFrames, 2170, "0.003460", "0.277968"},
        {RpeDelta::kSeconds, 2149, "0.007249", "0.468241"}}},
      {"fr3_walking_halfsphere_orb",
       "fr3_walking_halfsphere_groundtruth.txt",
       "fr3_walking_halfsphere_orb.txt",
       0,
       {{RpeDelta::kFrames, 1017, "0.013999", "0.411161"},
        {RpeDelta::kSeconds, 992, "0.028041", "0.769073"}}},
  };
}

class TumTools : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    const char* data = std::getenv("SRSLAM_DATA_DIR");
    if (data == nullptr || *data == '\0') {
      GTEST_SKIP() << "SRSLAM_DATA_DIR is not set: the folder that holds trajectories/ with the "
                      "real trajectories and expected.json";
    }
    const std::filesystem::path folder = std::filesystem::path(data) / "trajectories";
    if (!std::filesystem::exists(folder / "expected.json")) {
      GTEST_SKIP() << folder << " has no expected.json; SRSLAM_DATA_DIR is not the data folder";
    }
    std::ifstream stream(folder / "expected.json");
    std::stringstream text;
    text << stream.rdbuf();
    expected_ = json_object(text.str(), GetParam().key);
    ASSERT_FALSE(expected_.empty()) << GetParam().key;

    TrajectoryReadOptions options;
    options.keep_last_of_repeated = true;
    std::size_t num_repeated = 0;
    const FileStatus groundtruth = read_trajectory((folder / GetParam().groundtruth).string(),
                                                   &groundtruth_, options, &num_repeated);
    ASSERT_TRUE(groundtruth.ok()) << groundtruth.message();
    EXPECT_EQ(num_repeated, GetParam().num_repeated_lines);
    const FileStatus estimate =
        read_trajectory((folder / GetParam().estimate).string(), &estimate_);
    ASSERT_TRUE(estimate.ok()) << estimate.message();
  }

  RpeResult rpe(RpeDelta unit, RpeDefinition definition) const {
    RpeOptions options;
    options.unit = unit;
    options.definition = definition;
    return relative_pose_error(groundtruth_, estimate_, options);
  }

  std::string expected_;
  Trajectory groundtruth_;
  Trajectory estimate_;
};

TEST_P(TumTools, AbsoluteErrorPrintsTheSameDigits) {
  const std::string expected = json_object(expected_, "ate");
  const AteResult result = absolute_trajectory_error(groundtruth_, estimate_);
  ASSERT_TRUE(result.status.ok()) << result.status.reason;
  EXPECT_EQ(static_cast<double>(result.num_matched), json_number(expected, "compared_pose_pairs"));
  expect_printed(result.translation_m, expected, "absolute_translational_error");
  EXPECT_LT(result.max_abs_time_difference_s, 0.02);
  EXPECT_FALSE(result.collinear);
  EXPECT_FALSE(result.fixed_camera);
}

TEST_P(TumTools, RelativeErrorOfTheToolPrintsTheSameDigits) {
  for (const auto& [unit, key] : {std::make_pair(RpeDelta::kFrames, "rpe_1frame"),
                                  std::make_pair(RpeDelta::kSeconds, "rpe_1s")}) {
    SCOPED_TRACE(key);
    const std::string expected = json_object(expected_, key);
    const RpeResult result = rpe(unit, RpeDefinition::kTumTool);
    ASSERT_TRUE(result.status.ok()) << result.status.reason;
    EXPECT_EQ(static_cast<double>(result.num_pairs), json_number(expected, "compared_pose_pairs"));
    expect_printed(result.translation_m, expected, "translational_error");
    expect_printed(result.rotation_deg, expected, "rotational_error");
  }
}

// So that the table in docs/evaluation.md stays what the program gives; that the definition itself
// is computed rightly is for the property tests.
TEST_P(TumTools, DefaultRelativeErrorIsTheDocumentedOne) {
  for (const DocumentedRpe& documented : GetParam().documented) {
    SCOPED_TRACE(to_string(documented.unit));
    const RpeResult result = rpe(documented.unit, RpeDefinition::kMatchedPoses);
    ASSERT_TRUE(result.status.ok()) << result.status.reason;
    EXPECT_EQ(result.num_pairs, documented.num_pairs);
    EXPECT_EQ(printed(result.translation_m.rmse), documented.translation_rmse);
    EXPECT_EQ(printed(result.rotation_deg.rmse), documented.rotation_rmse);
  }
}

INSTANTIATE_TEST_SUITE_P(Pairs, TumTools, testing::ValuesIn(cases()),
                         [](const testing::TestParamInfo<Case>& pair) {
                           return std::string(pair.param.key);
                         });

}  // namespace
}  // namespace srslam
