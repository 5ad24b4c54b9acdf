#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "io/numbers.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using io_detail::NumberFormat;

TEST(IoNumbers, AcceptsDecimalNotation) {
  const std::vector<std::pair<std::string, double>> cases = {
      {"0", 0.0},
      {"-0", -0.0},
      {"+1", 1.0},
      {"1.", 1.0},
      {".5", 0.5},
      {"-.25e1", -2.5},
      {"1e3", 1000.0},
      {"1E-3", 1e-3},
      {"1305031102.175304", 1305031102.175304},
      {"1e308", 1e308},
      {"5e-324", 5e-324},
      {"0e999999", 0.0},
      {"0.1", 0.1},
      {"00012", 12.0},
      {"123456789012345678901234567890", 1.2345678901234568e29}};
  for (const auto& [text, expected] : cases) {
    double value = 99.0;
    EXPECT_TRUE(io_detail::parse_decimal(text, &value)) << text;
    EXPECT_EQ(value, expected) << text;
  }
}

TEST(IoNumbers, RefusesEverythingElseAndLeavesTheValueAlone) {
  for (const std::string text :
       {"",      " ",      "1 ",     " 1",    "+",           "-",     ".",     "e5",
        "1e",    "1e+",    "--1",    "+-1",   "1..2",        "1.2.3", "0x10",  "nan",
        "NaN",   "-nan",   "inf",    "-inf",  "infinity",    "1,5",   "1_000", "12abc",
        "1e400", "-1e400", "1e-400", "1e5.5", "\xEF\xBC\x91"}) {
    double value = 99.0;
    EXPECT_FALSE(io_detail::parse_decimal(text, &value)) << "'" << text << "'";
    EXPECT_EQ(value, 99.0) << "'" << text << "'";
  }
  double value = 99.0;
  EXPECT_FALSE(io_detail::parse_decimal(std::string("1\0", 2), &value));
}

// libstdc++ before 11 uses the stream; it must not read or write anything differently.
TEST(IoNumbers, StreamFallbackAgreesWithTheStandardConversion) {
  test::for_each_seed(2000, [](test::Rng& rng) {
    const std::uint64_t bits = rng.next();
    double value = 0.0;
    std::memcpy(&value, &bits, sizeof(value));
    if (!std::isfinite(value)) return;
    for (const auto& [format, digits] :
         {std::pair{NumberFormat::kGeneral, 17}, std::pair{NumberFormat::kFixed, 9}}) {
      std::string text;
      std::string stream_text;
      io_detail::append_number(value, format, digits, &text);
      io_detail::append_number_by_stream(value, format, digits, &stream_text);
      ASSERT_EQ(text, stream_text);
      double parsed = 0.0;
      double stream_parsed = 0.0;
      ASSERT_EQ(io_detail::parse_decimal_by_stream(text, &stream_parsed), true) << text;
      if (io_detail::parse_decimal(text, &parsed)) {
        ASSERT_EQ(parsed, stream_parsed) << text;
        if (format == NumberFormat::kGeneral) {
          ASSERT_EQ(parsed, value) << text;
        }
      }
    }
  });
}

TEST(IoNumbers, ExactTextReadsBackTheSameBits) {
  test::for_each_seed(5000, [](test::Rng& rng) {
    const std::uint64_t bits = rng.next();
    double value = 0.0;
    std::memcpy(&value, &bits, sizeof(value));
    if (!std::isfinite(value)) return;
    std::string text;
    io_detail::append_exact(value, &text);
    double parsed = 0.0;
    ASSERT_TRUE(io_detail::parse_decimal(text, &parsed)) << text;
    ASSERT_EQ(parsed, value) << text;
  });
  std::string text;
  io_detail::append_exact(517.306408, &text);
  EXPECT_EQ(text, "517.306408");
}

TEST(IoNumbers, TimeStampsKeepSixDecimalsOrAsManyAsTheyNeed) {
  const std::vector<std::pair<double, std::string>> cases = {
      {1305031102.175304, "1305031102.175304"},
      {1548339819.87426, "1548339819.874260"},
      {0.0, "0.000000"},
      {0.1 + 0.2, "0.30000000000000004"},
      {1403636579.763555527, "1403636579.7635555"}};
  for (const auto& [value_s, expected] : cases) {
    std::string text;
    io_detail::append_timestamp(value_s, &text);
    EXPECT_EQ(text, expected);
  }
  test::for_each_seed(3000, [](test::Rng& rng) {
    const double value_s = rng.uniform(-1.0, 1.0) * std::pow(10.0, rng.uniform(-9.0, 10.0));
    std::string text;
    io_detail::append_timestamp(value_s, &text);
    double parsed_s = 0.0;
    ASSERT_TRUE(io_detail::parse_decimal(text, &parsed_s)) << text;
    ASSERT_EQ(parsed_s, value_s) << text;
  });
}

TEST(IoNumbers, DoNotDependOnTheLocaleOfTheProgram) {
  // Any locale with a decimal comma that this system has; the C locale changes nothing and would
  // prove nothing.
  const char* used = nullptr;
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE", "fr_FR", "pl_PL.UTF-8"}) {
    used = std::setlocale(LC_ALL, name);
    if (used != nullptr) break;
  }
  if (used == nullptr) GTEST_SKIP() << "this system has no locale with a decimal comma";
  double value = 0.0;
  double stream_value = 0.0;
  std::string text;
  const bool parsed = io_detail::parse_decimal("1.5", &value);
  const bool stream_parsed = io_detail::parse_decimal_by_stream("1.5", &stream_value);
  io_detail::append_number(2.5, NumberFormat::kFixed, 3, &text);
  io_detail::append_number_by_stream(2.5, NumberFormat::kFixed, 3, &text);
  std::setlocale(LC_ALL, "C");
  EXPECT_TRUE(parsed);
  EXPECT_TRUE(stream_parsed);
  EXPECT_EQ(value, 1.5);
  EXPECT_EQ(stream_value, 1.5);
  EXPECT_EQ(text, "2.5002.500");
}

}  // namespace
}  // namespace srslam
