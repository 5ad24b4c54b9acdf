// `srslam campaign` as its users start it: killed, taken up again, spread over jobs.

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "support/cli_test_support.hpp"
#include "support/io_test_dataset.hpp"

namespace srslam::test {
namespace {

namespace fs = std::filesystem;

class CliCampaign : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    data_ = std::make_unique<TempFolder>();
    write_room_dataset(*data_ / "suite/room_a", 6);
    fs::copy(*data_ / "suite/room_a", *data_ / "suite/room_b", fs::copy_options::recursive);
    // The second has frames that can not be read, so that coverage differs too.
    write_text(*data_ / ("suite/room_b/rgb/" + room_timestamp(4) + ".png"), "no picture");
    fs::create_directories(*data_ / "suite/room_c");
    fs::copy_file(*data_ / "suite/room_a/camera.yaml", *data_ / "suite/room_c/camera.yaml");
    write_text(*data_ / "suite/room_c/rgb.txt", "garbage\n");
  }
  static void TearDownTestSuite() { data_.reset(); }

  void SetUp() override {
    if (program_path().empty()) {
      GTEST_SKIP() << "set SRSLAM_PROGRAM to the program srslam to run this test";
    }
  }

  std::vector<std::string> words(const std::string& output, std::vector<std::string> more) const {
    more.insert(more.begin(), {"campaign", "--output", output});
    return more;
  }

  std::vector<std::string> full_words(const std::string& output) const {
    return words(output, {"--suite", *data_ / "suite", "--variants", "baseline", "--repeats", "2",
                          "--max-frames", "5", "--jobs", "2"});
  }

  ProgramResult run(const std::vector<std::string>& arguments) const {
    return run_program(arguments, folder_.path());
  }

  void expect_same_tables(const std::string& a, const std::string& b) const {
    for (const char* file : {"tables.md", "tables.csv", "tables.json"}) {
      EXPECT_EQ(read_text(folder_ / (a + "/" + file)), read_text(folder_ / (b + "/" + file)))
          << file;
    }
  }

  TempFolder folder_;
  static std::unique_ptr<TempFolder> data_;
};

std::unique_ptr<TempFolder> CliCampaign::data_;

TEST_F(CliCampaign, KilledAndTakenUpAgainGivesTheSameTables) {
  const ProgramResult whole = run(full_words("whole"));
  EXPECT_EQ(whole.exit_code, 1) << "room_c fails" << whole.err;
  EXPECT_TRUE(whole.says("jobs: 4 done, 2 failed, 0 missing")) << whole.out;
  const std::string tables = read_text(folder_ / "whole/tables.md");
  EXPECT_NE(tables.find("| 005_room_c_baseline_r1 | run ended with code 2: "), std::string::npos)
      << tables;
  EXPECT_NE(tables.find("| room_b | 0."), std::string::npos) << tables;
  EXPECT_NE(tables.find(" †"), std::string::npos) << "room_b lost a frame" << tables;

  const unsigned seed = std::random_device()();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 generator(seed);
  std::uniform_int_distribution<int> delay_ms(20, 700);
  for (int i = 0; i < 4; ++i) {
    Program killed(full_words("killed"), folder_.path());
    std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms(generator)));
    killed.send(SIGKILL);
    killed.wait();
  }
  EXPECT_EQ(run(full_words("killed")).exit_code, 1);
  expect_same_tables("whole", "killed");
  EXPECT_TRUE(fs::exists(folder_ / "killed/report.html"));
  for (const auto& entry : fs::directory_iterator(folder_ / "killed/jobs")) {
    EXPECT_NE(entry.path().filename().string().front(), '.') << "abandoned work is removed";
  }
}

TEST_F(CliCampaign, PlanJobsAndMergeGiveTheSameTables) {
  run(full_words("whole"));
  std::vector<std::string> plan = full_words("split");
  plan.emplace_back("--plan");
  const ProgramResult planned = run(plan);
  EXPECT_EQ(planned.exit_code, 0) << planned.err;
  EXPECT_TRUE(planned.says("6\t006_room_c_baseline_r2\tsrslam run --dataset")) << planned.out;
  EXPECT_FALSE(fs::exists(folder_ / "split/jobs"));
  // Two at once, and one of them twice.
  fs::create_directories(folder_ / "elsewhere");
  for (const char* job : {"6", "3", "2", "1", "4"}) {
    Program other(words(folder_ / "split", {"--job", "2"}), folder_ / "elsewhere");
    EXPECT_EQ(run(words("split", {"--job", job})).exit_code, job == std::string("6") ? 1 : 0);
    EXPECT_EQ(other.wait().exit_code, 0);
  }
  const ProgramResult partial = run(words("split", {"--merge"}));
  EXPECT_EQ(partial.exit_code, 1);
  EXPECT_TRUE(partial.says("job 5 (005_room_c_baseline_r1) has not been run")) << partial.err;
  EXPECT_EQ(run(words("split", {"--job", "5"})).exit_code, 1);
  EXPECT_EQ(run(words("split", {"--merge"})).exit_code, 1);
  expect_same_tables("whole", "split");
}

TEST_F(CliCampaign, EndsWhatItStartedWhenInterrupted) {
  Program program(full_words("out"), folder_.path());
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!fs::exists(folder_ / "out/jobs") && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  program.send(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 130) << result.err;
  for (const auto& entry : fs::directory_iterator(folder_ / "out/jobs")) {
    EXPECT_NE(entry.path().filename().string().front(), '.') << entry.path();
  }
  EXPECT_EQ(run(words("out", {})).exit_code, 1) << "the plan is in the folder";
  EXPECT_TRUE(fs::exists(folder_ / "out/tables.md"));
}

TEST_F(CliCampaign, RefusesWhatDoesNotFit) {
  const auto expect_usage = [&](const std::vector<std::string>& arguments,
                                const std::string& part) {
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(result.says(part)) << "expected '" << part << "' in: " << result.err;
  };
  expect_usage(words("out", {}), "holds no plan.json: give --suite");
  expect_usage(words("out", {"--job", "1"}), "make it with --plan first");
  expect_usage(words("out", {"--suite", "absent"}), "neither synthetic nor a folder");
  expect_usage(words("out", {"--suite", *data_ / "suite", "--variants", "baseline,SP"}),
               "variant 'SP': ");
  EXPECT_FALSE(fs::exists(folder_ / "out")) << "nothing was written";
  const std::vector<std::string> plan =
      words("out", {"--suite", *data_ / "suite", "--variants", "baseline", "--plan"});
  EXPECT_EQ(run(plan).exit_code, 0);
  EXPECT_EQ(run(plan).exit_code, 0) << "again, the same";
  expect_usage(full_words("out"),
               "holds another campaign: repeats: 1 there, 2 now; max_frames: null there, 5 now");
  expect_usage(words("out", {"--repeats", "2"}), "--repeats needs --suite");
  expect_usage(words("out", {"--job", "4"}), "the plan has the jobs 1 to 3");
  std::ofstream(folder_ / "out/config.yaml", std::ios::app) << "";
  write_text(folder_ / "out/config.yaml", "features.num_features: 500\n");
  expect_usage(words("out", {}), "has been changed since the plan was made");
}

}  // namespace
}  // namespace srslam::test
