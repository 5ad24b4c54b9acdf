// `srslam evaluate`, `srslam options` and the top level of the program as their users start them.

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/pipeline_config.hpp"
#include "srslam/evaluation/trajectory_error.hpp"
#include "srslam/io/trajectory_file.hpp"
#include "srslam/version.hpp"
#include "support/cli_test_support.hpp"
#include "support/io_test_dataset.hpp"
#include "support/rng.hpp"

namespace srslam::test {
namespace {

using Json = nlohmann::json;

class CliEvaluate : public testing::Test {
 protected:
  void SetUp() override {
    if (program_path().empty()) {
      GTEST_SKIP() << "set SRSLAM_PROGRAM to the program srslam to run this test";
    }
    Rng rng(20240611);
    for (int i = 0; i < 120; ++i) {
      const double t = i / 30.0;
      Pose T_world_camera = Pose::Identity();
      T_world_camera.translation() =
          Eigen::Vector3d(std::sin(t), 0.5 * std::sin(2.1 * t), 0.2 * std::cos(0.7 * t));
      T_world_camera.linear() =
          Eigen::AngleAxisd(0.3 * std::sin(t), Eigen::Vector3d::UnitY()).toRotationMatrix();
      groundtruth_.push_back({1000.0 + t, T_world_camera});
      Pose T_noisy = T_world_camera;
      T_noisy.translation() += rng.vector3(-0.01, 0.01);
      if (i % 10 != 3) estimate_.push_back({1000.0 + t + 0.002, T_noisy});
    }
    groundtruth_file_ = write("groundtruth.txt", groundtruth_);
    estimate_file_ = write("estimate.txt", estimate_);
    // As read back: files keep nine decimals.
    ASSERT_TRUE(read_trajectory(groundtruth_file_, &groundtruth_).ok());
    ASSERT_TRUE(read_trajectory(estimate_file_, &estimate_).ok());
  }

  std::string write(const std::string& name, const Trajectory& trajectory) const {
    const FileStatus status = write_trajectory(folder_ / name, trajectory, "");
    EXPECT_TRUE(status.ok()) << status.message();
    return folder_ / name;
  }

  ProgramResult evaluate(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "evaluate");
    return run_program(arguments, folder_.path());
  }

  Json evaluate_json(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(),
                     {"--groundtruth", groundtruth_file_, "--estimate", estimate_file_, "--json"});
    const ProgramResult result = evaluate(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    Json json = Json::parse(result.out, nullptr, false);
    EXPECT_FALSE(json.is_discarded()) << result.out;
    return json;
  }

  TempFolder folder_;
  Trajectory groundtruth_;
  Trajectory estimate_;
  std::string groundtruth_file_;
  std::string estimate_file_;
};

void expect_statistics(const Json& json, const ErrorStatistics& expected) {
  EXPECT_EQ(json["rmse"], expected.rmse);
  EXPECT_EQ(json["mean"], expected.mean);
  EXPECT_EQ(json["median"], expected.median);
  EXPECT_EQ(json["std"], expected.std);
  EXPECT_EQ(json["min"], expected.min);
  EXPECT_EQ(json["max"], expected.max);
}

TEST_F(CliEvaluate, JsonHoldsWhatTheLibraryComputes) {
  const Json json = evaluate_json({});
  const AteResult ate = absolute_trajectory_error(groundtruth_, estimate_);
  expect_statistics(json["ate"]["translation_m"], ate.translation_m);
  EXPECT_EQ(json["ate"]["num_matched"], 108);
  EXPECT_EQ(json["ate"]["num_estimate"], 108);
  EXPECT_EQ(json["ate"]["num_groundtruth"], 120);
  EXPECT_EQ(json["ate"]["alignment"], "SE3");
  EXPECT_EQ(json["ate"]["fixed_camera"], false);
  EXPECT_NEAR(json["ate"]["max_time_difference_s"].get<double>(), 0.002, 1e-6);
  RpeOptions options;
  expect_statistics(json["rpe_1_frame"]["rotation_deg"],
                    relative_pose_error(groundtruth_, estimate_, options).rotation_deg);
  options.unit = RpeDelta::kSeconds;
  expect_statistics(json["rpe_1_s"]["translation_m"],
                    relative_pose_error(groundtruth_, estimate_, options).translation_m);
  EXPECT_EQ(json["rpe_1_s"]["delta_unit"], "seconds");
  EXPECT_EQ(json["rpe_1_s"]["definition"], "matched_poses");
}

TEST_F(CliEvaluate, TablesStateWhatTheFiguresMean) {
  const ProgramResult result =
      evaluate({"--groundtruth", groundtruth_file_, "--estimate", estimate_file_});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* part :
       {"alignment SE3", "108 of 108 estimated poses matched", "ground truth: 120 poses",
        "largest time difference 2.0 ms", "over 1 frame", "over 1 s", "rmse", "median", "std",
        "translation [m]", "rotation [deg]", "camera poses as published", "107 pairs"}) {
    EXPECT_NE(result.out.find(part), std::string::npos) << part << " is not in: " << result.out;
  }
}

TEST_F(CliEvaluate, OptionsReachTheEvaluation) {
  // The estimate's stamps are 2 ms late.
  EXPECT_NEAR(evaluate_json({"--offset", "-0.002"})["ate"]["max_time_difference_s"].get<double>(),
              0.0, 1e-6);
  const ProgramResult strict = evaluate({"--groundtruth", groundtruth_file_, "--estimate",
                                         estimate_file_, "--max-time-difference", "0.001"});
  EXPECT_EQ(strict.exit_code, 1);
  EXPECT_TRUE(strict.says("max_time_difference_s")) << strict.err;

  Trajectory halved = estimate_;
  for (StampedPose& pose : halved) pose.T_world_camera.translation() *= 0.5;
  estimate_file_ = write("halved.txt", halved);
  const Json scaled = evaluate_json({"--scale"});
  EXPECT_EQ(scaled["ate"]["alignment"], "Sim3");
  EXPECT_NEAR(scaled["ate"]["scale"].get<double>(), 2.0, 0.01);
  EXPECT_LT(scaled["ate"]["translation_m"]["rmse"], 0.02);
  EXPECT_GT(evaluate_json({})["ate"]["translation_m"]["rmse"], 0.1);

  const Json tool = evaluate_json({"--rpe", "tum_tool"});
  EXPECT_EQ(tool["rpe_1_s"]["definition"], "tum_tool");
  const Json marker = evaluate_json({"--groundtruth-frame", "bonn_marker"});
  EXPECT_EQ(marker["ate"]["groundtruth"], "bonn_marker poses as published");
  EXPECT_EQ(marker["rpe_1_s"]["groundtruth"], "camera poses converted from bonn_marker");
}

TEST_F(CliEvaluate, TooFewMatchesAreRefused) {
  estimate_.resize(2);
  const ProgramResult result = evaluate(
      {"--groundtruth", groundtruth_file_, "--estimate", write("two.txt", estimate_), "--json"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(result.says("at least three matched poses")) << result.err;
  const Json json = Json::parse(result.out, nullptr, false);
  ASSERT_FALSE(json.is_discarded()) << result.out;
  EXPECT_EQ(json["ate"]["status"], "insufficient_data");
  EXPECT_EQ(json["ate"]["num_matched"], 2);
  EXPECT_FALSE(json["ate"].contains("translation_m"));
}

TEST_F(CliEvaluate, AFixedCameraIsToldSo) {
  Trajectory still = groundtruth_;
  for (StampedPose& pose : still) pose.T_world_camera = Pose::Identity();
  const ProgramResult result =
      evaluate({"--groundtruth", write("still.txt", still), "--estimate", estimate_file_});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(result.says("the camera is fixed")) << result.out;
}

TEST_F(CliEvaluate, BadFilesAreNamedWithTheirLine) {
  const ProgramResult absent =
      evaluate({"--groundtruth", "absent.txt", "--estimate", estimate_file_});
  EXPECT_EQ(absent.exit_code, 2);
  EXPECT_TRUE(absent.says("absent.txt")) << absent.err;
  write_text(folder_ / "bad.txt", "# poses\n1000.0 0 0 0 0 0 0 1\n1000.1 0 0 nan 0 0 0 1\n");
  const ProgramResult bad = evaluate({"--groundtruth", groundtruth_file_, "--estimate", "bad.txt"});
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_TRUE(bad.says("bad.txt:3:")) << bad.err;
}

TEST_F(CliEvaluate, RepeatedGroundTruthStampsAreDroppedAndSaid) {
  const std::string text = read_text(groundtruth_file_);
  const std::string last_line = text.substr(text.rfind('\n', text.size() - 2) + 1);
  write_text(groundtruth_file_, text + last_line);
  const ProgramResult result =
      evaluate({"--groundtruth", groundtruth_file_, "--estimate", estimate_file_});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(result.says("1 lines with a repeated time stamp")) << result.err;
}

TEST_F(CliEvaluate, UsageErrorsHaveTheirCode) {
  const std::vector<std::string> files = {"--groundtruth", groundtruth_file_, "--estimate",
                                          estimate_file_};
  for (const std::vector<std::string>& extra :
       std::vector<std::vector<std::string>>{{"--max-time-difference", "-1"},
                                             {"--max-time-difference", "soon"},
                                             {"--rpe", "mine"},
                                             {"--groundtruth-frame", "imu"},
                                             {"--unknown"},
                                             {"positional"}}) {
    std::vector<std::string> arguments = files;
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    const ProgramResult result = evaluate(arguments);
    EXPECT_EQ(result.exit_code, 2) << extra.front() << ": " << result.err;
    EXPECT_FALSE(result.err.empty()) << extra.front();
  }
  EXPECT_EQ(evaluate({"--estimate", estimate_file_}).exit_code, 2);
}

TEST_F(CliEvaluate, GivesThePublishedFiguresOfRealTrajectories) {
  const std::string folder = real_slice("trajectories");
  if (folder.empty()) GTEST_SKIP() << skip_reason("trajectories");
  groundtruth_file_ = folder + "/fr1_xyz_groundtruth.txt";
  estimate_file_ = folder + "/fr1_xyz_rgbdslam.txt";
  const Json expected = Json::parse(read_text(folder + "/expected.json"))["fr1_xyz_rgbdslam"];
  const Json json = evaluate_json({"--rpe", "tum_tool"});
  const auto expect_printed = [](const Json& value, const Json& printed) {
    EXPECT_NEAR(value.get<double>(), printed.get<double>(), 0.51e-6);
  };
  for (const char* statistic : {"rmse", "mean", "median", "std", "min", "max"}) {
    const std::string name = statistic;
    expect_printed(json["ate"]["translation_m"][name],
                   expected["ate"]["absolute_translational_error." + name]);
    expect_printed(json["rpe_1_s"]["translation_m"][name],
                   expected["rpe_1s"]["translational_error." + name]);
    expect_printed(json["rpe_1_frame"]["rotation_deg"][name],
                   expected["rpe_1frame"]["rotational_error." + name]);
  }
}

class CliProgram : public testing::Test {
 protected:
  void SetUp() override {
    if (program_path().empty()) {
      GTEST_SKIP() << "set SRSLAM_PROGRAM to the program srslam to run this test";
    }
  }
  TempFolder folder_;
};

TEST_F(CliProgram, HelpAndVersionAreSuccesses) {
  const ProgramResult version = run_program({"--version"}, folder_.path());
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_EQ(version.out, std::string("srslam ") + SRSLAM_VERSION_STRING + "\n");
  const ProgramResult help = run_program({"--help"}, folder_.path());
  EXPECT_EQ(help.exit_code, 0);
  for (const char* command : {"run", "evaluate", "options"}) {
    EXPECT_NE(help.out.find(command), std::string::npos) << help.out;
  }
  const ProgramResult run_help = run_program({"run", "--help"}, folder_.path());
  EXPECT_EQ(run_help.exit_code, 0);
  for (const char* part : {"--dataset", "--camera", "tum_fr1", "--modules", "not built yet"}) {
    EXPECT_NE(run_help.out.find(part), std::string::npos) << run_help.out;
  }
}

TEST_F(CliProgram, NeedsACommandThatItKnows) {
  EXPECT_EQ(run_program({}, folder_.path()).exit_code, 2);
  EXPECT_EQ(run_program({"fly"}, folder_.path()).exit_code, 2);
  EXPECT_EQ(run_program({"--fast"}, folder_.path()).exit_code, 2);
}

TEST_F(CliProgram, OptionsPrintsTheValuesOfAFile) {
  write_text(folder_ / "config.yaml", "mapping.window_size: 23\n");
  const ProgramResult table = run_program({"options", "--config", "config.yaml"}, folder_.path());
  EXPECT_EQ(table.exit_code, 0) << table.err;
  PipelineOptions options;
  options.mapping.window_size = 23;
  EXPECT_EQ(table.out, cli::option_table_text(options) +
                           "\nConfiguration hash: " + cli::config_hash(options) + "\n");
  const ProgramResult yaml =
      run_program({"options", "--config", "config.yaml", "--yaml"}, folder_.path());
  EXPECT_EQ(yaml.out, cli::config_file_text(options));
  EXPECT_EQ(run_program({"options", "--config", "absent.yaml"}, folder_.path()).exit_code, 2);
}

TEST_F(CliProgram, TheManualShowsTheOptionsAsTheyAre) {
  const std::filesystem::path manual =
      std::filesystem::path(__FILE__).parent_path() / "../../docs/program.md";
  const ProgramResult options = run_program({"options"}, folder_.path());
  ASSERT_EQ(options.exit_code, 0) << options.err;
  const std::string table = options.out.substr(0, options.out.find("\n\n") + 1);
  EXPECT_NE(read_text(manual.string()).find(table), std::string::npos)
      << "docs/program.md must hold the table that `srslam options` prints:\n"
      << table;
}

TEST_F(CliProgram, TheManualNamesEveryOptionOfEveryCommand) {
  const std::filesystem::path docs = std::filesystem::path(__FILE__).parent_path() / "../../docs";
  for (const auto& [command, file] : {std::pair{"run", "program.md"},
                                      {"evaluate", "program.md"},
                                      {"options", "program.md"},
                                      {"campaign", "campaigns.md"}}) {
    const std::string text = read_text((docs / file).string());
    const ProgramResult help = run_program({command, "--help"}, folder_.path());
    std::size_t num_options = 0;
    for (std::size_t at = help.out.find("\n  --"); at != std::string::npos;
         at = help.out.find("\n  --", at + 1)) {
      const std::size_t begin = at + 3;
      const std::string option = help.out.substr(begin, help.out.find(' ', begin) - begin);
      EXPECT_NE(text.find("`" + option), std::string::npos)
          << "docs/" << file << " lacks " << option << " of " << command;
      ++num_options;
    }
    EXPECT_GE(num_options, 2U) << help.out;
  }
}

}  // namespace
}  // namespace srslam::test
