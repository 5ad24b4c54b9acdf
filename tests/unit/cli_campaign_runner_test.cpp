// Jobs of a campaign as processes, with a shell script in place of the program.

#include "cli/campaign/campaign_runner.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "cli/campaign/campaign_folder.hpp"
#include "support/io_test_dataset.hpp"

namespace srslam::cli {
namespace {

namespace fs = std::filesystem;
using srslam::test::read_text;
using srslam::test::TempFolder;
using srslam::test::write_text;

/// Counts its calls in `calls` and fails, hangs or leaves nothing behind where the sequence says
/// so.
constexpr const char* kScript = R"(#!/bin/sh
here=$(dirname "$0")
echo "$*" >> "$here/calls"
if [ "$1" = synth ]; then
  case "$*" in *broken*) echo "srslam: error: no such world" >&2; exit 2;; esac
  mkdir "$5" && echo done > "$5/rgb.txt"
  exit
fi
case "$3" in
  *bad) echo one; echo "srslam: error: $3/rgb.txt:1: is damaged" >&2; exit 2;;
  *hang) sleep 30;;
  *silent) exit 0;;
  *other) hash=another;;
  *) hash=0123; [ -e "$3" ] || { echo "srslam: error: $3 is not there"; exit 2; };;
esac
cat > "$9/summary.json" <<END
{"config_hash": "$hash", "frames": {"coverage": 1.0}, "timing": {"wall_s": 0.5},
 "evaluation": {"trajectory.txt": {"ate": {"alignment": "SE3", "fixed_camera": true,
                                           "translation_m": {"rmse": 0.25, "std": null}}}}}
END
)";

class Runner : public testing::Test {
 protected:
  void SetUp() override {
    write_text(folder_ / "fake", kScript);
    fs::permissions(folder_ / "fake", fs::perms::owner_all);
    settings_.folder = folder_ / "out";
    settings_.program = folder_ / "fake";
    settings_.num_parallel = 2;
    settings_.quiet = true;
    renderer_ = synthetic_renderer(settings_.program);
    plan_.version = "0.1.0";
    plan_.suite = "here";
    plan_.variants = {{"baseline", "none"}};
    plan_.config_hash = "0123";
  }

  void add_sequence(const std::string& name) {
    fs::create_directories(folder_ / name);
    plan_.sequences.push_back({name, std::nullopt, folder_ / name, ""});
  }

  void add_world(const std::string& name, std::uint32_t seed) {
    CampaignSequence sequence;
    sequence.name = name;
    sequence.seed = seed;
    sequence.folder = "sequences/" + sequence.label();
    plan_.sequences.push_back(sequence);
  }

  void run() {
    CampaignRunner runner(plan_, renderer_, settings_);
    EXPECT_EQ(runner.run(plan_jobs(plan_)), "");
    EXPECT_TRUE(runner.is_finished());
  }

  JobRecord record(std::size_t index) const {
    return read_job_record(job_folder(settings_.folder, plan_jobs(plan_)[index]));
  }

  int num_calls(const std::string& command) const {
    std::ifstream stream(folder_ / "calls");
    int count = 0;
    for (std::string line; std::getline(stream, line);) {
      if (line.rfind(command, 0) == 0) ++count;
    }
    return count;
  }

  /// Names in a folder below the campaign's, hidden ones included.
  std::vector<std::string> names_in(const std::string& name) const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(settings_.folder + "/" + name)) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  TempFolder folder_;
  RunnerSettings settings_;
  SequenceRenderer renderer_;
  CampaignPlan plan_;
};

TEST_F(Runner, KeepsTheFiguresOfEveryJob) {
  add_sequence("one");
  add_sequence("two");
  plan_.num_repeats = 2;
  run();
  EXPECT_EQ(num_calls("run"), 4);
  EXPECT_EQ(names_in("jobs"),
            (std::vector<std::string>{"001_one_baseline_r1", "002_one_baseline_r2",
                                      "003_two_baseline_r1", "004_two_baseline_r2"}));
  const JobRecord result = record(3);
  EXPECT_EQ(result.status, JobStatus::kDone);
  EXPECT_EQ(result.figures, (std::map<std::string, double>{
                                {"ate_rmse_m", 0.25}, {"coverage", 1.0}, {"fixed_camera", 1.0}}));
  EXPECT_EQ(result.times.at("wall_s"), 0.5);
  EXPECT_EQ(result.facts.at("alignment"), "SE3");
  EXPECT_EQ(result.num_parallel, 2U);
}

TEST_F(Runner, RecordsFailuresAndGoesOn) {
  add_sequence("bad");
  add_sequence("silent");
  add_sequence("hang");
  add_sequence("other");
  add_sequence("one");
  settings_.timeout_s = 0.5;
  run();
  EXPECT_EQ(record(0).status, JobStatus::kFailed);
  EXPECT_EQ(record(0).reason,
            "run ended with code 2: " + (folder_ / "bad") + "/rgb.txt:1: is damaged");
  EXPECT_NE(record(1).reason.find("summary.json is missing"), std::string::npos);
  EXPECT_EQ(record(2).reason, "run did not end within 0.5 s");
  EXPECT_NE(record(3).reason.find("config_hash is 'another', the plan's '0123'"),
            std::string::npos);
  EXPECT_EQ(record(4).status, JobStatus::kDone);
}

TEST_F(Runner, RunsOnlyWhatHasNoRecord) {
  add_sequence("one");
  add_sequence("bad");
  add_sequence("two");
  run();
  EXPECT_EQ(num_calls("run"), 3);
  fs::remove_all(job_folder(settings_.folder, plan_jobs(plan_)[2]));
  // A record that was cut off is none.
  write_text(job_folder(settings_.folder, plan_jobs(plan_)[0]) + "/job.json", "{\"status\": \"do");
  run();
  EXPECT_EQ(num_calls("run"), 5);
  EXPECT_EQ(record(0).status, JobStatus::kDone);
  EXPECT_EQ(record(2).status, JobStatus::kDone);
  settings_.retry_failed = true;
  run();
  EXPECT_EQ(num_calls("run"), 6) << "the failed one only";
}

TEST_F(Runner, RendersASequenceOnceBeforeItsRuns) {
  add_world("crowd", 3);
  add_world("broken", 1);
  plan_.num_repeats = 2;
  run();
  EXPECT_EQ(num_calls("synth"), 2);
  EXPECT_EQ(record(0).status, JobStatus::kDone);
  EXPECT_EQ(record(1).status, JobStatus::kDone);
  EXPECT_EQ(record(2).reason,
            "its sequence broken_seed1 was not rendered: synth ended with code 2: no such world");
  EXPECT_EQ(names_in("sequences"), (std::vector<std::string>{"crowd_seed3"}));
  run();
  EXPECT_EQ(num_calls("synth"), 2) << "nothing is left to do";
}

TEST_F(Runner, ReportsAProgramThatCannotBeStarted) {
  add_sequence("one");
  settings_.program = "/absent/srslam";
  run();
  EXPECT_NE(record(0).reason.find("/absent/srslam cannot be started"), std::string::npos);
}

TEST_F(Runner, ReportsAFolderThatCannotBeWritten) {
  add_sequence("one");
  write_text(settings_.folder, "a file\n");
  CampaignRunner runner(plan_, renderer_, settings_);
  EXPECT_NE(runner.run(plan_jobs(plan_)).find("cannot be made"), std::string::npos);
  EXPECT_FALSE(runner.is_finished());
}

TEST(CampaignFolder, IsWorkedInByOneCampaign) {
  const TempFolder folder;
  {
    CampaignLock lock;
    EXPECT_EQ(lock.acquire(folder.path()), "");
    CampaignLock second;
    EXPECT_NE(second.acquire(folder.path())
                  .find("another campaign is at work in " + folder.path() + " (process "),
              std::string::npos);
  }
  CampaignLock third;
  EXPECT_EQ(third.acquire(folder.path()), "");
}

TEST(CampaignFolder, TheFirstToPublishWins) {
  const TempFolder folder;
  std::string work;
  ASSERT_EQ(make_work_folder(folder.path(), "x", &work), "");
  write_text(work + "/a", "first");
  EXPECT_EQ(publish_folder(work, folder / "x", false), "");
  ASSERT_EQ(make_work_folder(folder.path(), "x", &work), "");
  write_text(work + "/a", "second");
  EXPECT_EQ(publish_folder(work, folder / "x", false), "");
  EXPECT_EQ(read_text(folder / "x/a"), "first");
  EXPECT_FALSE(fs::exists(work));
  ASSERT_EQ(make_work_folder(folder.path(), "x", &work), "");
  write_text(work + "/a", "third");
  EXPECT_EQ(publish_folder(work, folder / "x", true), "");
  EXPECT_EQ(read_text(folder / "x/a"), "third");
}

TEST(CampaignFolder, LosesTheWorkOfKilledProcessesOnly) {
  const TempFolder folder;
  const pid_t child = fork();
  if (child == 0) {
    std::string work;
    _exit(make_work_folder(folder.path(), "x", &work).empty() ? 0 : 1);
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  std::string own;
  ASSERT_EQ(make_work_folder(folder.path(), "y", &own), "");
  fs::create_directories(folder / ".running-z-elsewhere-1");
  fs::create_directories(folder / "result");
  remove_abandoned_work(folder.path());
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{fs::path(own).filename().string(),
                                             ".running-z-elsewhere-1", "result"}));
  remove_abandoned_work(folder / "absent");
}

TEST(CampaignRecord, TakesTheErrorsOfALogElseItsEnd) {
  const TempFolder folder;
  const std::string log = folder / "log.txt";
  write_text(log, "a\nsrslam: error: first\nb\nsrslam: error: second\n\n");
  EXPECT_EQ(log_tail(log), "first | second");
  write_text(log, "a\nb\r\nc\nd \n");
  EXPECT_EQ(log_tail(log), "b | c | d");
  EXPECT_EQ(log_tail(folder / "absent"), "");
  write_text(log, std::string(100000, 'x'));
  EXPECT_LT(log_tail(log).size(), 1000U);
}

TEST(CampaignProgress, EstimatesTheEndByMedians) {
  CampaignProgress progress;
  progress.num_jobs = 10;
  EXPECT_EQ(campaign_progress_text(progress), "jobs 0/10  failed 0  running 0  left ?");
  progress.num_done = 3;
  progress.num_failed = 1;
  progress.job_s = {10.0, 12.0, 100.0};
  EXPECT_DOUBLE_EQ(remaining_s(progress), 6 * 12.0);
  progress.num_parallel = 2;
  progress.num_running = 2;
  progress.running_s = 6.0;
  EXPECT_DOUBLE_EQ(remaining_s(progress), (6 * 12.0 - 6.0) / 2.0);
  progress.rendering_s = {30.0};
  progress.num_renderings_left = 1;
  EXPECT_DOUBLE_EQ(remaining_s(progress), (6 * 12.0 + 30.0 - 6.0) / 2.0);
  EXPECT_EQ(campaign_progress_text(progress), "jobs 4/10  failed 1  running 2  left 48 s");
  EXPECT_EQ(duration_text(59.6), "1 min 00 s");
  EXPECT_EQ(duration_text(7384.0), "2 h 03 min");
}

}  // namespace
}  // namespace srslam::cli
