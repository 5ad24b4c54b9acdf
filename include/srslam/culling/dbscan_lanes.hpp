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

#ifdef SRSLAM_DBSCAN_SSE2

/// What SSE2 calls the operations on each type: a register of coordinates, and a comparison of four
/// points whose answer is four times 32 bits, all set for a neighbour.
template <typename Scalar>
struct LaneOperations;

template <>
struct LaneOperations<float> {
  using Value = __m128;
  static Value broadcast(float x) noexcept { return _mm_set1_ps(x); }
  static float lowest(Value x) noexcept { return _mm_cvtss_f32(x); }

  template <int D>
  static __m128 compare(const PointAxes<float, D>& points, std::size_t first, const Value* query,
                        Value eps_squared) noexcept {
    __m128 sum = square(_mm_sub_ps(_mm_loadu_ps(points[0] + first), query[0]));
    for (std::size_t axis = 1; axis < std::size_t(D); ++axis) {
      sum = _mm_add_ps(sum, square(_mm_sub_ps(_mm_loadu_ps(points[axis] + first), query[axis])));
    }
    return _mm_cmple_ps(sum, eps_squared);
  }
  static Value square(Value x) noexcept { return _mm_mul_ps(x, x); }
};

template <>
struct LaneOperations<double> {
  using Value = __m128d;
  static Value broadcast(double x) noexcept { return _mm_set1_pd(x); }
  static double lowest(Value x) noexcept { return _mm_cvtsd_f64(x); }

  /// Two comparisons of two, each answer shortened to 32 bits.
  template <int D>
  static __m128 compare(const PointAxes<double, D>& points, std::size_t first, const Value* query,
                        Value eps_squared) noexcept {
    const __m128 low = _mm_castpd_ps(compare_2<D>(points, first, query, eps_squared));
    const __m128 high = _mm_castpd_ps(compare_2<D>(points, first + 2, query, eps_squared));
    return _mm_shuffle_ps(low, high, _MM_SHUFFLE(2, 0, 2, 0));
  }
  template <int D>
  static __m128d compare_2(const PointAxes<double, D>& points, std::size_t first,
                           const Value* query, Value eps_squared) noexcept {
    __m128d sum = square(_mm_sub_pd(_mm_loadu_pd(points[0] + first), query[0]));
    for (std::size_t axis = 1; axis < std::size_t(D); ++axis) {
      sum = _mm_add_pd(sum, square(_mm_sub_pd(_mm_loadu_pd(points[axis] + first), query[axis])));
    }
    return _mm_cmple_pd(sum, eps_squared);
  }
  static Value square(Value x) noexcept { return _mm_mul_pd(x, x); }
};

#endif

/// One point against many: which of them are within eps. The squares are added in the order of the
/// axes and rounded like anywhere else in the clustering, so that every search sees the same pairs
/// as neighbours.
template <typename Scalar, int D>
class NearTest {
 public:
  using Axes = PointAxes<Scalar, D>;

  NearTest(const Axes& query_axes, std::size_t query, Scalar eps_squared) noexcept
      : eps_squared_(broadcast(eps_squared)) {
    for (std::size_t axis = 0; axis < std::size_t(D); ++axis) {
      query_[axis] = broadcast(query_axes[axis][query]);
    }
  }

  Scalar squared_distance(const Axes& points, std::size_t index) const noexcept {
    Scalar sum = 0;
    for (std::size_t axis = 0; axis < std::size_t(D); ++axis) {
      const Scalar difference = points[axis][index] - lowest(query_[axis]);
      sum += difference * difference;
    }
    return sum;
  }

#ifdef SRSLAM_DBSCAN_SSE2
  /// Bit i: point `first` + i is a neighbour.
  unsigned neighbors_of_4(const Axes& points, std::size_t first) const noexcept {
    return unsigned(_mm_movemask_ps(compare(points, first)));
  }

  /// The same for sixteen points.
  unsigned neighbors_of_16(const Axes& points, std::size_t first) const noexcept {
    const auto four = [&](std::size_t block) {
      return _mm_castps_si128(compare(points, first + block * kLanes));
    };
    const __m128i low = _mm_packs_epi32(four(0), four(1));
    const __m128i high = _mm_packs_epi32(four(2), four(3));
    return unsigned(_mm_movemask_epi8(_mm_packs_epi16(low, high)));
  }

 private:
  using Operations = LaneOperations<Scalar>;
  using Value = typename Operations::Value;
  static Value broadcast(Scalar x) noexcept { return Operations::broadcast(x); }
  static Scalar lowest(Value x) noexcept { return Operations::lowest(x); }
  __m128 compare(const Axes& points, std::size_t first) const noexcept {
    return Operations::template compare<D>(points, first, query_, eps_squared_);
  }
#else
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
  using Value = Scalar;
  static Value broadcast(Scalar x) noexcept { return x; }
  static Scalar lowest(Value x) noexcept { return x; }
#endif

  Value query_[std::size_t(D)] = {};
  Value eps_squared_;
};

/// Rows and columns of 16 by 16 bits exchanged: bit i of row k becomes bit k of row i.
inline std::array<std::uint16_t, 16> transposed(
    const std::array<std::uint16_t, 16>& rows) noexcept {
  std::array<std::uint16_t, 16> columns{};
#ifdef SRSLAM_DBSCAN_SSE2
  const auto load = [&](std::size_t row) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(rows.data() + row));
  };
  const __m128i low_byte = _mm_set1_epi16(0xff);
  __m128i low =
      _mm_packus_epi16(_mm_and_si128(load(0), low_byte), _mm_and_si128(load(8), low_byte));
  __m128i high = _mm_packus_epi16(_mm_srli_epi16(load(0), 8), _mm_srli_epi16(load(8), 8));
  for (std::size_t column = 8; column-- > 0;) {
    columns[column] = std::uint16_t(_mm_movemask_epi8(low));
    columns[column + 8] = std::uint16_t(_mm_movemask_epi8(high));
    low = _mm_add_epi8(low, low);
    high = _mm_add_epi8(high, high);
  }
#else
  for (std::size_t row = 0; row < 16; ++row) {
    for (std::size_t column = 0; column < 16; ++column) {
      const unsigned bit = unsigned(rows[row]) >> column & 1U;
      columns[column] = std::uint16_t(columns[column] | bit << row);
    }
  }
#endif
  return columns;
}

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
