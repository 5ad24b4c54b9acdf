#include "cli/report/frame_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <system_error>
#include <utility>

#include "cli/number_text.hpp"
#include "cli/report/html_text.hpp"
#include "srslam/io/detections_file.hpp"

namespace srslam::cli {
namespace {

constexpr std::size_t kMaxFrames = 8;
constexpr std::size_t kMaxLostFrames = 3;
constexpr int kJpegQuality = 80;
constexpr int kMaxWidth_px = 960;

/// Colours of the labels: blue, green, red as OpenCV takes them, and as a page does.
struct LabelColor {
  FeatureLabel label;
  cv::Vec3b bgr;
  const char* css;
  const char* meaning;
};
const std::vector<LabelColor>& label_colors() {
  static const std::vector<LabelColor> colors = {
      {FeatureLabel::kCulled, {220, 40, 200}, "#c828dc", "removed, moves by itself"},
      {FeatureLabel::kUnmatched, {235, 150, 60}, "#3c96eb", "no map point found"},
      {FeatureLabel::kOutlier, {40, 40, 230}, "#e62828", "matched, inconsistent with the pose"},
      {FeatureLabel::kInlier, {60, 205, 60}, "#3ccd3c", "matched, used for the pose"}};
  return colors;
}
const cv::Vec3b kBoxColor(0, 190, 255);
constexpr const char* kBoxCss = "#ffbe00";
const cv::Vec3b kMaskColor(230, 60, 190);
constexpr const char* kMaskCss = "#be3ce6";
const cv::Vec3b kPotentialColor(60, 230, 240);
constexpr const char* kPotentialCss = "#f0e63c";
constexpr const char* kMaskFolder = "masks";

cv::Scalar scalar(const cv::Vec3b& color) {
  return {double(color[0]), double(color[1]), double(color[2])};
}

bool seen_by_pipeline(const FrameRecord& record) {
  return record.outcome == FrameOutcome::kTracked || record.outcome == FrameOutcome::kLost ||
         record.outcome == FrameOutcome::kNotInitialized;
}

/// First record and length of every lost span, the longest first.
std::vector<std::pair<std::size_t, std::size_t>> lost_spans(const RunResult& result) {
  std::vector<std::pair<std::size_t, std::size_t>> spans;
  bool inside = false;
  for (std::size_t i = 0; i < result.records.size(); ++i) {
    const bool lost = result.records[i].outcome == FrameOutcome::kLost;
    if (lost && !inside) spans.emplace_back(i, 0);
    if (lost) ++spans.back().second;
    inside = lost;
  }
  std::stable_sort(spans.begin(), spans.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  return spans;
}

/// The dataset's own mask of a frame, 0 for what stands still; empty when it has none.
cv::Mat mask_of(const RunInputs& inputs, const FrameRecord& record) {
  const std::filesystem::path color(inputs.dataset.entry(record.index).color_file);
  const std::filesystem::path file =
      std::filesystem::path(inputs.dataset.folder()) / kMaskFolder / color.stem().concat(".png");
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return {};
  return cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
}

std::string legend(bool has_masks, bool has_culling) {
  std::string text = "<p>Features: ";
  for (const LabelColor& color : label_colors()) {
    if (color.label == FeatureLabel::kCulled && !has_culling) continue;
    text += std::string("<span class=\"key\" style=\"background:") + color.css + "\"></span>" +
            color.meaning;
  }
  if (has_culling) {
    text += std::string("<span class=\"key\" style=\"background:") + kPotentialCss +
            "\"></span>ring: may move, kept";
  }
  return text + "<span class=\"key\" style=\"background:" + kBoxCss +
         "\"></span>box: a detection with its score" +
         (has_masks ? std::string("<span class=\"key\" style=\"background:") + kMaskCss +
                          "\"></span>mask of the dataset: what moves"
                    : std::string()) +
         "</p>\n";
}

constexpr double kNoReliability = 2.0;  // above every reliability

std::string caption(const FrameRecord& record, const std::string& reason, double begin_s,
                    const std::map<double, double>& errors_m) {
  std::string text = "frame " + std::to_string(record.index) + ", " +
                     fixed_text(record.timestamp_s - begin_s, 2) + " s, " +
                     to_string(record.outcome) + ", " + std::to_string(record.num_inliers) +
                     " inliers of " + std::to_string(record.num_features) + " features";
  const auto error = errors_m.find(record.timestamp_s);
  if (error != errors_m.end()) text += ", error " + fixed_text(error->second, 4) + " m";
  if (record.is_good && record.reliability) {
    text += std::string(", ") + (*record.is_good ? "GOOD" : "BAD") + " scene, reliability " +
            fixed_text(*record.reliability, 2);
  }
  if (record.num_culled) text += ", " + std::to_string(*record.num_culled) + " removed";
  return reason.empty() ? text : text + " (" + reason + ")";
}

}  // namespace

std::map<double, double> absolute_errors_m(const RunResult& result) {
  std::map<double, double> errors_m;
  if (!result.report || !result.report->ate.status.ok()) return errors_m;
  const AteResult& ate = result.report->ate;
  for (std::size_t i = 0; i < ate.matches.size() && i < ate.errors_m.size(); ++i) {
    errors_m[result.trajectory[ate.matches[i].estimate_index].timestamp_s] = ate.errors_m[i];
  }
  return errors_m;
}

std::vector<ChosenFrame> choose_frames(const RunResult& result, std::size_t max_frames) {
  std::map<std::size_t, std::string> chosen;
  const std::map<double, double> errors_m = absolute_errors_m(result);
  std::vector<std::size_t> candidates;
  double worst_m = -1.0;
  std::size_t worst = 0;
  for (std::size_t i = 0; i < result.records.size(); ++i) {
    if (!seen_by_pipeline(result.records[i])) continue;
    candidates.push_back(i);
    const auto error = errors_m.find(result.records[i].timestamp_s);
    if (error == errors_m.end() || error->second <= worst_m) continue;
    worst_m = error->second;
    worst = i;
  }
  if (worst_m >= 0.0 && max_frames > 0) chosen[worst] = "largest error";
  const auto least_reliable = std::min_element(
      result.records.begin(), result.records.end(), [](const FrameRecord& a, const FrameRecord& b) {
        return a.reliability.value_or(kNoReliability) < b.reliability.value_or(kNoReliability);
      });
  if (least_reliable != result.records.end() && least_reliable->reliability &&
      chosen.size() < max_frames) {
    chosen.emplace(static_cast<std::size_t>(least_reliable - result.records.begin()),
                   "least reliable scene");
  }
  std::size_t num_lost = 0;
  for (const auto& [first, length] : lost_spans(result)) {
    if (num_lost == kMaxLostFrames || chosen.size() >= max_frames) break;
    chosen[first] = "lost for " + std::to_string(length) + (length == 1 ? " frame" : " frames");
    ++num_lost;
  }
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(),
                                  [&chosen](std::size_t i) { return chosen.count(i) > 0; }),
                   candidates.end());
  const std::size_t num_even = max_frames - std::min(max_frames, chosen.size());
  for (std::size_t k = 0; k < num_even && !candidates.empty(); ++k) {
    const std::size_t place = num_even == 1 ? 0 : k * (candidates.size() - 1) / (num_even - 1);
    chosen.emplace(candidates[place], std::string());
  }
  std::vector<ChosenFrame> frames;
  frames.reserve(chosen.size());
  for (const auto& [record, reason] : chosen) frames.push_back({record, reason});
  return frames;
}

std::string overlay_jpeg(ImageView<const std::uint8_t> gray, ImageView<const std::uint8_t> mask,
                         const std::vector<DrawnFeature>& features,
                         const std::vector<Detection>& detections) {
  if (gray.empty()) return {};
  cv::Mat picture(gray.height_px, gray.width_px, CV_8UC3);
  const bool masked = mask.width_px == gray.width_px && mask.height_px == gray.height_px;
  for (int v = 0; v < gray.height_px; ++v) {
    for (int u = 0; u < gray.width_px; ++u) {
      const std::uint8_t level = gray(u, v);
      cv::Vec3b& pixel = picture.at<cv::Vec3b>(v, u);
      pixel = {level, level, level};
      if (!masked || mask(u, v) == 0) continue;
      for (int c = 0; c < 3; ++c) {
        pixel[c] = static_cast<std::uint8_t>((pixel[c] * 2 + kMaskColor[c]) / 3);
      }
    }
  }
  // Inliers last, on top of the others.
  for (const LabelColor& color : label_colors()) {
    for (const DrawnFeature& feature : features) {
      if (feature.label != color.label) continue;
      cv::circle(picture, {cvRound(feature.u_px), cvRound(feature.v_px)}, 2, scalar(color.bgr), 1,
                 cv::LINE_AA);
      if (!feature.potential || feature.label == FeatureLabel::kCulled) continue;
      cv::circle(picture, {cvRound(feature.u_px), cvRound(feature.v_px)}, 5,
                 scalar(kPotentialColor), 1, cv::LINE_AA);
    }
  }
  for (const Detection& detection : detections) {
    const cv::Point top_left(cvRound(detection.x_min_px), cvRound(detection.y_min_px));
    const cv::Point bottom_right(cvRound(detection.x_max_px), cvRound(detection.y_max_px));
    cv::rectangle(picture, top_left, bottom_right, scalar(kBoxColor), 2);
    const std::string text = detection.class_name + " " + fixed_text(detection.score, 2);
    cv::putText(picture, text, {std::max(top_left.x, 0) + 3, std::max(top_left.y, 0) + 15},
                cv::FONT_HERSHEY_SIMPLEX, 0.5, scalar(kBoxColor), 1, cv::LINE_AA);
  }
  if (picture.cols > kMaxWidth_px) {
    const double scale = static_cast<double>(kMaxWidth_px) / picture.cols;
    cv::resize(picture, picture, {}, scale, scale, cv::INTER_AREA);
  }
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality})) return {};
  return {bytes.begin(), bytes.end()};
}

std::string frame_pictures_html(const RunInputs& inputs, const RunResult& result,
                                const FeatureStore& features) {
  const std::map<double, double> errors_m = absolute_errors_m(result);
  std::string pictures;
  bool has_masks = false;
  for (const ChosenFrame& chosen : choose_frames(result, kMaxFrames)) {
    const FrameRecord& record = result.records[chosen.record];
    FrameReader reader(inputs.dataset, inputs.camera, record.index, record.index + 1, 0);
    LoadedFrame loaded;
    if (!reader.next(&loaded) || !loaded.status.ok()) continue;
    std::vector<Detection> detections;
    const std::size_t found =
        find_detections(inputs.detections, loaded.timestamp_s, kDetectionTolerance_s);
    if (found < inputs.detections.size()) detections = inputs.detections[found].detections;
    const cv::Mat mask = mask_of(inputs, record);
    has_masks = has_masks || !mask.empty();
    const std::string jpeg = overlay_jpeg(loaded.gray.view(), {mask.data, mask.cols, mask.rows},
                                          features.read(record.index), detections);
    if (jpeg.empty()) continue;
    pictures +=
        html_picture("image/jpeg", jpeg, "frame with its features and detections",
                     caption(record, chosen.reason, result.records.front().timestamp_s, errors_m));
  }
  std::string html = "<h2>Frames</h2>\n";
  if (pictures.empty()) return html + "<p>No frame came to the pipeline.</p>\n";
  return html + legend(has_masks, inputs.options.culling.enabled) + "<div class=\"grid\">\n" +
         pictures + "</div>\n";
}

}  // namespace srslam::cli
