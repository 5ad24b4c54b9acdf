// The small parts that a run writes its files and its progress with.

#include <gtest/gtest.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill() is POSIX, not <csignal>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "cli/child_process.hpp"
#include "cli/frame_record.hpp"
#include "cli/number_text.hpp"
#include "cli/progress_line.hpp"
#include "cli/text_file.hpp"
#include "support/io_test_dataset.hpp"
#include "support/rng.hpp"

namespace srslam::cli {
namespace {

using srslam::test::read_text;
using srslam::test::TempFolder;

TEST(NumberText, ShortestTextReadsBackExactly) {
  EXPECT_EQ(shortest_text(0.1), "0.1");
  EXPECT_EQ(shortest_text(5000.0), "5000");
  EXPECT_EQ(shortest_text(-2.5e-9), "-2.5e-09");
  srslam::test::for_each_seed(200, [](srslam::test::Rng& rng) {
    const double value = rng.uniform(-1.0, 1.0) * std::pow(10.0, rng.uniform_int(-12, 12));
    EXPECT_EQ(std::stod(shortest_text(value)), value);
  });
}

TEST(NumberText, FixedTextHasItsDecimals) {
  EXPECT_EQ(fixed_text(1.25, 1), "1.2");
  EXPECT_EQ(fixed_text(1548339819.87426, 6), "1548339819.874260");
  EXPECT_EQ(fixed_text(-0.5, 3), "-0.500");
  EXPECT_EQ(fixed_text(std::numeric_limits<double>::quiet_NaN(), 3), "n/a");
  EXPECT_EQ(fixed_text(std::numeric_limits<double>::infinity(), 3), "n/a");
}

TEST(TextFile, ReplacesAsAWholeAndLeavesNothingBehind) {
  const TempFolder folder;
  const std::string path = folder / "file.txt";
  for (const std::string& text : {std::string("first\n"), std::string(300000, 'x')}) {
    const FileStatus status = write_file_atomically(path, text);
    ASSERT_TRUE(status.ok()) << status.message();
    EXPECT_EQ(read_text(path), text);
  }
  const FileStatus refused = write_file_atomically(folder / "absent/file.txt", "text");
  EXPECT_EQ(refused.code, StatusCode::kIoError);
  EXPECT_EQ(refused.file, folder / "absent/file.txt");
  // A folder cannot be replaced by a file.
  std::filesystem::create_directory(folder / "taken");
  EXPECT_FALSE(write_file_atomically(folder / "taken", "text").ok());
  std::size_t num_entries = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    EXPECT_NE(entry.path().filename().string().front(), '.') << entry.path();
    ++num_entries;
  }
  EXPECT_EQ(num_entries, 2U);
}

TEST(FramesCsv, EveryLineHasTheFieldsOfTheHeader) {
  const auto num_fields = [](const std::string& line) {
    std::size_t count = 1;
    bool quoted = false;
    for (const char character : line) {
      if (character == '"') quoted = !quoted;
      if (character == ',' && !quoted) ++count;
    }
    return count;
  };
  FrameRecord record;
  record.index = 3;
  record.timestamp_s = 1548339819.87426;
  record.outcome = FrameOutcome::kDamaged;
  const std::string header = frames_csv_header();
  const std::string damaged = frames_csv_line(record, nullptr, "rgb/3.png: truncated, at \"IDAT\"");
  EXPECT_EQ(num_fields(damaged), num_fields(header)) << damaged;
  EXPECT_EQ(damaged.find("3,1548339819.874260,DAMAGED,"), 0U) << damaged;
  EXPECT_NE(damaged.find("\"rgb/3.png: truncated, at \"\"IDAT\"\"\"\n"), std::string::npos)
      << damaged;
  PipelineResult result;
  result.num_inliers = 432;
  result.keyframe_reason = "weak, and the mapper is idle";
  record.outcome = FrameOutcome::kTracked;
  record.times.total_ms = 12.3456;
  const std::string tracked = frames_csv_line(record, &result, {});
  EXPECT_EQ(num_fields(tracked), num_fields(header)) << tracked;
  EXPECT_NE(tracked.find(",432,"), std::string::npos) << tracked;
  EXPECT_NE(tracked.find(",\"weak, and the mapper is idle\","), std::string::npos) << tracked;
  EXPECT_NE(tracked.find(",12.346,\n"), std::string::npos) << tracked;

  result.has_scene = true;
  result.has_culling = true;
  result.culling.removal.branch = CullingBranch::kSparing;
  result.culling.removal.num_removed = 87;
  result.culling.num_restored = 5;
  result.culling.regions.epipolar = SkippedTest::kNoParallax;
  const std::string culled = frames_csv_line(record, &result, {});
  EXPECT_EQ(num_fields(culled), num_fields(header)) << culled;
  EXPECT_NE(culled.find(",sparing,0,"), std::string::npos) << culled;
  EXPECT_NE(culled.find(",87,5,no parallax,turned off,"), std::string::npos) << culled;
}

TEST(FramesCsv, EveryOutcomeHasANameOfItsOwn) {
  std::string seen;
  for (std::size_t i = 0; i < kNumFrameOutcomes; ++i) {
    const std::string name = to_string(static_cast<FrameOutcome>(i));
    EXPECT_NE(name, "UNKNOWN") << i;
    EXPECT_EQ(seen.find("," + name + ","), std::string::npos) << name;
    seen += "," + name + ",";
  }
}

TEST(ProgressText, SaysFrameRateAndState) {
  EXPECT_EQ(progress_text(30, 400, 0.5, "TRACKED"), "frame 30/400  60.0 frames/s  TRACKED");
  EXPECT_EQ(progress_text(0, 400, 0.0, "LOST"), "frame 0/400  0.0 frames/s  LOST");
}

TEST(ChildProcess, TellsHowItEnded) {
  const TempFolder folder;
  const std::string log = folder / "log.txt";
  const auto run = [&](const std::vector<std::string>& arguments, double timeout_s = 30.0) {
    return run_child_process(arguments, folder.path(), log, timeout_s);
  };
  EXPECT_EQ(run({"true"}), "");
  EXPECT_EQ(run({"sh", "-c", "exit 7"}), "sh ended with code 7");
  EXPECT_EQ(run({"sh", "-c", "kill -9 $$"}), "sh was ended by signal 9");
  EXPECT_EQ(run({"no_such_program_anywhere"}),
            "no_such_program_anywhere cannot be started: No such file or directory");
  EXPECT_EQ(run({"sleep", "30"}, 0.2), "sleep did not end within 0.2 s");
  // Arguments reach the program as they are, and it works in the folder that was given.
  EXPECT_EQ(run({"printf", "%s", "$(touch x); `touch y`"}), "");
  EXPECT_EQ(read_text(log), "$(touch x); `touch y`");
  EXPECT_EQ(run({"touch", "here"}), "");
  EXPECT_TRUE(std::filesystem::exists(folder / "here"));
  EXPECT_FALSE(std::filesystem::exists(folder / "x"));
}

TEST(ChildProcess, EndsWithTheProcessThatStartedIt) {
  const TempFolder folder;
  const pid_t parent = fork();
  if (parent == 0) {
    ChildProcess child;
    child.start({"sh", "-c", "echo $$ > id && mv id started && exec sleep 60"}, folder.path(),
                folder / "log.txt");
    pause();
    _exit(0);
  }
  const auto wait_until = [](const auto& holds) {
    for (int i = 0; i < 2000 && !holds(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return holds();
  };
  ASSERT_TRUE(wait_until([&] { return std::filesystem::exists(folder / "started"); }));
  const std::string id = std::to_string(std::stoi(read_text(folder / "started")));
  ASSERT_EQ(kill(parent, SIGKILL), 0);
  ASSERT_EQ(waitpid(parent, nullptr, 0), parent);
  // A process that nobody has waited for yet is still listed, but runs no program.
  EXPECT_TRUE(wait_until([&] {
    std::ifstream command("/proc/" + id + "/cmdline");
    return !command || command.peek() == std::ifstream::traits_type::eof();
  }));
}

}  // namespace
}  // namespace srslam::cli
