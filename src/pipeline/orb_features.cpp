#include "pipeline/orb_features.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <opencv2/features2d.hpp>

#include "pipeline/constants.hpp"
#include "srslam/interop/corner_pyramid.hpp"
#include "srslam/interop/opencv_views.hpp"

namespace srslam::detail {
namespace {

// ORB samples a 31×31 patch, rotated; a keypoint needs that much image around it.
constexpr int kPatchSize = 31;
constexpr int kPatchRadius = kPatchSize / 2;
constexpr int kBorder = 19;

/// Half width of the circular patch at each row offset from its centre.
std::array<int, kPatchRadius + 1> make_patch_half_widths() {
  std::array<int, kPatchRadius + 1> half_widths{};
  for (int dv = 0; dv <= kPatchRadius; ++dv) {
    half_widths[static_cast<std::size_t>(dv)] =
        static_cast<int>(std::sqrt(double(kPatchRadius * kPatchRadius - dv * dv)));
  }
  return half_widths;
}

/// Orientation of the patch around (u, v): direction from the centre to the intensity centroid.
float patch_angle_rad(const cv::Mat& image, int u, int v) {
  static const std::array<int, kPatchRadius + 1> kHalfWidths = make_patch_half_widths();
  int moment_u = 0;
  int moment_v = 0;
  const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
  const std::uint8_t* centre = image.ptr<std::uint8_t>(v) + u;
  for (int du = -kPatchRadius; du <= kPatchRadius; ++du) moment_u += du * centre[du];
  for (int dv = 1; dv <= kPatchRadius; ++dv) {
    const int half_width = kHalfWidths[static_cast<std::size_t>(dv)];
    const std::uint8_t* below = centre + dv * step;
    const std::uint8_t* above = centre - dv * step;
    int row_difference = 0;
    for (int du = -half_width; du <= half_width; ++du) {
      const int low = below[du];
      const int high = above[du];
      row_difference += low - high;
      moment_u += du * (low + high);
    }
    moment_v += dv * row_difference;
  }
  const double angle = std::atan2(double(moment_v), double(moment_u));
  return static_cast<float>(angle < 0.0 ? angle + kTwoPi : angle);
}

}  // namespace

struct OrbExtractor::Impl {
  explicit Impl(const FeatureOptions& options) : corners(options, kBorder) {
    for (const CornerPyramid::Level& level : corners.levels()) scales.push_back(level.scale);
    // One level only: the pyramid is ours, each level is described as an image of its own.
    descriptor =
        cv::ORB::create(options.num_features, 1.2F, 1, kBorder - CornerPyramid::kFastMargin, 0, 2,
                        cv::ORB::FAST_SCORE, kPatchSize, options.fast_threshold);
  }

  CornerPyramid corners;
  std::vector<float> scales;
  cv::Ptr<cv::ORB> descriptor;
  cv::Mat descriptors;  // reused from call to call
};

OrbExtractor::OrbExtractor(const FeatureOptions& options)
    : impl_(std::make_unique<Impl>(options)) {}

OrbExtractor::~OrbExtractor() = default;

const std::vector<float>& OrbExtractor::level_scales() const { return impl_->scales; }

void OrbExtractor::extract(const ImageView<const std::uint8_t>& gray,
                           const ImageView<const std::uint8_t>& mask, OrbFeatures* output) {
  output->features.clear();
  output->descriptors.clear();
  impl_->corners.detect(gray, mask);
  const ArrayView<CornerPyramid::Level> levels = impl_->corners.levels();
  for (std::size_t i = 0; i < levels.size; ++i) {
    CornerPyramid::Level& level = levels[i];
    if (level.corners.empty()) continue;
    for (cv::KeyPoint& keypoint : level.corners) {
      const float angle =
          patch_angle_rad(level.image, cvRound(keypoint.pt.x), cvRound(keypoint.pt.y));
      keypoint.angle = static_cast<float>(angle * 360.0 / kTwoPi);
      keypoint.octave = 0;
      Feature feature;
      feature.u_px = level.to_level0_u(keypoint.pt.x);
      feature.v_px = level.to_level0_v(keypoint.pt.y);
      feature.response = keypoint.response;
      feature.angle_rad = angle;
      feature.scale = level.scale;
      feature.octave = static_cast<std::int32_t>(i);
      output->features.push_back(feature);
    }
    // Keypoints keep kBorder from the edge, so compute() drops none and rows match the corners.
    impl_->descriptor->compute(level.image, level.corners, impl_->descriptors);
    for (int row = 0; row < impl_->descriptors.rows; ++row) {
      BinaryDescriptor descriptor;
      static_assert(sizeof(descriptor) == 32, "ORB descriptors have 256 bits");
      std::memcpy(descriptor.data(), impl_->descriptors.ptr(row), sizeof(descriptor));
      output->descriptors.push_back(descriptor);
    }
  }
}

}  // namespace srslam::detail
