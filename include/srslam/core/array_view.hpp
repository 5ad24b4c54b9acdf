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
  ArrayView(const std::vector<std::remove_const_t<T>>& vector)  // NOLINT(google-explicit-constructor)
      : data(vector.data()), size(vector.size()) {}

  constexpr bool empty() const noexcept { return size == 0; }
  constexpr T& operator[](std::size_t index) const noexcept { return data[index]; }
  constexpr T* begin() const noexcept { return data; }
  constexpr T* end() const noexcept { return data + size; }
};

}  // namespace srslam
