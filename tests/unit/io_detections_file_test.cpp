#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "srslam/io/detections_file.hpp"
#include "support/io_test_dataset.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::expect_failure;
using test::TempFolder;
using test::write_text;

const char* const kHeader = "# srslam detections v1\n";

class DetectionsFile : public testing::Test {
 protected:
  FileStatus read(const std::string& text) {
    write_text(path_, text);
    return read_detections(path_, &frames_);
  }

  TempFolder folder_;
  std::string path_ = folder_ / "detections.txt";
  std::vector<FrameDetections> frames_;
};

TEST_F(DetectionsFile, ReadsTheDocumentedExample) {
  const FileStatus status = read(std::string(kHeader) +
                                 "# timestamp_s class score x_min_px y_min_px x_max_px y_max_px\n"
                                 "1548339827.04 person 0.912 100.0 50.2 200.1 400.0\n"
                                 "1548339827.04 dining_table 1 -3.5 0 640.5 480\n"
                                 "\n"
                                 "1548339827.08 none\n"
                                 "1548339827.11 cup 0 1 2 3 4\n");
  ASSERT_TRUE(status.ok()) << status.message();
  ASSERT_EQ(frames_.size(), 3U);
  EXPECT_EQ(frames_[0].timestamp_s, 1548339827.04);
  ASSERT_EQ(frames_[0].detections.size(), 2U);
  const Detection& person = frames_[0].detections[0];
  EXPECT_EQ(person.class_name, "person");
  EXPECT_EQ(person.score, 0.912);
  EXPECT_EQ(person.x_min_px, 100.0);
  EXPECT_EQ(person.y_min_px, 50.2);
  EXPECT_EQ(person.x_max_px, 200.1);
  EXPECT_EQ(person.y_max_px, 400.0);
  EXPECT_EQ(frames_[0].detections[1].class_name, "dining_table");
  EXPECT_EQ(frames_[0].detections[1].x_min_px, -3.5);
  EXPECT_TRUE(frames_[1].detections.empty());
  EXPECT_EQ(frames_[2].detections.size(), 1U);
}

TEST_F(DetectionsFile, AcceptsCarriageReturns) {
  ASSERT_TRUE(read("# srslam detections v1\r\n1 none\r\n2 cat 0.5 1 2 3 4\r\n").ok());
  ASSERT_EQ(frames_.size(), 2U);
  EXPECT_EQ(frames_[1].detections[0].class_name, "cat");
  EXPECT_EQ(frames_[1].detections[0].y_max_px, 4.0);
}

TEST_F(DetectionsFile, FramesInAnyOrderComeOutSorted) {
  ASSERT_TRUE(read(std::string(kHeader) + "3 c 0.5 1 2 3 4\n"
                                          "1 a 0.5 1 2 3 4\n"
                                          "1 b 0.5 1 2 3 4\n"
                                          "2 none\n")
                  .ok());
  ASSERT_EQ(frames_.size(), 3U);
  EXPECT_EQ(frames_[0].timestamp_s, 1.0);
  ASSERT_EQ(frames_[0].detections.size(), 2U);
  EXPECT_EQ(frames_[0].detections[0].class_name, "a");
  EXPECT_EQ(frames_[0].detections[1].class_name, "b");
  EXPECT_TRUE(frames_[1].detections.empty());
  EXPECT_EQ(frames_[2].detections[0].class_name, "c");
}

TEST_F(DetectionsFile, TheHeaderLineIsRequired) {
  for (const std::string text :
       {"", "1 none\n", "# comment\n# srslam detections v1\n1 none\n",
        "#srslam detections v1\n1 none\n", "srslam detections v1\n1 none\n", "\n"}) {
    expect_failure(read(text), StatusCode::kCorruptData, path_, 1,
                   "expected the header line `# srslam detections v1`");
    EXPECT_TRUE(frames_.empty());
  }
  EXPECT_TRUE(read("# srslam detections v1 \t\n1 none\n").ok());
  expect_failure(read("# srslam detections v2\n1 none\n"), StatusCode::kUnsupported, path_, 1,
                 "another version");
}

TEST_F(DetectionsFile, RefusesBadLinesWithLineAndReason) {
  struct Case {
    std::string line;
    std::string reason_part;
  };
  const std::vector<Case> cases = {
      {"2", "expected 7 columns"},
      {"2 person", "got 2"},
      {"2 person 0.5 1 2 3", "got 6"},
      {"2 traffic light 0.5 1 2 3 4", "got 8"},
      {"2 none 0.5 1 2 3 4", "`none` stands for a frame without detections"},
      {"x person 0.5 1 2 3 4", "time stamp 'x'"},
      {"inf none", "time stamp 'inf'"},
      {"1548339827040 none", "not milliseconds"},
      {"2 person 1.01 1 2 3 4", "score must be between 0 and 1"},
      {"2 person -0.1 1 2 3 4", "score must be between 0 and 1"},
      {"2 person nan 1 2 3 4", "score is 'nan', not a finite decimal number"},
      {"2 person high 1 2 3 4", "score is 'high'"},
      {"2 person 0.5 1px 2 3 4", "x_min_px is '1px'"},
      {"2 person 0.5 1 2 inf 4", "x_max_px is 'inf'"},
      {"2 person 0.5 1 2 3 nan", "y_max_px is 'nan'"},
      {"2 person 0.5 3 2 3 4", "x_min_px must be less than x_max_px"},
      {"2 person 0.5 4 2 3 4", "x_min_px must be less than x_max_px"},
      {"2 person 0.5 1 4 3 4", "y_min_px must be less than y_max_px"},
      {"2 person 0.5 1 2 3e6 4", "at most 1e6 px"},
      {"2 " + std::string(300, 'x') + " 0.5 1 2 3 4", "at most 256 bytes"},
      {"1 none", "already has lines; `none` must be the only line"},
      {"0.5 none\n0.5 a 0.5 1 2 3 4", "said to have no detections on line 3"},
      {"0.5 none\n0.5 none", "`none` must be the only line"},
      {"2 none\n1 b 0.5 1 2 3 4",
       "frame 1.000000 already began on line 2; the lines of a frame must"},
      {"2 none\n1 none", "frame 1.000000 already began on line 2"},
      {"2 per\xC3 0.5 1 2 3 4", "UTF-8"},
      {"2 per\x01son 0.5 1 2 3 4", "control character"},
      {"2 person 0.5 1 2 3 4" + std::string(5000, ' '), "longer than 4096 bytes"},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.line.substr(0, 60));
    const std::size_t line = c.line.find('\n') == std::string::npos ? 3 : 4;
    expect_failure(read(kHeader + std::string("1 a 0.5 1 2 3 4\n") + c.line + "\n"),
                   StatusCode::kCorruptData, path_, line, c.reason_part);
    EXPECT_TRUE(frames_.empty());
  }
  expect_failure(read(kHeader), StatusCode::kInsufficientData, path_, 0, "no frames");
  expect_failure(read_detections(folder_ / "absent.txt", &frames_), StatusCode::kNotFound,
                 folder_ / "absent.txt", 0, "does not exist");
  expect_failure(read_detections(folder_.path(), &frames_), StatusCode::kCorruptData,
                 folder_.path(), 0, "is a folder");
}

TEST_F(DetectionsFile, RoundTripKeepsEveryBit) {
  test::for_each_seed(100, [this](test::Rng& rng) {
    std::vector<FrameDetections> written(static_cast<std::size_t>(rng.uniform_int(1, 10)));
    double time_s = rng.uniform(-1e3, 1.6e9);
    for (FrameDetections& frame : written) {
      frame.timestamp_s = time_s;
      time_s += rng.uniform(1e-3, 0.1);
      frame.detections.resize(static_cast<std::size_t>(rng.uniform_int(0, 3)));
      for (Detection& detection : frame.detections) {
        detection.class_name = rng.coin() ? "person" : "Stühle/深度";
        detection.score = rng.uniform(0.0, 1.0);
        detection.x_min_px = rng.uniform(-100.0, 600.0);
        detection.y_min_px = rng.uniform(-100.0, 400.0);
        detection.x_max_px = detection.x_min_px + rng.uniform(1e-3, 100.0);
        detection.y_max_px = detection.y_min_px + rng.uniform(1e-3, 100.0);
      }
    }
    ASSERT_TRUE(write_detections(path_, written).ok());
    const FileStatus status = read_detections(path_, &frames_);
    ASSERT_TRUE(status.ok()) << status.message();
    ASSERT_EQ(frames_.size(), written.size());
    for (std::size_t i = 0; i < written.size(); ++i) {
      ASSERT_EQ(frames_[i].timestamp_s, written[i].timestamp_s);
      ASSERT_EQ(frames_[i].detections.size(), written[i].detections.size());
      for (std::size_t j = 0; j < written[i].detections.size(); ++j) {
        const Detection& a = frames_[i].detections[j];
        const Detection& b = written[i].detections[j];
        ASSERT_EQ(a.class_name, b.class_name);
        ASSERT_EQ(a.score, b.score);
        ASSERT_EQ(a.x_min_px, b.x_min_px);
        ASSERT_EQ(a.y_min_px, b.y_min_px);
        ASSERT_EQ(a.x_max_px, b.x_max_px);
        ASSERT_EQ(a.y_max_px, b.y_max_px);
      }
    }
  });
}

TEST_F(DetectionsFile, RefusesToWriteWhatItCouldNotReadBack) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  FrameDetections good;
  good.timestamp_s = 1.0;
  good.detections.push_back({"person", 0.5, 1.0, 2.0, 3.0, 4.0});
  std::vector<std::pair<FrameDetections, std::string>> bad(12, {good, ""});
  for (auto& [frame, reason] : bad) frame.timestamp_s = 2.0;
  bad[0].first.timestamp_s = nan;
  bad[0].second = "time stamp";
  bad[1].first.timestamp_s = 1.0;
  bad[1].second = "not after";
  bad[2].first.detections[0].class_name = "";
  bad[2].second = "class name";
  bad[3].first.detections[0].class_name = "none";
  bad[3].second = "class name";
  bad[4].first.detections[0].class_name = "traffic light";
  bad[4].second = "class name";
  bad[5].first.detections[0].class_name = "two\nlines";
  bad[5].second = "class name";
  bad[6].first.detections[0].class_name = "\xFF";
  bad[6].second = "class name";
  bad[7].first.detections[0].class_name = std::string(257, 'x');
  bad[7].second = "256 bytes";
  bad[8].first.detections[0].score = nan;
  bad[8].second = "score";
  bad[9].first.detections[0].x_max_px = nan;
  bad[9].second = "box edges";
  bad[10].first.detections[0].x_max_px = 1.0;
  bad[10].second = "x_min_px must be less";
  bad[11].first.detections[0].y_max_px = 0.0;
  bad[11].second = "y_min_px must be less";
  for (const auto& [frame, reason] : bad) {
    SCOPED_TRACE(reason);
    const FileStatus status = write_detections(path_, {good, frame});
    expect_failure(status, StatusCode::kInvalidArgument, path_, 0, reason);
    EXPECT_NE(status.reason.find("frame 1: "), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(path_));
  }
  expect_failure(write_detections(path_, {}), StatusCode::kInvalidArgument, path_, 0, "no frames");
}

TEST(FindDetections, AgreesWithBruteForce) {
  test::for_each_seed(300, [](test::Rng& rng) {
    std::vector<FrameDetections> frames(static_cast<std::size_t>(rng.uniform_int(0, 12)));
    double time_s = rng.uniform(0.0, 1.0);
    for (FrameDetections& frame : frames) {
      frame.timestamp_s = time_s;
      // Multiples of 1/64, so that equally near frames occur and differences are exact.
      time_s += rng.uniform_int(1, 4) / 64.0;
    }
    const double start_s = frames.empty() ? 0.0 : frames.front().timestamp_s;
    for (int repeat = 0; repeat < 20; ++repeat) {
      const double query_s = start_s + rng.uniform_int(-20, 80) / 128.0;
      const double tolerance_s = rng.uniform_int(0, 6) / 128.0;
      std::size_t expected = frames.size();
      double best_s = tolerance_s;
      for (std::size_t i = 0; i < frames.size(); ++i) {
        const double difference_s = std::abs(frames[i].timestamp_s - query_s);
        const bool better =
            expected == frames.size() ? difference_s <= best_s : difference_s < best_s;
        if (better) {
          expected = i;
          best_s = difference_s;
        }
      }
      ASSERT_EQ(find_detections(frames, query_s, tolerance_s), expected);
    }
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(find_detections(frames, nan, 1.0), frames.size());
    EXPECT_EQ(find_detections(frames, start_s, nan), frames.size());
  });
}

}  // namespace
}  // namespace srslam
