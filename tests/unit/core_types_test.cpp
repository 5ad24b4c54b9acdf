// Status, views, grid, descriptors: the small types that everything else speaks.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include "srslam/core/array_view.hpp"
#include "srslam/core/detection.hpp"
#include "srslam/core/feature.hpp"
#include "srslam/core/grid.hpp"
#include "srslam/core/image_view.hpp"
#include "srslam/core/nearest_rank.hpp"
#include "srslam/core/status.hpp"
#include "support/constants.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::for_each_seed;
using test::kInf;
using test::kNan;
using test::Rng;

// ---------------------------------------------------------------------------------------- status

TEST(Status, StartsFailedAndSaysWhy) {
  const Status status;
  EXPECT_FALSE(status.ok());
  EXPECT_EQ(status.code, StatusCode::kNotRun);
  EXPECT_STREQ(status.reason, "not run");
}

TEST(Status, SuccessAndFailure) {
  static_assert(Status::success().ok(), "usable in constant expressions");
  EXPECT_STREQ(Status::success().reason, "");
  const Status status = Status::failure(StatusCode::kDegenerate, "all points on a line");
  EXPECT_FALSE(status.ok());
  EXPECT_EQ(status.code, StatusCode::kDegenerate);
  EXPECT_STREQ(status.reason, "all points on a line");
}

TEST(Status, EveryCodeHasItsOwnName) {
  std::vector<std::string> names;
  for (int code = 0; code <= static_cast<int>(StatusCode::kUnsupported); ++code) {
    const std::string name = to_string(static_cast<StatusCode>(code));
    EXPECT_NE(name, "unknown") << code;
    for (const std::string& other : names) EXPECT_NE(name, other);
    names.push_back(name);
  }
  EXPECT_EQ(names.front(), "ok");
  EXPECT_EQ(names.back(), "unsupported");
  EXPECT_STREQ(to_string(static_cast<StatusCode>(250)), "unknown");
}

TEST(FileStatus, MessageHasThePartsThatExist) {
  EXPECT_EQ(FileStatus{}.message(), "not run");
  EXPECT_FALSE(FileStatus{}.ok());
  EXPECT_TRUE(FileStatus::success().ok());
  EXPECT_EQ(FileStatus::success().message(), "");
  EXPECT_EQ(FileStatus::failure(StatusCode::kCorruptData, "a.txt", 7, "bad number").message(),
            "a.txt:7: bad number");
  EXPECT_EQ(FileStatus::failure(StatusCode::kNotFound, "a.txt", 0, "no such file").message(),
            "a.txt: no such file");
  EXPECT_EQ(FileStatus::failure(StatusCode::kNotFound, "", 0, "no such preset").message(),
            "no such preset");
}

// ------------------------------------------------------------------------------------ array view

int sum(ArrayView<const int> values) {
  int total = 0;
  for (const int value : values) total += value;
  return total;
}

TEST(ArrayView, ViewsVectorsAndArraysWithoutCopying) {
  std::vector<int> values = {1, 2, 3};
  const ArrayView<int> view = values;
  EXPECT_EQ(view.data, values.data());
  EXPECT_EQ(view.size, 3U);
  view[1] = 20;
  EXPECT_EQ(values[1], 20);
  EXPECT_EQ(sum(values), 24);
  EXPECT_EQ(sum(view), 24) << "a mutable view reads as a constant one";
  EXPECT_EQ(sum(std::vector<int>{4, 5}), 9) << "a temporary lives until the call returns";
  const std::array<int, 2> array = {7, 8};
  EXPECT_EQ(sum({array.data(), array.size()}), 15);
}

TEST(ArrayView, EmptyByDefault) {
  const ArrayView<const int> view;
  EXPECT_TRUE(view.empty());
  EXPECT_EQ(view.begin(), view.end());
  EXPECT_EQ(sum({}), 0);
  EXPECT_EQ(sum(std::vector<int>{}), 0);
}

TEST(ArrayView, ConstantDataStaysConstant) {
  static_assert(std::is_convertible_v<const std::vector<int>&, ArrayView<const int>>, "");
  static_assert(std::is_convertible_v<std::vector<int>&, ArrayView<int>>, "");
  static_assert(!std::is_convertible_v<const std::vector<int>&, ArrayView<int>>, "");
  static_assert(!std::is_convertible_v<ArrayView<const int>, ArrayView<int>>, "");
  static_assert(std::is_trivially_copyable_v<ArrayView<const int>>, "passed by value");
}

// ------------------------------------------------------------------------------------ image view

TEST(ImageView, PackedRows) {
  std::vector<std::uint8_t> pixels = {0, 1, 2, 3, 4, 5};
  const ImageView<std::uint8_t> view(pixels.data(), 3, 2);
  EXPECT_TRUE(view.validate().ok());
  EXPECT_EQ(view.stride_bytes, 3);
  EXPECT_EQ(view(0, 0), 0);
  EXPECT_EQ(view(2, 0), 2);
  EXPECT_EQ(view(0, 1), 3);
  EXPECT_EQ(view(2, 1), 5);
  view(1, 1) = 40;
  EXPECT_EQ(pixels[4], 40);
}

TEST(ImageView, PaddedRowsOfWidePixels) {
  // Rows of 3 floats, 5 apart.
  std::vector<float> pixels(10);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<float>(i);
  const ImageView<const float> view(pixels.data(), 3, 2,
                                    static_cast<std::ptrdiff_t>(5 * sizeof(float)));
  EXPECT_TRUE(view.validate().ok());
  EXPECT_EQ(view(0, 1), 5.0F);
  EXPECT_EQ(view(2, 1), 7.0F);
  EXPECT_EQ(view.row(1), pixels.data() + 5);
}

TEST(ImageView, SubImageSharesTheStorage) {
  ImageBuffer<Bgr8> buffer;
  buffer.resize(8, 6);
  for (int v = 0; v < 6; ++v) {
    for (int u = 0; u < 8; ++u) buffer.view()(u, v).r = static_cast<std::uint8_t>(10 * v + u);
  }
  const ImageView<Bgr8> whole = buffer.view();
  const ImageView<Bgr8> part(&whole(2, 3), 4, 2, whole.stride_bytes);
  EXPECT_TRUE(part.validate().ok());
  for (int v = 0; v < part.height_px; ++v) {
    for (int u = 0; u < part.width_px; ++u) EXPECT_EQ(part(u, v).r, whole(u + 2, v + 3).r);
  }
  part(0, 0).b = 99;
  EXPECT_EQ(whole(2, 3).b, 99);
  const ImageView<const Bgr8> constant = part;
  EXPECT_EQ(constant.data, part.data);
  EXPECT_EQ(constant.stride_bytes, part.stride_bytes);
  static_assert(!std::is_convertible_v<ImageView<const Bgr8>, ImageView<Bgr8>>, "");
}

TEST(ImageView, ContainsExactlyItsPixels) {
  const std::uint8_t pixels[6] = {};
  const ImageView<const std::uint8_t> view(pixels, 3, 2);
  EXPECT_TRUE(view.contains(0, 0));
  EXPECT_TRUE(view.contains(2, 1));
  EXPECT_FALSE(view.contains(3, 0));
  EXPECT_FALSE(view.contains(0, 2));
  EXPECT_FALSE(view.contains(-1, 0));
  EXPECT_FALSE(view.contains(0, -1));
}

TEST(ImageView, ValidateNamesWhatIsWrong) {
  float pixel = 0.0F;
  const std::ptrdiff_t row = sizeof(float);
  EXPECT_TRUE((ImageView<float>(&pixel, 1, 1).validate().ok()));
  for (const ImageView<float>& bad :
       {ImageView<float>(), ImageView<float>(nullptr, 4, 4), ImageView<float>(&pixel, 0, 1),
        ImageView<float>(&pixel, 1, 0), ImageView<float>(&pixel, -1, 1),
        ImageView<float>(&pixel, 1, -1), ImageView<float>(&pixel, 1, 1, row - 1),
        ImageView<float>(&pixel, 1, 1, -row), ImageView<float>(&pixel, 1, 1, row + 1)}) {
    const Status status = bad.validate();
    EXPECT_EQ(status.code, StatusCode::kInvalidArgument);
    EXPECT_STRNE(status.reason, "");
  }
  EXPECT_TRUE(ImageView<float>().empty());
  EXPECT_TRUE((ImageView<float>(&pixel, 0, 1).empty()));
  EXPECT_FALSE((ImageView<float>(&pixel, 1, 1).empty()));
}

TEST(ImageBuffer, KeepsItsAllocationWhenItShrinks) {
  ImageBuffer<float> buffer;
  EXPECT_TRUE(buffer.empty());
  EXPECT_FALSE(buffer.view().validate().ok());
  buffer.resize(64, 48);
  EXPECT_TRUE(buffer.view().validate().ok());
  const float* storage = buffer.pixels.data();
  buffer.resize(32, 24);
  EXPECT_EQ(buffer.view().width_px, 32);
  EXPECT_EQ(buffer.pixels.size(), 32U * 24U);
  buffer.resize(64, 48);
  EXPECT_EQ(buffer.pixels.data(), storage);
}

TEST(ImageBuffer, ImpossibleSizesGiveAnEmptyBuffer) {
  ImageBuffer<float> buffer;
  for (const auto& size : {std::array<int, 2>{-1, 5}, {5, -1}, {-3, -3}, {0, 5}, {5, 0}}) {
    buffer.resize(4, 4);
    buffer.resize(size[0], size[1]);
    EXPECT_TRUE(buffer.empty());
    EXPECT_EQ(buffer.width_px, 0);
    EXPECT_EQ(buffer.height_px, 0);
    EXPECT_FALSE(buffer.view().validate().ok());
  }
}

// ------------------------------------------------------------------------------------------ grid

TEST(GridCell, RowMajorThirds) {
  // 640 / 3 = 213.3, 480 / 3 = 160.
  EXPECT_EQ(grid_cell(0, 0, 640, 480), 0);
  EXPECT_EQ(grid_cell(213, 0, 640, 480), 0);
  EXPECT_EQ(grid_cell(214, 0, 640, 480), 1);
  EXPECT_EQ(grid_cell(426, 0, 640, 480), 1);
  EXPECT_EQ(grid_cell(427, 0, 640, 480), 2);
  EXPECT_EQ(grid_cell(639, 0, 640, 480), 2);
  EXPECT_EQ(grid_cell(0, 159, 640, 480), 0);
  EXPECT_EQ(grid_cell(0, 160, 640, 480), 3);
  EXPECT_EQ(grid_cell(0, 319, 640, 480), 3);
  EXPECT_EQ(grid_cell(0, 320, 640, 480), 6);
  EXPECT_EQ(grid_cell(639, 479, 640, 480), 8);
  EXPECT_EQ(grid_cell(320, 240, 640, 480), 4);
}

TEST(GridCell, HalfAPixelAroundTheOutermostCentresIsInside) {
  EXPECT_EQ(grid_cell(-0.5, -0.5, 640, 480), 0);
  EXPECT_EQ(grid_cell(639.499, 479.499, 640, 480), 8);
  EXPECT_EQ(grid_cell(-0.501, 100, 640, 480), -1);
  EXPECT_EQ(grid_cell(100, -0.501, 640, 480), -1);
  EXPECT_EQ(grid_cell(639.5, 100, 640, 480), -1);
  EXPECT_EQ(grid_cell(100, 479.5, 640, 480), -1);
}

TEST(GridCell, NothingIsInsideAnImageWithoutPixelsOrAtNoPlace) {
  EXPECT_EQ(grid_cell(0, 0, 0, 480), -1);
  EXPECT_EQ(grid_cell(0, 0, 640, 0), -1);
  EXPECT_EQ(grid_cell(0, 0, -640, -480), -1);
  for (const double bad : {kNan, kInf, -kInf, 1e300, -1e300}) {
    EXPECT_EQ(grid_cell(bad, 100, 640, 480), -1) << bad;
    EXPECT_EQ(grid_cell(100, bad, 640, 480), -1) << bad;
  }
}

TEST(GridCell, TinyImages) {
  EXPECT_EQ(grid_cell(0, 0, 1, 1), 0);
  for (int v = 0; v < 3; ++v) {
    for (int u = 0; u < 3; ++u) EXPECT_EQ(grid_cell(u, v, 3, 3), 3 * v + u);
  }
}

// The rule of the paper's maths: column min(2, floor(3 u / W)), row alike.
TEST(GridCell, EqualsTheFormulaOnEveryPixel) {
  for (const auto& size : {std::array<int, 2>{640, 480}, {320, 240}, {641, 479}, {7, 5}}) {
    const int width = size[0];
    const int height = size[1];
    std::array<int, kGridCells> counts = {};
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const int expected = std::min(2, 3 * v / height) * 3 + std::min(2, 3 * u / width);
        ASSERT_EQ(grid_cell(u, v, width, height), expected) << u << " " << v;
        ++counts[static_cast<std::size_t>(expected)];
      }
    }
    for (const int count : counts) EXPECT_GT(count, 0);
  }
}

TEST(GridCell, CountsDoNotDependOnTheOrderOfThePoints) {
  for_each_seed(20, [](Rng& rng) {
    std::vector<std::array<double, 2>> points(200);
    for (auto& point : points) {
      point = {rng.uniform(-50.0, 690.0), rng.uniform(-50.0, 530.0)};
    }
    const auto count = [&] {
      std::array<int, kGridCells + 1> counts = {};
      for (const auto& point : points) {
        ++counts[static_cast<std::size_t>(grid_cell(point[0], point[1], 640, 480) + 1)];
      }
      return counts;
    };
    const auto before = count();
    for (std::size_t i = points.size() - 1; i > 0; --i) {
      std::swap(points[i],
                points[static_cast<std::size_t>(rng.uniform_int(0, static_cast<int>(i)))]);
    }
    EXPECT_EQ(count(), before);
    EXPECT_GT(before[0], 0) << "some points were outside";
  });
}

TEST(GridCell, MirroringTheImageMirrorsTheGrid) {
  for_each_seed(20, [](Rng& rng) {
    for (int i = 0; i < 200; ++i) {
      // Points near the lines between cells belong to different sides after mirroring, because a
      // cell contains its left edge: [0, W/3) against (W - 1 - W/3, W - 1].
      const double u = rng.uniform(0.0, 639.0);
      const double v = rng.uniform(0.0, 479.0);
      const auto near_line = [](double x, double size) {
        return std::abs(x - size / 3.0) < 1.0 || std::abs(x - 2.0 * size / 3.0) < 1.0;
      };
      if (near_line(u, 640.0) || near_line(639.0 - u, 640.0) || near_line(v, 480.0)) continue;
      const int cell = grid_cell(u, v, 640, 480);
      const int mirrored = grid_cell(639.0 - u, v, 640, 480);
      EXPECT_EQ(mirrored / 3, cell / 3);
      EXPECT_EQ(mirrored % 3, 2 - cell % 3);
    }
  });
}

TEST(GridCell, IsAConstantExpression) {
  static_assert(grid_cell(639.0, 479.0, 640, 480) == 8, "");
  static_assert(grid_cell(-1.0, 0.0, 640, 480) == -1, "");
  static_assert(std::tuple_size_v<GridArray<int>> == 9, "");
  SUCCEED();
}

// ------------------------------------------------------------------------------------ descriptors

int bit_loop_distance(const BinaryDescriptor& a, const BinaryDescriptor& b) {
  int distance = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (unsigned bit = 0; bit < 64; ++bit) {
      distance += static_cast<int>(((a[i] >> bit) ^ (b[i] >> bit)) & 1U);
    }
  }
  return distance;
}

BinaryDescriptor random_descriptor(Rng& rng) {
  return {rng.next(), rng.next(), rng.next(), rng.next()};
}

TEST(HammingDistance, ExtremesAndEverySingleBit) {
  const BinaryDescriptor zero = {};
  const BinaryDescriptor ones = {~0ULL, ~0ULL, ~0ULL, ~0ULL};
  EXPECT_EQ(hamming_distance(zero, zero), 0);
  EXPECT_EQ(hamming_distance(zero, ones), 256);
  for (std::size_t bit = 0; bit < 256; ++bit) {
    BinaryDescriptor one = {};
    one[bit / 64] = 1ULL << (bit % 64);
    EXPECT_EQ(hamming_distance(zero, one), 1) << bit;
    EXPECT_EQ(hamming_distance(ones, one), 255) << bit;
  }
}

TEST(HammingDistance, EqualsABitLoopAndIsAMetric) {
  for_each_seed(500, [](Rng& rng) {
    const BinaryDescriptor a = random_descriptor(rng);
    const BinaryDescriptor b = random_descriptor(rng);
    const BinaryDescriptor c = random_descriptor(rng);
    EXPECT_EQ(hamming_distance(a, b), bit_loop_distance(a, b));
    EXPECT_EQ(hamming_distance(a, b), hamming_distance(b, a));
    EXPECT_EQ(hamming_distance(a, a), 0);
    EXPECT_LE(hamming_distance(a, c), hamming_distance(a, b) + hamming_distance(b, c));
  });
}

TEST(Feature, DefaultsAreNeutral) {
  const Feature feature;
  EXPECT_EQ(feature.octave, 0);
  EXPECT_EQ(feature.scale, 1.0F);
  static_assert(std::is_trivially_copyable_v<Feature>, "copied in bulk");
  static_assert(sizeof(BinaryDescriptor) == 32, "256 bits");
}

TEST(FrameDetections, LookedAtAndEmptyIsAState) {
  FrameDetections frame;
  frame.timestamp_s = 1.5;
  EXPECT_TRUE(frame.detections.empty());
  frame.detections.push_back({"person", 0.9, 1.0, 2.0, 3.0, 4.0});
  EXPECT_EQ(frame.detections[0].class_name, "person");
  EXPECT_EQ(frame.detections[0].y_max_px, 4.0);
}

// ----------------------------------------------------------------------------------- nearest rank

TEST(NearestRank, HandComputed) {
  std::vector<double> values;
  for (int i = 1; i <= 20; ++i) values.push_back(i);
  EXPECT_EQ(nearest_rank(values, 95.0), 19.0);
  EXPECT_EQ(nearest_rank(values, 95.1), 20.0);
  EXPECT_EQ(nearest_rank(values, 50.0), 10.0);
  EXPECT_EQ(nearest_rank(values, 0.0), 1.0);
  EXPECT_EQ(nearest_rank(values, 100.0), 20.0);
  EXPECT_EQ(nearest_rank({values.data(), 1}, 99.0), 1.0);
  EXPECT_TRUE(std::isnan(nearest_rank(ArrayView<const double>(), 50.0)));
}

// By its definition: the smallest value that so many do not exceed.
TEST(NearestRank, EqualsItsDefinition) {
  for_each_seed(50, [](Rng& rng) {
    std::vector<double> values(static_cast<std::size_t>(rng.uniform_int(1, 200)));
    for (double& value : values) value = rng.uniform_int(0, 30);
    std::sort(values.begin(), values.end());
    const int percent = rng.uniform_int(1, 100);
    double expected = values.back();
    for (auto value = values.rbegin(); value != values.rend(); ++value) {
      const auto not_above = std::upper_bound(values.begin(), values.end(), *value);
      if (100 * (not_above - values.begin()) >= percent * std::ptrdiff_t(values.size())) {
        expected = *value;
      }
    }
    EXPECT_EQ(nearest_rank(values, percent), expected);
  });
}

}  // namespace
}  // namespace srslam
