#include "cli/trajectory_plot.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "cli/run_plot.hpp"
#include "support/io_test_dataset.hpp"

namespace srslam::cli {
namespace {

using srslam::test::TempFolder;

TrajectoryPlot circle_plot() {
  TrajectoryPlot plot;
  plot.title = "circle";
  plot.map_title = "Trajectory";
  plot.color_label = "error [m]";
  plot.time.begin_s = 100.0;
  plot.time.end_s = 110.0;
  plot.upper = {"upper", "[m]", {{"over 1 s", {}}}};
  plot.lower = {"lower", "[°]", {{"over 1 s", {}}}};
  for (int i = 0; i < 100; ++i) {
    PlotPosition position;
    position.position_m = Eigen::Vector3d(std::cos(0.06 * i), 0.1, std::sin(0.06 * i));
    position.color_value = 0.001 * i;
    position.starts_segment = i == 50;
    plot.estimate.push_back(position);
    plot.upper.series[0].samples.push_back({100.0 + 0.1 * i, 0.02});
    plot.lower.series[0].samples.push_back({100.0 + 0.1 * i, 0.5});
  }
  return plot;
}

/// Lines of the data block `$name`.
std::vector<std::string> data_block(const std::string& script, const std::string& name) {
  std::istringstream stream(script);
  std::vector<std::string> lines;
  std::string line;
  bool inside = false;
  while (std::getline(stream, line)) {
    if (inside && line == "END_OF_DATA") return lines;
    if (inside) lines.push_back(line);
    if (line == "$" + name + " << END_OF_DATA") inside = true;
  }
  ADD_FAILURE() << "no data block " << name;
  return lines;
}

TEST(TrajectoryPlot, ShowsTheTwoAxesOfTheLargestExtent) {
  TrajectoryPlot plot = circle_plot();
  EXPECT_EQ(most_extended_axes(plot).horizontal, 0);
  EXPECT_EQ(most_extended_axes(plot).vertical, 2);
  for (PlotPosition& position : plot.estimate) position.position_m[0] = 0.0;
  plot.reference.push_back({true, {{0.0, 2.0, 0.0}}});
  EXPECT_EQ(most_extended_axes(plot).horizontal, 1);
  EXPECT_EQ(most_extended_axes(plot).vertical, 2);
  EXPECT_EQ(most_extended_axes(TrajectoryPlot()).horizontal, 0);
  EXPECT_EQ(most_extended_axes(TrajectoryPlot()).vertical, 1);
}

TEST(TrajectoryPlot, BreaksTheLineWhereFramesWereLost) {
  const std::vector<std::string> lines = data_block(gnuplot_script(circle_plot()), "estimate");
  ASSERT_EQ(lines.size(), 101U);
  EXPECT_EQ(lines[50], "");
  EXPECT_EQ(lines[0], "1 0 0");
}

TEST(TrajectoryPlot, GivesBothAxesOneScale) {
  const std::string script = gnuplot_script(circle_plot());
  const auto span = [&script](const std::string& axis) {
    const std::string key = "set " + axis + "range [";
    const std::size_t begin = script.find(key) + key.size();
    const std::size_t colon = script.find(':', begin);
    return std::stod(script.substr(colon + 1)) - std::stod(script.substr(begin));
  };
  const auto side = [&script](const std::string& margin) {
    const std::string key = "set " + margin + " at screen ";
    return std::stod(script.substr(script.find(key) + key.size()));
  };
  const double width_px = (side("rmargin") - side("lmargin")) * 1400.0;
  const double height_px = (side("tmargin") - side("bmargin")) * 700.0;
  EXPECT_NEAR(span("x") / width_px, span("y") / height_px, 1e-9);
  EXPECT_GT(span("x"), 2.0);
  EXPECT_GT(span("y"), 2.0);
}

TEST(TrajectoryPlot, TextFromOutsideStaysText) {
  TrajectoryPlot plot = circle_plot();
  plot.title = "a' ; system('touch pwned') #\n`touch pwned`\nEND_OF_DATA";
  const std::string script = gnuplot_script(plot);
  EXPECT_NE(script.find("'a'' ; system(''touch pwned'') # `touch pwned` END_OF_DATA'"),
            std::string::npos);
  const TempFolder folder;
  const FileStatus status = write_trajectory_plot(plot, folder / "plot.png");
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_FALSE(std::filesystem::exists(folder / "pwned"));
}

TEST(TrajectoryPlot, DrawsEvenWhatIsHardlyThere) {
  const TempFolder folder;
  std::vector<TrajectoryPlot> plots(4, circle_plot());
  plots[1].estimate.resize(1);            // one pose
  plots[2].upper.series[0].samples = {};  // nothing over time
  plots[2].lower.series = {};
  for (PlotPosition& position : plots[3].estimate) {  // nothing moves, no error, no time passes
    position.position_m.setZero();
    position.color_value = 0.0;
  }
  plots[3].time.end_s = plots[3].time.begin_s;
  plots[3].time.gaps = {{plots[3].time.begin_s, plots[3].time.begin_s}};
  for (std::size_t i = 0; i < plots.size(); ++i) {
    const std::string file = folder / ("plot" + std::to_string(i) + ".png");
    const FileStatus status = write_trajectory_plot(plots[i], file);
    ASSERT_TRUE(status.ok()) << i << ": " << status.message();
    const cv::Mat picture = cv::imread(file);
    EXPECT_EQ(picture.cols, 1400) << i;
    EXPECT_EQ(picture.rows, 700) << i;
  }
}

TEST(TrajectoryPlot, AFolderThatIsNotThereIsAReason) {
  const TempFolder folder;
  const FileStatus status = write_trajectory_plot(circle_plot(), folder / "absent/plot.png");
  EXPECT_EQ(status.code, StatusCode::kIoError);
  EXPECT_EQ(status.file, folder / "absent/plot.png");
}

/// A run of ten frames of which the fourth to sixth are not tracked, along x, 1 m a frame.
RunResult run_with_gap() {
  RunResult result;
  for (int i = 0; i < 10; ++i) {
    FrameRecord record;
    record.index = static_cast<std::size_t>(i);
    record.timestamp_s = 100.0 + i;
    const bool tracked = i < 3 || i > 5;
    record.outcome = tracked ? FrameOutcome::kTracked : FrameOutcome::kLost;
    record.times.total_ms = 20.0;
    result.records.push_back(record);
    if (!tracked) continue;
    StampedPose pose;
    pose.timestamp_s = record.timestamp_s;
    pose.T_world_camera.translation() = Eigen::Vector3d(i, i == 7 ? 0.5 : 0.0, 0.1 * i * i);
    result.trajectory.push_back(pose);
  }
  return result;
}

TEST(RunPlot, ShowsLostFramesAsGaps) {
  RunInputs inputs;
  inputs.dataset_name = "gap";
  for (int i = 0; i < 10; ++i) {
    StampedPose pose;
    pose.timestamp_s = 100.0 + i;
    pose.T_world_camera.translation() = Eigen::Vector3d(i, 0.0, 0.1 * i * i);
    inputs.groundtruth.push_back(pose);
  }
  RunResult result = run_with_gap();
  result.report = make_report(inputs.groundtruth, result.trajectory, {});
  ASSERT_TRUE(result.report->ate.status.ok());
  const TrajectoryPlot plot = make_run_plot(inputs, result);
  EXPECT_NE(plot.title.find("gap: 7 of 10 frames tracked, ATE RMSE"), std::string::npos)
      << plot.title;
  ASSERT_EQ(plot.time.gaps.size(), 1U);
  EXPECT_EQ(plot.time.gaps[0].begin_s, 102.0);
  EXPECT_EQ(plot.time.gaps[0].end_s, 106.0);
  ASSERT_EQ(plot.estimate.size(), 7U);
  for (std::size_t i = 0; i < plot.estimate.size(); ++i) {
    EXPECT_EQ(plot.estimate[i].starts_segment, i == 0 || i == 3) << i;
    EXPECT_NEAR(plot.estimate[i].color_value, result.report->ate.errors_m[i], 1e-12) << i;
    // Aligned, the estimate is as far from the ground truth as its error says.
    const std::size_t frame = i < 3 ? i : i + 3;
    const Eigen::Vector3d truth = inputs.groundtruth[frame].T_world_camera.translation();
    EXPECT_NEAR((plot.estimate[i].position_m - truth).norm(), plot.estimate[i].color_value, 1e-9);
  }
  ASSERT_EQ(plot.reference.size(), 3U);
  EXPECT_TRUE(plot.reference[0].tracked);
  EXPECT_FALSE(plot.reference[1].tracked);
  EXPECT_TRUE(plot.reference[2].tracked);
  // The pieces meet.
  EXPECT_EQ(plot.reference[0].positions_m.back(), plot.reference[1].positions_m.front());
  EXPECT_EQ(plot.reference[1].positions_m.back(), plot.reference[2].positions_m.front());
  EXPECT_EQ(plot.upper.series.size(), 2U);
}

TEST(RunPlot, WithoutGroundTruthShowsTheProgress) {
  RunInputs inputs;
  inputs.dataset_name = "blind";
  const TrajectoryPlot plot = make_run_plot(inputs, run_with_gap());
  EXPECT_EQ(plot.title, "blind: 7 of 10 frames tracked");
  EXPECT_TRUE(plot.reference.empty());
  ASSERT_EQ(plot.estimate.size(), 7U);
  EXPECT_EQ(plot.estimate.back().color_value, 9.0);
  ASSERT_EQ(plot.lower.series.size(), 1U);
  EXPECT_EQ(plot.lower.series[0].samples.size(), 10U);
}

TEST(RunPlot, AGapAtEachEndReachesTheEnd) {
  RunResult result = run_with_gap();
  result.records.front().outcome = FrameOutcome::kNotInitialized;
  result.records.back().outcome = FrameOutcome::kLost;
  result.trajectory.erase(result.trajectory.begin());
  result.trajectory.pop_back();
  const TrajectoryPlot plot = make_run_plot({}, result);
  ASSERT_EQ(plot.time.gaps.size(), 3U);
  EXPECT_EQ(plot.time.gaps.front().begin_s, 100.0);
  EXPECT_EQ(plot.time.gaps.front().end_s, 101.0);
  EXPECT_EQ(plot.time.gaps.back().begin_s, 108.0);
  EXPECT_EQ(plot.time.gaps.back().end_s, 109.0);
}

}  // namespace
}  // namespace srslam::cli
