#pragma once

#include <array>

namespace srslam {

/// The 3×3 partition of the image that Eq. 4–6 sum over; cells in row-major order.
constexpr int kGridCols = 3;
constexpr int kGridRows = 3;
constexpr int kGridCells = kGridCols * kGridRows;

/// One value a cell.
template <typename T>
using GridArray = std::array<T, kGridCells>;

/// Cell of pixel (u, v) in an image of the given size, 0..8, or -1 outside the image (also for
/// NaN). A pixel covers half a pixel around its centre, so u in [-0.5, width - 0.5) is inside.
/// Points left of the first centre belong to the first cell, right of the last one to the last.
constexpr int grid_cell(double u_px, double v_px, int width_px, int height_px) noexcept {
  if (!(u_px >= -0.5 && v_px >= -0.5 && u_px < width_px - 0.5 && v_px < height_px - 0.5)) return -1;
  int col = u_px < 0.0 ? 0 : static_cast<int>(kGridCols * u_px / width_px);
  int row = v_px < 0.0 ? 0 : static_cast<int>(kGridRows * v_px / height_px);
  if (col >= kGridCols) col = kGridCols - 1;
  if (row >= kGridRows) row = kGridRows - 1;
  return row * kGridCols + col;
}

}  // namespace srslam
