#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "srslam/core/status.hpp"

namespace srslam {

/// One colour pixel in OpenCV's channel order.
struct Bgr8 {
  std::uint8_t b = 0;
  std::uint8_t g = 0;
  std::uint8_t r = 0;
};
static_assert(sizeof(Bgr8) == 3, "Bgr8 must match packed 8-bit three-channel images");

/// Non-owning view of a row-major image. Pixel (u, v): u to the right, v down, integer
/// coordinates at pixel centres. Rows start `stride_bytes` apart, so views of sub-images and of
/// padded buffers need no copy. The storage must outlive the view.
template <typename T>
struct ImageView {
  T* data = nullptr;
  int width_px = 0;
  int height_px = 0;
  std::ptrdiff_t stride_bytes = 0;

  constexpr ImageView() = default;
  /// Tightly packed rows.
  constexpr ImageView(T* data_in, int width_in_px, int height_in_px)
      : ImageView(
            data_in, width_in_px, height_in_px,
            static_cast<std::ptrdiff_t>(width_in_px) * static_cast<std::ptrdiff_t>(sizeof(T))) {}
  constexpr ImageView(T* data_in, int width_in_px, int height_in_px, std::ptrdiff_t stride_in_bytes)
      : data(data_in),
        width_px(width_in_px),
        height_px(height_in_px),
        stride_bytes(stride_in_bytes) {}
  /// A mutable view reads as a constant one.
  template <typename U, typename = std::enable_if_t<std::is_same_v<const U, T>>>
  constexpr ImageView(const ImageView<U>& other)  // NOLINT(google-explicit-constructor)
      : ImageView(other.data, other.width_px, other.height_px, other.stride_bytes) {}

  constexpr bool empty() const noexcept {
    return data == nullptr || width_px <= 0 || height_px <= 0;
  }
  constexpr bool contains(int u_px, int v_px) const noexcept {
    return u_px >= 0 && v_px >= 0 && u_px < width_px && v_px < height_px;
  }
  T* row(int v_px) const noexcept {
    using Byte = std::conditional_t<std::is_const_v<T>, const unsigned char, unsigned char>;
    return reinterpret_cast<T*>(reinterpret_cast<Byte*>(data) + v_px * stride_bytes);
  }
  /// Precondition: contains(u_px, v_px).
  T& operator()(int u_px, int v_px) const noexcept { return row(v_px)[u_px]; }

  /// Ok when every pixel can be addressed: data present, positive size, rows that do not overlap
  /// and that all start at an address fit for T if the first one does.
  constexpr Status validate() const noexcept {
    if (data == nullptr) return Status::failure(StatusCode::kInvalidArgument, "image has no data");
    if (width_px <= 0 || height_px <= 0) {
      return Status::failure(StatusCode::kInvalidArgument, "image size must be positive");
    }
    if (stride_bytes <
        static_cast<std::ptrdiff_t>(width_px) * static_cast<std::ptrdiff_t>(sizeof(T))) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "image stride is smaller than a row of pixels");
    }
    if (stride_bytes % static_cast<std::ptrdiff_t>(alignof(T)) != 0) {
      return Status::failure(StatusCode::kInvalidArgument,
                             "image stride is not a multiple of the pixel's alignment");
    }
    return Status::success();
  }
};

/// Owning counterpart of ImageView with packed rows; keeps its allocation when resized to the
/// same or a smaller size.
template <typename T>
struct ImageBuffer {
  std::vector<T> pixels;
  int width_px = 0;
  int height_px = 0;

  /// A size that is not positive gives an empty buffer. New pixels are value-initialised, kept ones
  /// hold whatever they held.
  void resize(int new_width_px, int new_height_px) {
    const bool positive = new_width_px > 0 && new_height_px > 0;
    width_px = positive ? new_width_px : 0;
    height_px = positive ? new_height_px : 0;
    pixels.resize(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px));
  }
  bool empty() const noexcept { return pixels.empty(); }
  ImageView<const T> view() const noexcept { return {pixels.data(), width_px, height_px}; }
  ImageView<T> view() noexcept { return {pixels.data(), width_px, height_px}; }
};

}  // namespace srslam
