#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace srslam {

/// How the motion residual lowers the reliability (Eq. 7), with x = residual / scale.
enum class ResidualFactorForm : std::uint8_t {
  kExponential,  ///< exp(-x): 1 without motion, falling, never 0
  kRational,     ///< 1 / (1 + x)
  kClip,         ///< min(1, 1 / x): no effect up to the scale
  kLinear,       ///< max(0, 1 - x)
  kLiteral,      ///< x, as printed: a frame at rest has reliability 0
};

/// Eq. 7's factor. NaN for a negative or NaN residual or a scale that is not positive.
inline double residual_factor(double residual_px, double scale_px,
                              ResidualFactorForm form) noexcept {
  if (!(residual_px >= 0.0) || !(scale_px > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  const double x = residual_px / scale_px;
  switch (form) {
    case ResidualFactorForm::kExponential:
      return std::exp(-x);
    case ResidualFactorForm::kRational:
      return 1.0 / (1.0 + x);
    case ResidualFactorForm::kClip:
      return x > 1.0 ? 1.0 / x : 1.0;
    case ResidualFactorForm::kLinear:
      return std::max(0.0, 1.0 - x);
    case ResidualFactorForm::kLiteral:
      return x;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// Reliability from the current one and the motion residual (Eq. 7).
inline double scene_reliability(
    double current_reliability, double residual_px, double scale_px,
    ResidualFactorForm form = ResidualFactorForm::kExponential) noexcept {
  return current_reliability * residual_factor(residual_px, scale_px, form);
}

/// Eq. 8.
enum class SceneClass : std::uint8_t { kGood, kBad };

constexpr const char* to_string(SceneClass scene_class) noexcept {
  return scene_class == SceneClass::kGood ? "GOOD" : "BAD";
}

/// GOOD from the threshold on; a NaN is BAD (Eq. 8).
constexpr SceneClass classify_scene(double reliability, double threshold) noexcept {
  return reliability >= threshold ? SceneClass::kGood : SceneClass::kBad;
}

}  // namespace srslam
