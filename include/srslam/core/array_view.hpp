#pragma once

#include <cstddef>
#include <type_traits>
#include <vector>

namespace srslam {

/// Non-owning view of `size` contiguous elements. The viewed storage must outlive the call it is
/// passed to; nothing in the library keeps a view after returning.
template <typename T>
struct ArrayView {
  T* data = nullptr;
  std::size_t size = 0;

  constexpr ArrayView() = default;
  constexpr ArrayView(T* data_in, std::size_t size_in) : data(data_in), size(size_in) {}
  /// Views a whole vector. Implicit so that callers can pass a vector where a view is taken.
  ArrayView(std::vector<std::remove_const_t<T>>& vector)
      : data(vector.data()), size(vector.size()) {}
  /// A constant vector, or a temporary one in a function argument, gives constant elements only.
  template <typename U = T, typename = std::enable_if_t<std::is_const_v<U>>>
  ArrayView(const std::vector<std::remove_const_t<U>>& vector)
      : data(vector.data()), size(vector.size()) {}
  /// A mutable view reads as a constant one.
  template <typename U, typename = std::enable_if_t<std::is_same_v<const U, T>>>
  constexpr ArrayView(const ArrayView<U>& other) : data(other.data), size(other.size) {}

  constexpr bool empty() const noexcept { return size == 0; }
  constexpr T& operator[](std::size_t index) const noexcept { return data[index]; }
  constexpr T* begin() const noexcept { return data; }
  constexpr T* end() const noexcept { return data + size; }
};

}  // namespace srslam
