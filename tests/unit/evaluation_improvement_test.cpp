#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "srslam/evaluation/improvement.hpp"

namespace srslam {
namespace {

double percent(double value, double baseline, EquationForm form = EquationForm::kDefault) {
  const ImprovementResult result = improvement_percent(value, baseline, form);
  EXPECT_TRUE(result.status.ok()) << result.status.reason;
  return result.percent;
}

TEST(Improvement, DefaultIsTheShareThatTheErrorFellBy) {
  EXPECT_DOUBLE_EQ(percent(1.0, 10.0), 90.0);
  EXPECT_DOUBLE_EQ(percent(0.25, 1.0), 75.0);
  EXPECT_DOUBLE_EQ(percent(0.0, 3.0), 100.0);
  EXPECT_DOUBLE_EQ(percent(2.0, 2.0), 0.0);
}

TEST(Improvement, AWorseErrorIsNegative) {
  EXPECT_DOUBLE_EQ(percent(3.0, 2.0), -50.0);
  // The paper's s/xyz row: 0.0102 m against a baseline of 0.0093 m.
  EXPECT_NEAR(percent(0.0102, 0.0093), -9.677419, 1e-6);
}

TEST(Improvement, LiteralFollowsTheMisplacedParenthesis) {
  EXPECT_DOUBLE_EQ(percent(1.0, 10.0, EquationForm::kLiteral), -9.0);
  EXPECT_DOUBLE_EQ(percent(2.0, 2.0, EquationForm::kLiteral), -99.0);
  EXPECT_DOUBLE_EQ(percent(0.0, 2.0, EquationForm::kLiteral), 1.0);
}

TEST(Improvement, ABaselineOfZeroIsFlaggedAndGivesNoNumber) {
  for (const EquationForm form : {EquationForm::kDefault, EquationForm::kLiteral}) {
    for (const double value : {0.0, 1.0}) {
      const ImprovementResult result = improvement_percent(value, 0.0, form);
      EXPECT_EQ(result.status.code, StatusCode::kDegenerate);
      EXPECT_TRUE(std::isnan(result.percent));
    }
    const ImprovementResult tiny = improvement_percent(1e300, 1e-300, form);
    EXPECT_EQ(tiny.status.code, StatusCode::kDegenerate);
    EXPECT_TRUE(std::isnan(tiny.percent));
  }
}

TEST(Improvement, RefusesWhatIsNoError) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {-1.0, nan, infinity}) {
    EXPECT_EQ(improvement_percent(bad, 1.0).status.code, StatusCode::kInvalidArgument);
    EXPECT_EQ(improvement_percent(1.0, bad).status.code, StatusCode::kInvalidArgument);
    EXPECT_TRUE(std::isnan(improvement_percent(1.0, bad).percent));
  }
}

TEST(Improvement, ResultStartsAsNotRun) {
  EXPECT_EQ(ImprovementResult{}.status.code, StatusCode::kNotRun);
}

}  // namespace
}  // namespace srslam
