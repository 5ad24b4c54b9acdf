// Pages of runs and campaigns.

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "cli/report/campaign_report.hpp"
#include "cli/report/feature_store.hpp"
#include "cli/report/frame_pictures.hpp"
#include "cli/report/html_text.hpp"
#include "cli/report/run_report.hpp"
#include "support/io_test_dataset.hpp"

namespace srslam::cli {
namespace {

using srslam::test::TempFolder;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(HtmlText, EscapesWhatAPageWouldRead) {
  EXPECT_EQ(html_text("<b a='1' c=\"2\">&\n\x01</b>"),
            "&lt;b a=&#39;1&#39; c=&quot;2&quot;&gt;&amp;  &lt;/b&gt;");
  TextTable table;
  table.title = "<t>";
  table.header = {"<h>"};
  table.rows = {{TextTable::Field("<f>", true)}};
  table.rows[0][0].link = "a\"b";
  const std::string html = html_table(table);
  for (const char* part :
       {"&lt;t&gt;", "<th>&lt;h&gt;</th>", "<td><a href=\"a&quot;b\"><b>&lt;f&gt;</b></a></td>"}) {
    EXPECT_TRUE(contains(html, part)) << html;
  }
}

TEST(HtmlText, Base64IsThatOfTheStandard) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64(std::string("\xFF\xFE\x00", 3)), "//4A");
}

TEST(FeatureStore, GivesBackTheFeaturesOfAFrame) {
  const TempFolder folder;
  FeatureStore store;
  std::vector<Feature> features(3);
  features[1].u_px = 7.5F;
  features[2].v_px = 2.0F;
  const std::vector<FeatureLabel> labels = {FeatureLabel::kInlier, FeatureLabel::kOutlier,
                                            FeatureLabel::kUnmatched};
  PipelineResult result;
  result.features = features;
  result.labels = labels;
  store.append(4, result);
  EXPECT_TRUE(store.read(4).empty()) << "not opened";
  store.open(folder.path());
  EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "the file has no name";
  store.append(4, PipelineResult());
  store.append(9, result);
  EXPECT_TRUE(store.read(4).empty());
  EXPECT_TRUE(store.read(5).empty());
  const std::vector<DrawnFeature> read = store.read(9);
  ASSERT_EQ(read.size(), 3U);
  EXPECT_EQ(read[1].u_px, 7.5F);
  EXPECT_EQ(read[1].label, FeatureLabel::kOutlier);
  EXPECT_EQ(read[2].v_px, 2.0F);
}

/// `outcomes`: T tracked, L lost, D damaged; a frame every 0.1 s from 10 s on.
RunResult run_of(const std::string& outcomes) {
  RunResult result;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    FrameRecord record;
    record.index = i;
    record.timestamp_s = 10.0 + 0.1 * static_cast<double>(i);
    record.outcome = outcomes[i] == 'T'   ? FrameOutcome::kTracked
                     : outcomes[i] == 'L' ? FrameOutcome::kLost
                                          : FrameOutcome::kDamaged;
    record.times.total_ms = outcomes[i] == 'D' ? 0.0 : 5.0;
    if (outcomes[i] == 'T') result.trajectory.push_back({record.timestamp_s, Pose::Identity()});
    result.records.push_back(record);
  }
  return result;
}

std::vector<std::string> chosen(const RunResult& result, std::size_t max_frames) {
  std::vector<std::string> texts;
  for (const ChosenFrame& frame : choose_frames(result, max_frames)) {
    texts.push_back(std::to_string(frame.record) + " " + frame.reason);
  }
  return texts;
}

TEST(FramePictures, ChoosesTheWorstTheLostAndAnEvenSpread) {
  RunResult result = run_of("TTDTTLTTTLLLTTTTT");
  EXPECT_EQ(chosen(result, 4),
            (std::vector<std::string>{"0 ", "5 lost for 1 frame", "9 lost for 3 frames", "16 "}));
  result.report.emplace();
  AteResult& ate = result.report->ate;
  ate.status = Status::success();
  for (const auto& [index, error_m] : {std::pair{0, 0.1}, {3, 0.4}, {5, 0.2}}) {
    TrajectoryMatch match = {};
    match.estimate_index = static_cast<std::size_t>(index);
    ate.matches.push_back(match);
    ate.errors_m.push_back(error_m);
  }
  // The fourth tracked frame is the fifth of all: two damaged or lost ones come later.
  EXPECT_EQ(chosen(result, 3), (std::vector<std::string>{"4 largest error", "5 lost for 1 frame",
                                                         "9 lost for 3 frames"}));
  EXPECT_EQ(choose_frames(result, 8).size(), 8U);
  EXPECT_TRUE(choose_frames(result, 0).empty());
  EXPECT_TRUE(choose_frames(run_of("DDD"), 8).empty());
  EXPECT_EQ(chosen(run_of("T"), 8), (std::vector<std::string>{"0 "}));
}

TEST(FramePictures, DrawFeaturesInTheColourOfTheirLabelBoxesAndMasks) {
  const std::vector<std::uint8_t> pixels(std::size_t{64} * 48, 100);
  const ImageView<const std::uint8_t> gray(pixels.data(), 64, 48);
  std::vector<std::uint8_t> mask_pixels(pixels.size(), 0);
  for (std::size_t v = 0; v < 48; ++v) {
    for (std::size_t u = 50; u < 64; ++u) mask_pixels[v * 64 + u] = 2;
  }
  const ImageView<const std::uint8_t> mask(mask_pixels.data(), 64, 48);
  const std::vector<DrawnFeature> features = {{20.0F, 20.0F, FeatureLabel::kInlier},
                                              {40.0F, 30.0F, FeatureLabel::kOutlier},
                                              {-500.0F, 1e6F, FeatureLabel::kUnmatched}};
  Detection detection;
  detection.class_name = "person";
  detection.x_min_px = 5.0;
  detection.y_min_px = 2.0;
  detection.x_max_px = 200.0;
  detection.y_max_px = 46.0;
  const std::string jpeg = overlay_jpeg(gray, mask, features, {detection});
  const cv::Mat picture =
      cv::imdecode(std::vector<unsigned char>(jpeg.begin(), jpeg.end()), cv::IMREAD_COLOR);
  ASSERT_EQ(picture.cols, 64);
  ASSERT_EQ(picture.rows, 48);
  const auto at = [&picture](int u, int v) { return picture.at<cv::Vec3b>(v, u); };
  EXPECT_GT(at(22, 20)[1], at(22, 20)[2] + 40) << "green";
  EXPECT_GT(at(42, 30)[2], at(42, 30)[1] + 40) << "red";
  EXPECT_GT(at(5, 40)[2], at(5, 40)[0] + 80) << "the box";
  EXPECT_GT(at(58, 38)[0], at(58, 38)[1] + 30) << "the mask";
  EXPECT_NEAR(at(25, 38)[0], at(25, 38)[1], 12) << "beside it";
  // A mask of another size belongs to another picture.
  const ImageView<const std::uint8_t> other(mask_pixels.data(), 32, 48);
  EXPECT_EQ(overlay_jpeg(gray, other, features, {}), overlay_jpeg(gray, {}, features, {}));
  EXPECT_TRUE(overlay_jpeg({}, {}, {}, {}).empty());
}

TEST(RunReport, ShowsReliabilityOnlyWhereItWasJudged) {
  RunResult result = run_of("TTT");
  const auto has_panel = [&result](const std::string& title) {
    for (const PlotPanel& panel : run_panels(RunInputs(), result)) {
      if (panel.title == title) return true;
    }
    return false;
  };
  EXPECT_FALSE(has_panel("Reliability of the scene"));
  EXPECT_TRUE(has_panel("Features"));
  EXPECT_FALSE(has_panel("Absolute error")) << "no ground truth";
  result.records[1].reliability = 0.7;
  result.records[1].is_good = true;
  EXPECT_TRUE(has_panel("Reliability of the scene"));
}

TEST(RunReport, IsAPageEvenOfARunThatReachedNothing) {
  const TempFolder folder;
  RunInputs inputs;
  inputs.dataset_name = "<script>";
  inputs.output_folder = folder.path();
  inputs.options.features.num_features = 77;
  RunResult result;
  result.exit_reason = "nothing <tracked>";
  std::string page = run_report_page(inputs, result, FeatureStore());
  for (const char* part : {"&lt;script&gt;", "nothing &lt;tracked&gt;", "No frame was reached",
                           "features.num_features", "<td>77</td><td>1000</td>", "</html>"}) {
    EXPECT_TRUE(contains(page, part)) << part;
  }
  EXPECT_FALSE(contains(page, "<script>"));
  for (const TextTable& table : run_tables(inputs, result)) {
    EXPECT_TRUE(contains(page, html_text(table.title)));
  }
  result = run_of("DDDD");
  page = run_report_page(inputs, result, FeatureStore());
  EXPECT_TRUE(contains(page, "No frame came to the pipeline"));
  inputs.output_folder = folder / "absent";
  page = run_report_page(inputs, result, FeatureStore());
  EXPECT_TRUE(contains(page, "There are no plots: no folder for the drawing can be made")) << page;
}

TEST(CampaignReport, HasChartTablesAndLinks) {
  const TempFolder folder;
  CampaignPlan plan;
  plan.suite = "/data/<x>";
  plan.sequences = {{"desk 'a'", std::nullopt, "/data/desk", ""},
                    {"room", std::nullopt, "/data/room", ""}};
  plan.variants = {{"baseline", "none"}, {"SP", "S,P"}};
  JobRecord record;
  record.status = JobStatus::kDone;
  record.figures = {{"ate_rmse_m", 0.5}, {"coverage_with_depth", 1.0}};
  std::vector<JobRecord> records = {record, record, failed_job("<boom>"), {}};
  records[1].figures["ate_rmse_m"] = 0.01;
  const CampaignTables tables = make_tables(plan, records);
  const std::string script = error_chart_script(plan, tables, "a.svg");
  EXPECT_TRUE(contains(script, "set logscale x")) << "0.01 and 0.5 are far apart";
  EXPECT_TRUE(contains(script, "set ytics ('desk ''a''' 0, 'room' 1)")) << script;
  const std::string page = campaign_report_page(plan, tables, records, folder.path());
  for (const char* part :
       {"data:image/svg+xml;base64,", "Failed jobs", "&lt;boom&gt;", "have not been run",
        "ATE, absolute trajectory error [m]", "Coverage, and what the errors rest on",
        "href=\"jobs/001_desk__a__baseline_r1/report.html\"", "<b>0.0100</b>", "98.00"}) {
    EXPECT_TRUE(contains(page, part)) << part;
  }
  EXPECT_FALSE(contains(page, "href=\"jobs/003")) << "a failed job has no page";
  records.assign(4, JobRecord());
  EXPECT_EQ(error_chart_script(plan, make_tables(plan, records), "a.svg"), "");
  EXPECT_TRUE(contains(campaign_report_page(plan, make_tables(plan, records), records, "/absent"),
                       "No job has an absolute error"));
}

}  // namespace
}  // namespace srslam::cli
