#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#if defined(__SSE2__) || defined(_M_X64)
#define SRSLAM_DBSCAN_SSE2 1
#include <emmintrin.h>
#endif

namespace srslam::detail {

/// Points as one array an axis. Each is readable for kLanes elements past its last point; what
/// stands there does not matter.
template <typename Scalar, int D>
using PointAxes = std::array<const Scalar*, std::size_t(D)>;

/// Points that are looked at together.
constexpr std::size_t kLanes = 4;

/// Number of bits set in four.
constexpr unsigned count_of_nibble(unsigned bits) noexcept {
  return static_cast<unsigned>(0x4332322132212110U >> (4U * bits)) & 15U;
}

/// One point against many: which of them are within eps. The squares are added in the order of the
/// axes and rounded like anywhere else in the clustering, so that every search sees the same pairs
/// as neighbours.
template <typename Scalar, int D>
class NearTest {
 public:
  using Axes = PointAxes<Scalar, D>;

  NearTest(const Axes& query_axes, std::size_t query, Scalar eps_squared) noexcept {
    for (std::size_t axis = 0; axis < std::size_t(D); ++axis) {
      query_[axis] = query_axes[axis][query];
    }
    eps_squared_ = eps_squared;
  }

  Scalar squared_distance(const Axes& points, std::size_t index) const noexcept {
    Scalar sum = 0;
    for (std::size_t axis = 0; axis < std::size_t(D); ++axis) {
      const Scalar difference = points[axis][index] - query_[axis];
      sum += difference * difference;
    }
    return sum;
  }

  /// Bit i: point `first` + i is a neighbour.
  unsigned neighbors_of_4(const Axes& points, std::size_t first) const noexcept {
    unsigned bits = 0;
    for (unsigned lane = 0; lane < kLanes; ++lane) {
      bits |= unsigned(squared_distance(points, first + lane) <= eps_squared_) << lane;
    }
    return bits;
  }

  /// The same for sixteen points.
  unsigned neighbors_of_16(const Axes& points, std::size_t first) const noexcept {
    unsigned bits = 0;
    for (unsigned block = 0; block < 4; ++block) {
      bits |= neighbors_of_4(points, first + block * kLanes) << (block * kLanes);
    }
    return bits;
  }

 private:
  std::array<Scalar, std::size_t(D)> query_{};
  Scalar eps_squared_;
};

#ifdef SRSLAM_DBSCAN_SSE2

template <int D>
class NearTest<float, D> {
 public:
  using Axes = PointAxes<float, D>;

  NearTest(const Axes& query_axes, std::size_t query, float eps_squared) noexcept
      : eps_squared_(_mm_set1_ps(eps_squared)) {
    for (std::size_t axis = 0; axis < std::size_t(D); ++axis) {
      query_[axis] = _mm_set1_ps(query_axes[axis][query]);
    }
  }

  float squared_distance(const Axes& points, std::size_t index) const noexcept {
    float sum = 0;
    for (std::size_t axis = 0; axis < std::size_t(D); ++axis) {
      const float difference = points[axis][index] - _mm_cvtss_f32(query_[axis]);
      sum += difference * difference;
    }
    return sum;
  }

  unsigned neighbors_of_4(const Axes& points, std::size_t first) const noexcept {
    return unsigned(_mm_movemask_ps(compare(points, first)));
  }

  unsigned neighbors_of_16(const Axes& points, std::size_t first) const noexcept {
    const auto four = [&](std::size_t block) {
      return _mm_castps_si128(compare(points, first + block * kLanes));
    };
    const __m128i low = _mm_packs_epi32(four(0), four(1));
    const __m128i high = _mm_packs_epi32(four(2), four(3));
    return unsigned(_mm_movemask_epi8(_mm_packs_epi16(low, high)));
  }

 private:
  __m128 compare(const Axes& points, std::size_t first) const noexcept {
    __m128 sum = square(_mm_sub_ps(_mm_loadu_ps(points[0] + first), query_[0]));
    for (std::size_t axis = 1; axis < std::size_t(D); ++axis) {
      sum = _mm_add_ps(sum, square(_mm_sub_ps(_mm_loadu_ps(points[axis] + first), query_[axis])));
    }
    return _mm_cmple_ps(sum, eps_squared_);
  }
  static __m128 square(__m128 x) noexcept { return _mm_mul_ps(x, x); }

  __m128 query_[std::size_t(D)] = {};
  __m128 eps_squared_;
};

template <int D>
class NearTest<double, D> {
 public:
  using Axes = PointAxes<double, D>;

  NearTest(const Axes& query_axes, std::size_t query, double eps_squared) noexcept
      : eps_squared_(_mm_set1_pd(eps_squared)) {
    for (std::size_t axis = 0; axis < std::size_t(D); ++axis) {
      query_[axis] = _mm_set1_pd(query_axes[axis][query]);
    }
  }

  double squared_distance(const Axes& points, std::size_t index) const noexcept {
    double sum = 0;
    for (std::size_t axis = 0; axis < std::size_t(D); ++axis) {
      const double difference = points[axis][index] - _mm_cvtsd_f64(query_[axis]);
      sum += difference * difference;
    }
    return sum;
  }

  unsigned neighbors_of_4(const Axes& points, std::size_t first) const noexcept {
    return unsigned(_mm_movemask_ps(compare(points, first)));
  }

  unsigned neighbors_of_16(const Axes& points, std::size_t first) const noexcept {
    const auto four = [&](std::size_t block) {
      return _mm_castps_si128(compare(points, first + block * kLanes));
    };
    const __m128i low = _mm_packs_epi32(four(0), four(1));
    const __m128i high = _mm_packs_epi32(four(2), four(3));
    return unsigned(_mm_movemask_epi8(_mm_packs_epi16(low, high)));
  }

 private:
  /// Two comparisons of two, each result shortened to 32 bits.
  __m128 compare(const Axes& points, std::size_t first) const noexcept {
    const __m128 low = _mm_castpd_ps(compare_2(points, first));
    const __m128 high = _mm_castpd_ps(compare_2(points, first + 2));
    return _mm_shuffle_ps(low, high, _MM_SHUFFLE(2, 0, 2, 0));
  }
  __m128d compare_2(const Axes& points, std::size_t first) const noexcept {
    __m128d sum = square(_mm_sub_pd(_mm_loadu_pd(points[0] + first), query_[0]));
    for (std::size_t axis = 1; axis < std::size_t(D); ++axis) {
      sum = _mm_add_pd(sum, square(_mm_sub_pd(_mm_loadu_pd(points[axis] + first), query_[axis])));
    }
    return _mm_cmple_pd(sum, eps_squared_);
  }
  static __m128d square(__m128d x) noexcept { return _mm_mul_pd(x, x); }

  __m128d query_[std::size_t(D)] = {};
  __m128d eps_squared_;
};

#endif

/// Bits of the lanes that lie before `end`.
constexpr unsigned lanes_before(std::size_t first, std::size_t end) noexcept {
  return end - first >= kLanes ? 15U : (1U << (end - first)) - 1U;
}

/// Neighbours among the points [begin, end), counted until `limit` is reached: the number is then
/// at least `limit`, not exact.
template <typename Scalar, int D>
unsigned count_neighbors(const NearTest<Scalar, D>& test, const PointAxes<Scalar, D>& points,
                         std::size_t begin, std::size_t end, unsigned limit,
                         std::uint64_t& num_comparisons) noexcept {
  unsigned count = 0;
  std::size_t first = begin;
  for (; first + kLanes <= end && count < limit; first += kLanes) {
    count += count_of_nibble(test.neighbors_of_4(points, first));
  }
  if (first < end && count < limit) {
    count += count_of_nibble(test.neighbors_of_4(points, first) & lanes_before(first, end));
    first = end;
  }
  num_comparisons += first - begin;
  return count;
}

/// Calls visit(index) for each neighbour among the points [begin, end), in order, until it returns
/// false; returns whether it never did.
template <typename Scalar, int D, typename Visit>
bool visit_neighbors(const NearTest<Scalar, D>& test, const PointAxes<Scalar, D>& points,
                     std::size_t begin, std::size_t end, std::uint64_t& num_comparisons,
                     const Visit& visit) noexcept {
  for (std::size_t first = begin; first < end; first += kLanes) {
    unsigned bits = test.neighbors_of_4(points, first) & lanes_before(first, end);
    for (std::size_t index = first; bits != 0; ++index, bits >>= 1U) {
      if ((bits & 1U) != 0 && !visit(index)) {
        num_comparisons += first + kLanes < end ? first + kLanes - begin : end - begin;
        return false;
      }
    }
  }
  num_comparisons += end - begin;
  return true;
}

}  // namespace srslam::detail
