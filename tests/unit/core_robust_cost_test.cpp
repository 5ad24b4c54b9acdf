#include "srslam/core/robust_cost.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/constants.hpp"

namespace srslam {
namespace {

using test::kInf;
using test::kNan;

const std::vector<RobustKind>& all_kinds() {
  static const std::vector<RobustKind> kinds = {RobustKind::kNone, RobustKind::kHuber,
                                                RobustKind::kCauchy, RobustKind::kTukey,
                                                RobustKind::kStudentT};
  return kinds;
}

std::vector<RobustCost> all_costs() {
  std::vector<RobustCost> costs;
  for (const RobustKind kind : all_kinds()) {
    for (const double scale : {1e-3, 0.5, 1.0, 2.447}) {
      for (const double dof : {1.0, 5.0}) costs.push_back({kind, scale, dof});
    }
  }
  return costs;
}

std::string describe(const RobustCost& cost) {
  return std::string(to_string(cost.kind)) + " scale " + std::to_string(cost.scale) + " dof " +
         std::to_string(cost.dof);
}

/// Residuals e from far below to far above the scale.
std::vector<double> residuals(double scale) {
  std::vector<double> values = {0.0};
  for (int step = 0; step < 58; ++step) values.push_back(1e-8 * std::pow(1.9, step) * scale);
  return values;
}

TEST(RobustCost, HandComputedValues) {
  // s = e² with e = 3, scale 2.
  const RobustCost none{RobustKind::kNone, 2.0, 5.0};
  EXPECT_DOUBLE_EQ(none.rho(9.0), 9.0);
  EXPECT_DOUBLE_EQ(none.weight(9.0), 1.0);
  const RobustCost huber{RobustKind::kHuber, 2.0, 5.0};
  EXPECT_DOUBLE_EQ(huber.rho(1.0), 1.0);
  EXPECT_DOUBLE_EQ(huber.rho(4.0), 4.0);
  EXPECT_DOUBLE_EQ(huber.rho(9.0), 2.0 * 2.0 * 3.0 - 4.0);
  EXPECT_DOUBLE_EQ(huber.weight(4.0), 1.0);
  EXPECT_DOUBLE_EQ(huber.weight(9.0), 2.0 / 3.0);
  const RobustCost cauchy{RobustKind::kCauchy, 2.0, 5.0};
  EXPECT_DOUBLE_EQ(cauchy.rho(4.0), 4.0 * std::log(2.0));
  EXPECT_DOUBLE_EQ(cauchy.weight(4.0), 0.5);
  EXPECT_DOUBLE_EQ(cauchy.weight(12.0), 0.25);
  const RobustCost tukey{RobustKind::kTukey, 2.0, 5.0};
  EXPECT_DOUBLE_EQ(tukey.rho(2.0), 4.0 / 3.0 * (1.0 - 0.125));
  EXPECT_DOUBLE_EQ(tukey.weight(2.0), 0.25);
  EXPECT_DOUBLE_EQ(tukey.rho(4.0), 4.0 / 3.0);
  EXPECT_DOUBLE_EQ(tukey.rho(9.0), 4.0 / 3.0);
  EXPECT_EQ(tukey.weight(4.0), 0.0);
  EXPECT_EQ(tukey.weight(9.0), 0.0);
  const RobustCost student{RobustKind::kStudentT, 2.0, 3.0};
  EXPECT_DOUBLE_EQ(student.rho(12.0), 12.0 * std::log(2.0));
  EXPECT_DOUBLE_EQ(student.weight(12.0), 0.5);
}

// C(r) = c²/2 ln(1 + (r/c)²), weight 1 / (1 + (r/c)²), as dense visual odometry writes it.
TEST(RobustCost, CauchyIsTwiceTheCostOfDenseOdometry) {
  for (const double c : {0.01, 0.5, 3.0}) {
    const RobustCost cost{RobustKind::kCauchy, c, 5.0};
    for (const double r : {0.0, 0.001, 0.3, 2.0, 50.0}) {
      EXPECT_DOUBLE_EQ(0.5 * cost.rho(r * r), c * c / 2.0 * std::log1p(r / c * (r / c)));
      EXPECT_DOUBLE_EQ(cost.weight(r * r), 1.0 / (1.0 + (r / c) * (r / c)));
    }
    // The influence r w(r) is largest, c / 2, at r = c.
    EXPECT_DOUBLE_EQ(c * cost.weight(c * c), c / 2.0);
  }
}

// The t-distribution's negative log-likelihood (ν + 1)/2 ln(1 + e²/(ν σ²)), up to the normalisation
// by (ν + 1)/ν σ^-2 that the documentation states.
TEST(RobustCost, StudentTIsTheScaledLogLikelihood) {
  const double sigma = 0.7;
  for (const double dof : {1.0, 3.0, 5.0, 30.0}) {
    const RobustCost cost{RobustKind::kStudentT, sigma, dof};
    for (const double e : {0.01, 0.5, 2.0, 30.0}) {
      const double negative_log_likelihood =
          0.5 * (dof + 1.0) * std::log1p(e * e / (dof * sigma * sigma));
      const double factor = (dof + 1.0) / dof / (sigma * sigma);
      EXPECT_NEAR(0.5 * factor * cost.rho(e * e) / negative_log_likelihood, 1.0, 1e-14);
      const double likelihood_weight = (dof + 1.0) / (dof + e * e / (sigma * sigma));
      EXPECT_NEAR(cost.weight(e * e) * (dof + 1.0) / dof / likelihood_weight, 1.0, 1e-14);
    }
  }
}

TEST(RobustCost, SmallResidualsCostTheirSquare) {
  for (const RobustCost& cost : all_costs()) {
    EXPECT_EQ(cost.rho(0.0), 0.0) << describe(cost);
    EXPECT_EQ(cost.weight(0.0), 1.0) << describe(cost);
    for (const double ratio : {1e-300, 1e-30, 1e-12, 1e-9}) {
      const double s = ratio * cost.scale * cost.scale;
      EXPECT_NEAR(cost.rho(s) / s, 1.0, 2.0 * ratio + 1e-15)
          << describe(cost) << " ratio " << ratio;
    }
  }
}

TEST(RobustCost, WeightIsTheDerivativeOfRho) {
  for (const RobustCost& cost : all_costs()) {
    const double c2 = cost.scale * cost.scale;
    for (const double ratio : {0.01, 0.1, 0.3, 0.5, 0.9, 0.99, 1.01, 1.1, 2.0, 10.0, 1000.0}) {
      const double s = ratio * c2;
      // Small enough not to step over the joint of Huber and Tukey at ratio 1.
      const double h = 1e-3 * s;
      const double slope = (8.0 * (cost.rho(s + h) - cost.rho(s - h)) -
                            (cost.rho(s + 2 * h) - cost.rho(s - 2 * h))) /
                           (12.0 * h);
      EXPECT_NEAR(cost.weight(s), slope, 1e-10) << describe(cost) << " ratio " << ratio;
    }
  }
}

TEST(RobustCost, IsContinuousAtItsScale) {
  for (const RobustCost& cost : all_costs()) {
    const double c2 = cost.scale * cost.scale;
    const double below = c2 * (1.0 - 1e-12);
    const double above = c2 * (1.0 + 1e-12);
    EXPECT_NEAR(cost.rho(below) / cost.rho(above), 1.0, 1e-11) << describe(cost);
    EXPECT_NEAR(cost.weight(below), cost.weight(above), 1e-11) << describe(cost);
  }
}

TEST(RobustCost, RhoGrowsAndWeightFalls) {
  for (const RobustCost& cost : all_costs()) {
    double last_rho = -1.0;
    double last_weight = 2.0;
    for (const double e : residuals(cost.scale)) {
      const double rho = cost.rho(e * e);
      const double weight = cost.weight(e * e);
      EXPECT_GE(rho, last_rho) << describe(cost) << " e " << e;
      EXPECT_LE(weight, last_weight) << describe(cost) << " e " << e;
      EXPECT_GE(weight, 0.0);
      EXPECT_LE(weight, 1.0);
      EXPECT_LE(rho, e * e * (1.0 + 1e-15)) << "never costs more than least squares";
      last_rho = rho;
      last_weight = weight;
    }
  }
}

TEST(RobustCost, InfluenceOfAnyResidualIsBounded) {
  for (const RobustCost& cost : all_costs()) {
    double bound = kInf;
    const double c = cost.scale;
    switch (cost.kind) {
      case RobustKind::kNone:
        break;
      case RobustKind::kHuber:
        bound = c;
        break;
      case RobustKind::kCauchy:
        bound = c / 2.0;
        break;
      case RobustKind::kTukey:
        bound = c * 16.0 / (25.0 * std::sqrt(5.0));  // at e = c / √5
        break;
      case RobustKind::kStudentT:
        bound = c * std::sqrt(cost.dof) / 2.0;
        break;
    }
    double largest = 0.0;
    for (int step = 0; step < 50000; ++step) {
      const double e = 1e-3 * step * c;
      largest = std::max(largest, e * cost.weight(e * e));
    }
    EXPECT_LE(largest, bound * (1.0 + 1e-12)) << describe(cost);
    if (std::isfinite(bound)) {
      EXPECT_GE(largest, 0.999 * bound) << describe(cost);
    }
  }
}

TEST(RobustCost, LimitsOfLargeResiduals) {
  const double far = 1e20;  // s, at scale 1
  EXPECT_EQ((RobustCost{RobustKind::kNone, 1.0, 5.0}.rho(far)), far);
  EXPECT_NEAR((RobustCost{RobustKind::kHuber, 1.0, 5.0}.rho(far)) / 2e10, 1.0, 1e-9);
  EXPECT_NEAR((RobustCost{RobustKind::kCauchy, 1.0, 5.0}.rho(far)), 20.0 * std::log(10.0), 1e-12);
  EXPECT_EQ((RobustCost{RobustKind::kTukey, 1.0, 5.0}.rho(far)), 1.0 / 3.0);
  EXPECT_NEAR((RobustCost{RobustKind::kStudentT, 1.0, 5.0}.rho(far)), 5.0 * std::log(far / 5.0),
              1e-12);
  // A large scale is least squares.
  for (const RobustKind kind : all_kinds()) {
    const RobustCost wide{kind, 1e9, 5.0};
    EXPECT_NEAR(wide.rho(123.0), 123.0, 1e-12) << to_string(kind);
    EXPECT_NEAR(wide.weight(123.0), 1.0, 1e-12) << to_string(kind);
  }
  // The t-distribution with many degrees of freedom is the normal one.
  EXPECT_NEAR((RobustCost{RobustKind::kStudentT, 1.0, 1e12}.rho(9.0)), 9.0, 1e-9);
}

TEST(RobustCost, NoInputGivesANan) {
  for (const RobustCost& cost : all_costs()) {
    for (const double s : {-0.0, -1e-18, -1.0, -kInf}) {
      EXPECT_EQ(cost.rho(s), 0.0) << describe(cost) << " " << s;
    }
    for (const double s : {-0.0, -1e-18, -1.0}) {
      EXPECT_EQ(cost.weight(s), 1.0) << describe(cost) << " " << s;
    }
    EXPECT_EQ(cost.rho(kNan), kInf) << describe(cost);
    EXPECT_EQ(cost.weight(kNan), 0.0) << describe(cost);
    EXPECT_EQ(cost.weight(kInf), 0.0) << describe(cost);
    EXPECT_FALSE(std::isnan(cost.rho(kInf))) << describe(cost);
    for (const double s : {5e-324, 1e-308, 1e-200, 1e200, 1.7e308}) {
      EXPECT_FALSE(std::isnan(cost.rho(s))) << describe(cost) << " " << s;
      EXPECT_FALSE(std::isnan(cost.weight(s))) << describe(cost) << " " << s;
    }
  }
}

TEST(RobustCostValidate, AcceptsWhatIsPositive) {
  for (const RobustCost& cost : all_costs()) EXPECT_TRUE(cost.validate().ok()) << describe(cost);
  EXPECT_TRUE(RobustCost{}.validate().ok());
}

TEST(RobustCostValidate, RefusesTheRest) {
  for (const RobustKind kind : all_kinds()) {
    for (const double bad : {0.0, -0.0, -1.0, kNan, kInf, -kInf, 1e-200, 1e200}) {
      const RobustCost scale{kind, bad, 5.0};
      EXPECT_EQ(scale.validate().ok(), kind == RobustKind::kNone) << describe(scale);
      const RobustCost dof{kind, 1.0, bad};
      const bool usable = kind != RobustKind::kStudentT || bad == 1e-200 || bad == 1e200;
      EXPECT_EQ(dof.validate().ok(), usable) << describe(dof);
    }
  }
  const RobustCost unknown{static_cast<RobustKind>(200), 1.0, 5.0};
  EXPECT_EQ(unknown.validate().code, StatusCode::kInvalidArgument);
}

TEST(RobustCost, NamesAreStable) {
  EXPECT_STREQ(to_string(RobustKind::kNone), "none");
  EXPECT_STREQ(to_string(RobustKind::kHuber), "huber");
  EXPECT_STREQ(to_string(RobustKind::kCauchy), "cauchy");
  EXPECT_STREQ(to_string(RobustKind::kTukey), "tukey");
  EXPECT_STREQ(to_string(RobustKind::kStudentT), "student_t");
  EXPECT_STREQ(to_string(static_cast<RobustKind>(200)), "unknown");
}

/// Asymptotic efficiency on normal residuals: E[ψ']² / E[ψ²] with ψ(e) = e w(e²).
double efficiency(const RobustCost& cost) {
  constexpr double kStep = 1e-4;
  const auto psi = [&](double e) { return e * cost.weight(e * e); };
  double mean_slope = 0.0;
  double mean_square = 0.0;
  for (int step = -90000; step <= 90000; ++step) {
    const double e = step * kStep;
    const double density = std::exp(-0.5 * e * e);
    mean_slope += density * (psi(e + 0.5 * kStep) - psi(e - 0.5 * kStep)) / kStep;
    mean_square += density * psi(e) * psi(e);
  }
  const double normaliser = std::sqrt(2.0 * 3.14159265358979) / kStep;
  return mean_slope * mean_slope / (mean_square * normaliser);
}

TEST(RobustCostScales, KeepNinetyFivePercentEfficiency) {
  EXPECT_NEAR(efficiency({RobustKind::kNone, 1.0, 5.0}), 1.0, 1e-6);
  EXPECT_NEAR(efficiency({RobustKind::kHuber, kHuberScale95, 5.0}), 0.95, 1e-4);
  EXPECT_NEAR(efficiency({RobustKind::kCauchy, kCauchyScale95, 5.0}), 0.95, 1e-4);
  EXPECT_NEAR(efficiency({RobustKind::kTukey, kTukeyScale95, 5.0}), 0.95, 1e-4);
  // Half of the mean absolute residual, 0.40 σ, keeps less than half.
  EXPECT_NEAR(efficiency({RobustKind::kCauchy, 0.5 * std::sqrt(2.0 / 3.14159265358979), 5.0}), 0.46,
              0.01);
}

}  // namespace
}  // namespace srslam
