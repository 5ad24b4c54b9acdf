// `srslam run` as its users start it, on a small rendered dataset.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "cli/pipeline_config.hpp"
#include "srslam/io/trajectory_file.hpp"
#include "support/cli_test_support.hpp"
#include "support/io_test_dataset.hpp"

namespace srslam::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int kNumFrames = 16;

std::vector<std::string> lines_of(const std::string& file) {
  std::istringstream stream(read_text(file));
  std::vector<std::string> lines;
  std::string line;
  while (std::getline(stream, line)) lines.push_back(line);
  return lines;
}

/// Fields of a CSV line; commas inside quotes belong to a field.
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (const char character : line) {
    if (character == '"') {
      quoted = !quoted;
    } else if (character == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += character;
    }
  }
  return fields;
}

Json json_of(const std::string& file) {
  Json json = Json::parse(read_text(file), nullptr, false);
  EXPECT_FALSE(json.is_discarded()) << file << " is not JSON";
  return json;
}

std::size_t num_poses(const std::string& file) {
  Trajectory trajectory;
  const FileStatus status = read_trajectory(file, &trajectory);
  EXPECT_TRUE(status.ok()) << status.message();
  return trajectory.size();
}

void expect_png(const std::string& file, int width_px, int height_px) {
  const cv::Mat picture = cv::imread(file);
  ASSERT_FALSE(picture.empty()) << file;
  EXPECT_EQ(picture.cols, width_px);
  EXPECT_EQ(picture.rows, height_px);
  // Lines and text on white: neither empty nor filled.
  cv::Mat gray;
  cv::extractChannel(picture, gray, 1);
  const int num_drawn = static_cast<int>(gray.total()) - cv::countNonZero(gray == 255);
  EXPECT_GT(num_drawn, 5000);
  EXPECT_LT(num_drawn, static_cast<int>(gray.total()) / 2);
}

class CliRun : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    room_ = std::make_unique<TempFolder>();
    write_room_dataset(*room_ / "room", kNumFrames);
  }
  static void TearDownTestSuite() { room_.reset(); }

  void SetUp() override {
    if (program_path().empty()) {
      GTEST_SKIP() << "set SRSLAM_PROGRAM to the program srslam to run this test";
    }
  }

  /// A dataset that may be changed: the room's files, images as links.
  std::string copy_of_room(const std::string& name = "copy") const {
    std::string copy = folder_ / name;
    fs::create_directories(copy);
    for (const char* file :
         {"rgb.txt", "depth.txt", "groundtruth.txt", "detections.txt", "camera.yaml"}) {
      fs::copy_file(room() + "/" + file, copy + "/" + file);
    }
    for (const char* images : {"rgb", "depth"}) {
      fs::create_directory_symlink(room() + "/" + images, copy + "/" + images);
    }
    return copy;
  }

  /// The same room seen for `num_frames` frames, back and forth over the rendered ones.
  std::string long_room(int num_frames) const {
    std::string copy = copy_of_room("long");
    fs::remove(copy + "/groundtruth.txt");
    fs::remove(copy + "/detections.txt");
    std::string rgb;
    std::string depth;
    for (int i = 0; i < num_frames; ++i) {
      const int phase = i % (2 * (kNumFrames - 1));
      const int image = phase < kNumFrames ? phase : 2 * (kNumFrames - 1) - phase;
      rgb += room_timestamp(i) + " rgb/" + room_timestamp(image) + ".png\n";
      depth += room_timestamp(i) + " depth/" + room_timestamp(image) + ".png\n";
    }
    write_text(copy + "/rgb.txt", rgb);
    write_text(copy + "/depth.txt", depth);
    return copy;
  }

  ProgramResult run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "run");
    return run_program(arguments, folder_.path());
  }

  void expect_usage_error(const std::vector<std::string>& arguments,
                          const std::vector<std::string>& parts) const {
    std::vector<std::string> words = arguments;
    words.insert(words.end(), {"--output", "refused"});
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    for (const std::string& part : parts) {
      EXPECT_NE(result.err.find(part), std::string::npos)
          << "expected '" << part << "' in: " << result.err;
    }
    EXPECT_FALSE(fs::exists(output("refused"))) << "something was written after a usage error";
  }

  /// Waits until a run has processed frames, at most a minute.
  void wait_for_frames(const std::string& frames_file, std::size_t num_frames) const {
    for (int i = 0; i < 6000; ++i) {
      if (fs::exists(frames_file) && lines_of(frames_file).size() > num_frames) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    FAIL() << frames_file << " does not grow";
  }

  static std::string room() { return *room_ / "room"; }
  std::string output(const std::string& name) const { return folder_ / name; }

  static std::unique_ptr<TempFolder> room_;
  TempFolder folder_;
};
std::unique_ptr<TempFolder> CliRun::room_;

TEST_F(CliRun, TracksTheRoomAndWritesEverything) {
  const ProgramResult result = run({"--dataset", room(), "--output", "out"});
  ASSERT_EQ(result.exit_code, 0) << result.out << result.err;
  const std::string out = output("out");

  // Every frame is tracked, and tracked well: the images are without noise.
  EXPECT_EQ(num_poses(out + "/trajectory.txt"), std::size_t{kNumFrames});
  EXPECT_EQ(num_poses(out + "/trajectory_optimized.txt"), std::size_t{kNumFrames});
  EXPECT_GE(num_poses(out + "/keyframes.txt"), 1U);
  const Json summary = json_of(out + "/summary.json");
  EXPECT_EQ(summary["exit_code"], 0);
  EXPECT_EQ(summary["exit_reason"], "finished");
  EXPECT_EQ(summary["frames"]["tracked"], kNumFrames);
  EXPECT_EQ(summary["frames"]["processed"], kNumFrames);
  EXPECT_EQ(summary["frames"]["lost"], 0);
  EXPECT_EQ(summary["frames"]["coverage"], 1.0);
  for (const char* trajectory : {"trajectory.txt", "trajectory_optimized.txt"}) {
    const Json& errors = summary["evaluation"][trajectory];
    EXPECT_EQ(errors["ate"]["status"], "ok");
    EXPECT_EQ(errors["ate"]["alignment"], "SE3");
    EXPECT_EQ(errors["ate"]["num_matched"], kNumFrames);
    EXPECT_EQ(errors["ate"]["groundtruth"], "camera poses as published");
    EXPECT_LT(errors["ate"]["translation_m"]["rmse"], 0.005);
    EXPECT_EQ(errors["rpe_1_frame"]["num_pairs"], kNumFrames - 1);
    EXPECT_LT(errors["rpe_1_frame"]["translation_m"]["rmse"], 0.005);
    EXPECT_LT(errors["rpe_1_frame"]["rotation_deg"]["rmse"], 0.3);
    // Half a second of frames has no pairs that are one second apart.
    EXPECT_EQ(errors["rpe_1_s"]["status"], "insufficient_data");
    EXPECT_FALSE(errors["rpe_1_s"].contains("translation_m"));
  }
  EXPECT_EQ(summary["association"]["num_color"], kNumFrames);
  EXPECT_EQ(summary["camera"]["depth_units_per_m"], 5000.0);
  EXPECT_EQ(summary["camera"]["width_px"], 320);
  EXPECT_EQ(summary["modules"], "S,D");
  EXPECT_EQ(summary["detections"]["frames"], kNumFrames);
  EXPECT_EQ(summary["detections"]["used_for_masking"], true);
  EXPECT_EQ(summary["first_depth_image"]["plausible"], true);
  EXPECT_EQ(summary["picture"]["written"], true);
  EXPECT_EQ(summary["config_hash"], cli::config_hash({}));
  EXPECT_GT(summary["timing"]["frames_per_s"], 0.0);
  EXPECT_EQ(summary["timing"]["stages"]["total"]["frames"], kNumFrames);
  EXPECT_GT(summary["timing"]["stages"]["total"]["median_ms"], 0.0);
  EXPECT_GE(summary["timing"]["stages"]["total"]["p95_ms"],
            summary["timing"]["stages"]["total"]["median_ms"]);
  EXPECT_GT(summary["timing"]["decode"]["median_ms"], 0.0);
  EXPECT_GT(summary["peak_memory_mib"], 1.0);
  for (const char* library : {"srslam", "eigen", "opencv", "ceres", "compiler"}) {
    EXPECT_FALSE(summary["versions"][library].get<std::string>().empty()) << library;
  }

  // One line a frame, with as many fields as the header.
  const std::vector<std::string> frames = lines_of(out + "/frames.csv");
  ASSERT_EQ(frames.size(), std::size_t{kNumFrames} + 1);
  for (const std::string& line : frames) {
    EXPECT_EQ(fields_of(line).size(), fields_of(frames.front()).size()) << line;
  }
  EXPECT_EQ(fields_of(frames[1])[0], "0");
  EXPECT_EQ(fields_of(frames[1])[1], "1000.000000");
  EXPECT_EQ(fields_of(frames[1])[2], "TRACKED");

  PipelineOptions options;
  const FileStatus config = cli::read_pipeline_config(out + "/config.yaml", &options);
  EXPECT_TRUE(config.ok()) << config.message();
  EXPECT_EQ(cli::config_file_text(options), cli::config_file_text({}));
  expect_png(out + "/trajectory.png", 1400, 700);
  EXPECT_EQ(summary["report"]["written"], true);
  EXPECT_TRUE(fs::exists(out + "/report.html"));
  const std::string page = read_text(out + "/report.html");
  for (const char* part : {"Errors of trajectory.txt", "Errors of trajectory_optimized.txt",
                           "Time by stage [ms]", "image/svg+xml", "image/jpeg", "largest error"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }

  // What was found rather than asked for is said; progress goes to the standard error alone.
  for (const char* part : {"camera.yaml", "detections.txt", "groundtruth.txt", "S,D"}) {
    EXPECT_NE(result.out.find(part), std::string::npos) << part << " is not in: " << result.out;
  }
  EXPECT_NE(result.out.find("16 of 16 (100.0 %)"), std::string::npos) << result.out;
  EXPECT_NE(result.err.find("frame 16/16"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("TRACKED"), std::string::npos) << result.err;
  EXPECT_EQ(result.err.find("warning"), std::string::npos) << result.err;
  // Nothing but the results is left.
  std::size_t num_files = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(out)) {
    EXPECT_NE(entry.path().filename().string().front(), '.') << entry.path();
    ++num_files;
  }
  EXPECT_EQ(num_files, 8U);
}

TEST_F(CliRun, GivesTheSameBytesAgainAndWithOneThread) {
  ASSERT_EQ(run({"--dataset", room(), "--output", "first"}).exit_code, 0);
  ASSERT_EQ(run({"--dataset", room(), "--output", "second"}).exit_code, 0);
  ASSERT_EQ(run({"--dataset", room(), "--output", "one", "--threads", "1"}).exit_code, 0);
  ASSERT_EQ(run({"--dataset", room(), "--output", "two", "--threads", "2"}).exit_code, 0);
  for (const char* file : {"trajectory.txt", "trajectory_optimized.txt", "keyframes.txt"}) {
    const std::string first = read_text(output("first/") + file);
    for (const char* other : {"second/", "one/", "two/"}) {
      EXPECT_EQ(read_text(output(other) + file), first) << other << file;
    }
  }
  const Json one = json_of(output("one/summary.json"));
  EXPECT_EQ(one["timing"]["threads"], 1);
  EXPECT_EQ(one["config_hash"], json_of(output("two/summary.json"))["config_hash"]);
}

TEST_F(CliRun, JudgingScenesChangesNoPose) {
  ASSERT_EQ(run({"--dataset", room(), "--output", "none", "--modules", "none"}).exit_code, 0);
  const ProgramResult judged = run({"--dataset", room(), "--output", "judged", "--modules", "S"});
  ASSERT_EQ(judged.exit_code, 0);
  EXPECT_NE(judged.out.find("do not mask"), std::string::npos) << judged.out;
  for (const char* file : {"trajectory.txt", "trajectory_optimized.txt", "keyframes.txt"}) {
    EXPECT_EQ(read_text(output("judged/") + file), read_text(output("none/") + file)) << file;
  }
  const auto column = [this](const std::string& name, const std::string& wanted) {
    const std::vector<std::string> lines = lines_of(output(name) + "/frames.csv");
    const std::vector<std::string> header = fields_of(lines.front());
    const auto found = std::find(header.begin(), header.end(), wanted);
    EXPECT_NE(found, header.end()) << wanted;
    std::vector<std::string> values;
    for (std::size_t i = 1; i < lines.size(); ++i) {
      const std::vector<std::string> fields = fields_of(lines[i]);
      EXPECT_EQ(fields.size(), header.size()) << lines[i];
      values.push_back(fields[static_cast<std::size_t>(found - header.begin())]);
    }
    return values;
  };
  // Nothing moves in the room but the camera.
  for (const std::string& value : column("judged", "scene_class")) EXPECT_EQ(value, "GOOD");
  for (const std::string& value : column("none", "scene_class")) EXPECT_EQ(value, "");
  for (const std::string& value : column("judged", "culling_branch")) EXPECT_EQ(value, "");
  const std::vector<std::string> residuals = column("judged", "residual_px");
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    EXPECT_EQ(residuals[i].empty(), i < 5) << i;  // initial frames are judged without motion
    if (i >= 5) {
      EXPECT_LT(std::stod(residuals[i]), 3.0) << i;
    }
  }
}

TEST_F(CliRun, CalibrationIsReadByTheNextRun) {
  const auto calibrate = [this](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "calibrate");
    return run_program(arguments, folder_.path());
  };
  ProgramResult result = calibrate({"--dataset", room(), "--output", "own.yaml"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(result.says("too few frames")) << result.err;
  EXPECT_FALSE(fs::exists(folder_ / "own.yaml"));
  result = calibrate({"--dataset", room(), room(), room(), room(), "--output", "own.yaml"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(fs::exists(folder_ / "own.png"));
  PipelineOptions options;
  ASSERT_TRUE(cli::read_pipeline_config(folder_ / "own.yaml", &options).ok());
  EXPECT_GE(options.scene.assessor.residual_scale_px, 1.0);
  EXPECT_GT(options.scene.assessor.threshold, 0.0);
  EXPECT_EQ(run({"--dataset", room(), "--config", "own.yaml", "--output", "out"}).exit_code, 0);
  for (const std::vector<std::string>& wrong : std::vector<std::vector<std::string>>{
           {"--output", "own.yaml"},
           {"--dataset", room()},
           {"--dataset", "absent", "--output", "own.yaml"},
           {"--dataset", room(), "--output", "absent/own.yaml"},
           {"--dataset", room(), "--output", "own.yaml", "--residual-percentile", "101"}}) {
    EXPECT_EQ(calibrate(wrong).exit_code, 2) << wrong.back();
  }
}

TEST_F(CliRun, ChangedOptionsReachThePipeline) {
  write_text(folder_ / "few.yaml", "features.num_features: 200\ntracking.max_depth_m: 2.5\n");
  ASSERT_EQ(run({"--dataset", room(), "--output", "few", "--config", "few.yaml"}).exit_code, 0);
  ASSERT_EQ(run({"--dataset", room(), "--output", "many"}).exit_code, 0);
  const auto num_features = [this](const std::string& name) {
    return std::stoi(fields_of(lines_of(output(name) + "/frames.csv")[1])[3]);
  };
  EXPECT_LE(num_features("few"), 300);
  EXPECT_GE(num_features("many"), 600);
  PipelineOptions options;
  ASSERT_TRUE(cli::read_pipeline_config(output("few/config.yaml"), &options).ok());
  EXPECT_EQ(options.features.num_features, 200);
  EXPECT_EQ(options.tracking.max_depth_m, 2.5);
  EXPECT_EQ(json_of(output("few/summary.json"))["config_hash"], cli::config_hash(options));
}

TEST_F(CliRun, NeedsACamera) {
  const std::string copy = copy_of_room();
  fs::remove(copy + "/camera.yaml");
  expect_usage_error({"--dataset", copy},
                     {"no camera", "--camera", "tum_fr1", "tum_fr2", "tum_fr3", "bonn"});
  expect_usage_error({"--dataset", copy, "--camera", "tum_fr4"},
                     {"'tum_fr4' is neither a preset", "tum_fr1", "bonn"});
  write_text(folder_ / "bad_camera.yaml", "width_px: 320\n");
  expect_usage_error({"--dataset", copy, "--camera", "bad_camera.yaml"}, {"bad_camera.yaml"});
}

TEST_F(CliRun, ACameraOfAnotherSizeIsAReasonForEveryFrame) {
  const ProgramResult result = run({"--dataset", room(), "--camera", "tum_fr1", "--output", "out"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(result.says("every frame is damaged")) << result.err;
  EXPECT_TRUE(result.says("640")) << result.err;
}

TEST_F(CliRun, RefusesBadInputsBeforeItWritesAnything) {
  expect_usage_error({"--dataset", folder_ / "absent"}, {"absent"});
  write_text(folder_ / "config.yaml", "num_threads: 2\nfeatures.num_features: 7\n");
  expect_usage_error({"--dataset", room(), "--config", "config.yaml"},
                     {"config.yaml:2:", "features.num_features", "50 to 20000"});
  expect_usage_error({"--dataset", room(), "--modules", "S,X"}, {"unknown module 'X'"});
  expect_usage_error({"--dataset", room(), "--modules", "S,P"}, {"known but not built"});
  expect_usage_error({"--dataset", room(), "--modules", "P"}, {"needs module 'S'"});
  expect_usage_error({"--dataset", room(), "--depth-scale", "0"}, {"--depth-scale"});
  expect_usage_error({"--dataset", room(), "--depth-scale", "-5"}, {"--depth-scale"});
  expect_usage_error({"--dataset", room(), "--max-frames", "0"}, {"--max-frames"});
  expect_usage_error({"--dataset", room(), "--threads", "3"}, {"--threads"});
  expect_usage_error({"--dataset", room(), "--groundtruth-frame", "body"}, {"groundtruth-frame"});
  expect_usage_error({"--dataset", room(), "--speed", "9"}, {"--speed"});
  expect_usage_error({}, {"--dataset"});
  const std::string copy = copy_of_room();
  write_text(copy + "/detections.txt", "# srslam detections v1\n1000.0 person 2.0 0 0 5 5\n");
  expect_usage_error({"--dataset", copy}, {"detections.txt:2:", "--detections none"});
  write_text(copy + "/groundtruth.txt", "1000.0 0 0 0 0 0 0 0\n");
  expect_usage_error({"--dataset", copy, "--detections", "none"},
                     {"groundtruth.txt:1:", "--groundtruth none"});
  write_text(copy + "/rgb.txt", "1000.0\n");
  expect_usage_error({"--dataset", copy}, {"rgb.txt:1:"});
}

TEST_F(CliRun, AnOutputThatCannotBeMadeIsAnInputError) {
  write_text(folder_ / "occupied", "a file\n");
  for (const char* out : {"occupied", "occupied/below"}) {
    const ProgramResult result = run({"--dataset", room(), "--output", out});
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_TRUE(result.says("output folder cannot be created")) << result.err;
  }
  EXPECT_EQ(read_text(folder_ / "occupied"), "a file\n");
}

TEST_F(CliRun, ADamagedFrameIsReportedSkippedAndCounted) {
  const std::string copy = copy_of_room();
  const std::string damaged = "rgb/" + room_timestamp(7) + ".png";
  fs::remove(copy + "/rgb");
  fs::copy(room() + "/rgb", copy + "/rgb", fs::copy_options::recursive);
  fs::resize_file(copy + "/" + damaged, fs::file_size(copy + "/" + damaged) / 2);
  const ProgramResult result = run({"--dataset", copy, "--output", "out"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::size_t first = result.err.find(damaged);
  ASSERT_NE(first, std::string::npos) << result.err;
  EXPECT_EQ(result.err.find(damaged, first + 1), std::string::npos) << "reported twice";
  EXPECT_TRUE(result.says("frame 7 is skipped")) << result.err;
  const Json frames = json_of(output("out/summary.json"))["frames"];
  EXPECT_EQ(frames["damaged"], 1);
  EXPECT_EQ(frames["tracked"], kNumFrames - 1);
  EXPECT_EQ(num_poses(output("out/trajectory.txt")), std::size_t{kNumFrames} - 1);
  const std::string line = lines_of(output("out/frames.csv"))[8];
  EXPECT_NE(line.find("DAMAGED"), std::string::npos) << line;
  EXPECT_NE(line.find(damaged), std::string::npos) << line;
}

TEST_F(CliRun, AFrameWithoutDepthIsSkippedAndCountedApart) {
  const std::string copy = copy_of_room();
  std::string depth;
  for (const std::string& line : lines_of(room() + "/depth.txt")) {
    if (line.find(room_timestamp(5)) == std::string::npos) depth += line + "\n";
  }
  write_text(copy + "/depth.txt", depth);
  const ProgramResult result = run({"--dataset", copy, "--output", "out"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json frames = json_of(output("out/summary.json"))["frames"];
  EXPECT_EQ(frames["without_depth"], 1);
  EXPECT_EQ(frames["with_depth"], kNumFrames - 1);
  EXPECT_EQ(frames["damaged"], 0);
  EXPECT_EQ(frames["tracked"], kNumFrames - 1);
  EXPECT_EQ(frames["coverage_with_depth"], 1.0);
  EXPECT_NE(lines_of(output("out/frames.csv"))[6].find("NO_DEPTH"), std::string::npos);
}

TEST_F(CliRun, NothingTrackedIsAFailureWithAReason) {
  // 40 x 30 pixels hold far fewer features than a map needs.
  write_tiny_dataset(folder_ / "tiny", 4);
  const ProgramResult tiny = run({"--dataset", folder_ / "tiny", "--output", "tiny_out"});
  EXPECT_EQ(tiny.exit_code, 1) << tiny.err;
  EXPECT_TRUE(tiny.says("nothing was tracked")) << tiny.err;
  EXPECT_TRUE(tiny.says("could not start a map")) << tiny.err;
  const Json summary = json_of(output("tiny_out/summary.json"));
  EXPECT_EQ(summary["exit_code"], 1);
  EXPECT_EQ(summary["frames"]["not_initialized"], 4);
  EXPECT_EQ(summary["picture"]["written"], false);
  EXPECT_FALSE(fs::exists(output("tiny_out/trajectory.png")));
  EXPECT_TRUE(fs::exists(output("tiny_out/report.html")));

  const std::string copy = copy_of_room();
  write_text(copy + "/depth.txt", "2000.0 depth/" + room_timestamp(0) + ".png\n");
  const ProgramResult blind = run({"--dataset", copy, "--output", "blind_out"});
  EXPECT_EQ(blind.exit_code, 1) << blind.err;
  EXPECT_TRUE(blind.says("no frame has a depth image close enough in time")) << blind.err;
}

TEST_F(CliRun, WithoutGroundTruthThereAreNoErrorsButAPicture) {
  const ProgramResult result =
      run({"--dataset", room(), "--groundtruth", "none", "--output", "out"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(json_of(output("out/summary.json"))["evaluation"].is_null());
  EXPECT_TRUE(result.says("no ground truth")) << result.out;
  expect_png(output("out/trajectory.png"), 1400, 700);
}

TEST_F(CliRun, DetectionsAreUsedUnlessNoneAreWanted) {
  ASSERT_EQ(run({"--dataset", room(), "--output", "with"}).exit_code, 0);
  const ProgramResult without =
      run({"--dataset", room(), "--detections", "none", "--output", "without"});
  ASSERT_EQ(without.exit_code, 0);
  EXPECT_TRUE(json_of(output("without/summary.json"))["detections"].is_null());
  EXPECT_NE(without.out.find("detections:   none"), std::string::npos) << without.out;
  // The baseline never masks by them.
  EXPECT_EQ(read_text(output("with/trajectory.txt")), read_text(output("without/trajectory.txt")));
}

TEST_F(CliRun, AnotherDepthScaleIsUsedSaidAndDoubtedWhenItGivesNoRoom) {
  const ProgramResult doubled =
      run({"--dataset", room(), "--depth-scale", "2500", "--output", "doubled"});
  ASSERT_EQ(doubled.exit_code, 0) << doubled.err;
  EXPECT_NE(doubled.out.find("depth scale 2500 per metre (--depth-scale; the camera says 5000)"),
            std::string::npos)
      << doubled.out;
  const Json camera = json_of(output("doubled/summary.json"))["camera"];
  EXPECT_EQ(camera["depth_units_per_m"], 2500.0);
  EXPECT_EQ(camera["depth_scale_overridden"], true);

  const ProgramResult shrunk =
      run({"--dataset", room(), "--depth-scale", "100000", "--output", "shrunk"});
  EXPECT_TRUE(shrunk.says("depth_units_per_m may be too large")) << shrunk.err;
  EXPECT_EQ(json_of(output("shrunk/summary.json"))["first_depth_image"]["plausible"], false);
}

TEST_F(CliRun, StopsAtTheLimitOfFrames) {
  const ProgramResult result = run({"--dataset", room(), "--max-frames", "5", "--output", "out"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(num_poses(output("out/trajectory.txt")), 5U);
  const Json summary = json_of(output("out/summary.json"));
  EXPECT_EQ(summary["exit_reason"], "finished at the limit of frames");
  EXPECT_EQ(summary["frames"]["in_dataset"], kNumFrames);
  EXPECT_EQ(summary["frames"]["processed"], 5);
}

TEST_F(CliRun, QuietLeavesTheSummaryOnly) {
  const ProgramResult result = run({"--dataset", room(), "--quiet", "--output", "out"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(result.out.find("dataset:"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("Frames tracked"), std::string::npos) << result.out;
}

TEST_F(CliRun, APageIsLeftOutOnRequest) {
  write_text(output("out/report.html"), "old\n");
  ASSERT_EQ(
      run({"--dataset", room(), "--max-frames", "3", "--output", "out", "--no-report"}).exit_code,
      0);
  EXPECT_FALSE(fs::exists(output("out/report.html")));
  EXPECT_EQ(json_of(output("out/summary.json"))["report"]["written"], false);
}

TEST_F(CliRun, TheDefaultOutputBearsTheNameOfTheDataset) {
  const ProgramResult result = run({"--dataset", room() + "/", "--max-frames", "3"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(fs::exists(folder_ / "srslam_output/room/summary.json"));
  EXPECT_TRUE(result.says("srslam_output/room")) << result.out;
}

TEST_F(CliRun, ResultsOfAnEarlierRunDoNotSurvive) {
  write_text(output("out/summary.json"), "old\n");
  write_text(output("out/trajectory.png"), "old\n");
  write_text(output("out/mine.txt"), "kept\n");
  write_tiny_dataset(folder_ / "tiny", 2);
  ASSERT_EQ(run({"--dataset", folder_ / "tiny", "--output", "out"}).exit_code, 1);
  EXPECT_FALSE(fs::exists(output("out/trajectory.png")));
  EXPECT_EQ(json_of(output("out/summary.json"))["exit_code"], 1);
  EXPECT_EQ(read_text(output("out/mine.txt")), "kept\n");
}

TEST_F(CliRun, ANameFullOfQuotesIsOnlyAName) {
  const std::string name = "it's `touch pwned1` $(touch pwned2); \"x\" @y";
  copy_of_room(name);
  const ProgramResult result =
      run({"--dataset", folder_ / name, "--max-frames", "4", "--output", name + "/out"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(json_of(folder_ / name + "/out/summary.json")["picture"]["written"], true);
  EXPECT_EQ(json_of(folder_ / name + "/out/summary.json")["dataset"]["name"], name);
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder_.path())) {
    const std::string file = entry.path().filename().string();
    EXPECT_NE(file.substr(0, file.size() - 1), "pwned") << entry.path();
  }
}

TEST_F(CliRun, WithoutGnuplotEverythingElseIsWritten) {
  fs::create_directory(folder_ / "no_programs");
  Program program({"run", "--dataset", room(), "--max-frames", "4", "--output", "out"},
                  folder_.path(), folder_ / "no_programs");
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(result.says("warning: the picture is not written")) << result.err;
  EXPECT_TRUE(result.says("gnuplot cannot be started")) << result.err;
  const Json picture = json_of(output("out/summary.json"))["picture"];
  EXPECT_EQ(picture["written"], false);
  EXPECT_NE(picture["reason"].get<std::string>().find("gnuplot"), std::string::npos);
  EXPECT_FALSE(fs::exists(output("out/trajectory.png")));
  EXPECT_EQ(num_poses(output("out/trajectory.txt")), 4U);
  EXPECT_TRUE(fs::exists(output("out/report.html")));
  const std::string page = read_text(output("out/report.html"));
  EXPECT_NE(page.find("There are no plots: gnuplot cannot be started"), std::string::npos);
  EXPECT_NE(page.find("Errors of trajectory.txt"), std::string::npos);
}

TEST_F(CliRun, AGnuplotThatFailsIsReportedWithItsWords) {
  write_text(folder_ / "programs/gnuplot", "#!/bin/sh\necho 'no terminal today' >&2\nexit 3\n");
  fs::permissions(folder_ / "programs/gnuplot", fs::perms::owner_all);
  Program program({"run", "--dataset", room(), "--max-frames", "4", "--output", "out"},
                  folder_.path(), folder_ / "programs");
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(result.says("gnuplot ended with code 3: no terminal today")) << result.err;
  EXPECT_EQ(json_of(output("out/summary.json"))["picture"]["written"], false);
}

TEST_F(CliRun, AnInterruptEndsTheRunWithEverythingWritten) {
  struct Case {
    int signal_number;
    const char* name;
  };
  const std::string dataset = long_room(20000);
  for (const Case& stop : {Case{SIGINT, "SIGINT"}, Case{SIGTERM, "SIGTERM"}}) {
    Program program({"run", "--dataset", dataset, "--output", stop.name}, folder_.path());
    const std::string out = output(stop.name);
    wait_for_frames(out + "/frames.csv", 5);
    program.send(stop.signal_number);
    const ProgramResult result = program.wait();
    EXPECT_EQ(result.exit_code, 128 + stop.signal_number) << result.err;
    const Json summary = json_of(out + "/summary.json");
    EXPECT_EQ(summary["exit_code"], 128 + stop.signal_number);
    EXPECT_NE(summary["exit_reason"].get<std::string>().find(stop.name), std::string::npos);
    const std::size_t processed = summary["frames"]["processed"];
    EXPECT_GE(processed, 5U);
    EXPECT_LT(processed, 20000U);
    EXPECT_EQ(lines_of(out + "/frames.csv").size(), processed + 1);
    const std::size_t tracked = summary["frames"]["tracked"];
    EXPECT_GE(tracked, 1U);
    EXPECT_EQ(num_poses(out + "/trajectory.txt"), tracked);
    EXPECT_EQ(num_poses(out + "/trajectory_optimized.txt"), tracked);
    EXPECT_GE(num_poses(out + "/keyframes.txt"), 1U);
    expect_png(out + "/trajectory.png", 1400, 700);
    EXPECT_TRUE(result.says("interrupted by " + std::string(stop.name))) << result.out;
  }
}

TEST_F(CliRun, ASecondInterruptEndsTheProgramAtOnce) {
  // A drawing program that takes its time keeps the run in its last part.
  write_text(folder_ / "programs/gnuplot", "#!/bin/sh\n: > started\nexec /bin/sleep 20\n");
  fs::permissions(folder_ / "programs/gnuplot", fs::perms::owner_all);
  Program program({"run", "--dataset", long_room(20000), "--output", "out"}, folder_.path(),
                  folder_ / "programs");
  wait_for_frames(output("out/frames.csv"), 5);
  program.send(SIGINT);
  bool drawing = false;
  for (int i = 0; i < 6000 && !drawing; ++i) {
    for (const fs::directory_entry& entry : fs::directory_iterator(output("out"))) {
      drawing = drawing || fs::exists(entry.path() / "started");
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ASSERT_TRUE(drawing) << "the run did not come to its picture";
  const auto start = std::chrono::steady_clock::now();
  program.send(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.signal_number, SIGINT);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
  EXPECT_GE(num_poses(output("out/trajectory.txt")), 1U);
}

TEST_F(CliRun, MarkerGroundTruthIsConvertedForRelativeErrorsOnly) {
  ASSERT_EQ(run({"--dataset", room(), "--output", "camera"}).exit_code, 0);
  ASSERT_EQ(run({"--dataset", room(), "--groundtruth-frame", "bonn_marker", "--output", "marker"})
                .exit_code,
            0);
  const Json camera = json_of(output("camera/summary.json"))["evaluation"];
  const Json marker = json_of(output("marker/summary.json"))["evaluation"];
  EXPECT_EQ(marker["groundtruth_frame"], "bonn_marker");
  const Json& errors = marker["trajectory.txt"];
  EXPECT_EQ(errors["ate"]["groundtruth"], "bonn_marker poses as published");
  EXPECT_EQ(errors["rpe_1_frame"]["groundtruth"], "camera poses converted from bonn_marker");
  // These poses are the camera's: as published they fit, converted they do not.
  EXPECT_EQ(errors["ate"]["translation_m"], camera["trajectory.txt"]["ate"]["translation_m"]);
  EXPECT_GT(errors["rpe_1_frame"]["rotation_deg"]["rmse"],
            camera["trajectory.txt"]["rpe_1_frame"]["rotation_deg"]["rmse"]);
}

TEST_F(CliRun, RealBonnSliceHasItsRelativeErrorsInTheCamerasFrame) {
  const std::string slice = real_slice("bonn_crowd_a");
  if (slice.empty()) GTEST_SKIP() << skip_reason("bonn_crowd_a");
  ASSERT_EQ(run({"--dataset", slice, "--camera", "bonn", "--max-frames", "90", "--output", "out"})
                .exit_code,
            0);
  ASSERT_EQ(run({"--dataset", slice, "--camera", "bonn", "--max-frames", "90", "--output", "other",
                 "--groundtruth-frame", "camera"})
                .exit_code,
            0);
  const Json out = json_of(output("out/summary.json"))["evaluation"]["trajectory.txt"];
  const Json other = json_of(output("other/summary.json"))["evaluation"]["trajectory.txt"];
  EXPECT_EQ(out["ate"]["groundtruth"], "bonn_marker poses as published");
  EXPECT_EQ(out["rpe_1_s"]["groundtruth"], "camera poses converted from bonn_marker");
  EXPECT_EQ(out["ate"]["translation_m"], other["ate"]["translation_m"]);
  // The axes of the marker are not the camera's: without conversion relative rotations are wrong.
  EXPECT_LT(out["rpe_1_s"]["rotation_deg"]["rmse"], 1.5);
  EXPECT_GT(other["rpe_1_s"]["rotation_deg"]["rmse"],
            3.0 * out["rpe_1_s"]["rotation_deg"]["rmse"].get<double>());
}

}  // namespace
}  // namespace srslam::test
