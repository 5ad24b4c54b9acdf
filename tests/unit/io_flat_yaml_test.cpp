#include <gtest/gtest.h>

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "srslam/io/flat_yaml.hpp"
#include "support/io_test_dataset.hpp"

namespace srslam {
namespace {

using test::expect_failure;
using test::TempFolder;
using test::write_text;

class FlatYaml : public testing::Test {
 protected:
  FileStatus read(const std::string& text) {
    write_text(path_, text);
    return read_flat_yaml(path_, &entries_);
  }

  TempFolder folder_;
  std::string path_ = folder_ / "config.yaml";
  std::vector<FlatYamlEntry> entries_;
};

TEST_F(FlatYaml, ReadsKeysValuesAndLines) {
  const FileStatus status = read(
      "%YAML:1.0\n"
      "---\n"
      "# a comment\n"
      "\n"
      "fx_px: 525.0   # pixels\n"
      "features.num_features:\t1000\n"
      "name: left camera\n"
      "url-like: a#b\n"
      "quoted: \"say \\\"hi\\\" \\\\ # no comment\"  # comment\n"
      "single: 'it''s # here'\n"
      "empty: \"\"\n"
      "...\n");
  ASSERT_TRUE(status.ok()) << status.message();
  const std::vector<FlatYamlEntry> expected = {{"fx_px", "525.0", 5},
                                               {"features.num_features", "1000", 6},
                                               {"name", "left camera", 7},
                                               {"url-like", "a#b", 8},
                                               {"quoted", "say \"hi\" \\ # no comment", 9},
                                               {"single", "it's # here", 10},
                                               {"empty", "", 11}};
  ASSERT_EQ(entries_.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(entries_[i].key, expected[i].key);
    EXPECT_EQ(entries_[i].value, expected[i].value);
    EXPECT_EQ(entries_[i].line, expected[i].line);
  }
}

TEST_F(FlatYaml, AcceptsCarriageReturnsByteOrderMarkAndNoLastLineEnd) {
  const FileStatus status = read(
      "\xEF\xBB\xBF"
      "a: 1\r\n# x\r\nb: 2");
  ASSERT_TRUE(status.ok()) << status.message();
  ASSERT_EQ(entries_.size(), 2U);
  EXPECT_EQ(entries_[0].key, "a");
  EXPECT_EQ(entries_[0].value, "1");
  EXPECT_EQ(entries_[1].value, "2");
  EXPECT_EQ(entries_[1].line, 3U);
}

TEST_F(FlatYaml, EmptyFileHasNoEntries) {
  EXPECT_TRUE(read("").ok());
  EXPECT_TRUE(entries_.empty());
  EXPECT_TRUE(read("# nothing\n---\n").ok());
  EXPECT_TRUE(entries_.empty());
}

TEST_F(FlatYaml, RefusesWhatIsNotOfTheSubset) {
  struct Case {
    std::string text;
    std::size_t line;
    std::string reason_part;
  };
  const std::vector<Case> cases = {
      {"a: 1\nb 2\n", 2, "expected `key: value`"},
      {"a:1\n", 1, "with a space after the colon"},
      {": 1\n", 1, "expected `key: value`"},
      {"a b: 1\n", 1, "expected `key: value`"},
      {"a:\n", 1, "has no value"},
      {"a: # only a comment\n", 1, "has no value"},
      {"a: 1\n  b: 2\n", 2, "indented"},
      {"\ta: 1\n", 1, "indented"},
      {"a: [1, 2]\n", 1, "lists, maps"},
      {"a: {b: 1}\n", 1, "lists, maps"},
      {"a: |\n", 1, "lists, maps"},
      {"- 1\n", 1, "expected `key: value`"},
      {"a: \"1\n", 1, "no closing quote"},
      {"a: \"\\n\"\n", 1, "unknown escape"},
      {"a: 'x' y\n", 1, "after the quoted value"},
      {"a: 'x'#y\n", 1, "after the quoted value"},
      {"a: 1\nb: 2\n\na: 3\n", 4, "already given on line 1"},
      {"a: 1\n---\nb: 2\n", 2, "one YAML document"},
      {"---\n---\n", 2, "one YAML document"},
      {"a: 1\n...\nb: 2\n", 3, "after the end mark"},
      {"a: 1\n%YAML 1.0\n", 2, "expected `key: value`"},
      {std::string("a: \0\n", 5), 1, "control character"},
      {"a: 1\nb: \xFF\n", 2, "UTF-8"},
      {"a: 1\nb: " + std::string(5000, 'x') + "\n", 2, "longer than 4096 bytes"},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.text.substr(0, 40));
    expect_failure(read(c.text), StatusCode::kCorruptData, path_, c.line, c.reason_part);
    EXPECT_TRUE(entries_.empty());
  }
}

TEST_F(FlatYaml, LineLimitIsExactWithEitherLineEnd) {
  const std::string value(4096 - 3, 'x');
  EXPECT_TRUE(read("a: " + value + "\n").ok());
  EXPECT_TRUE(read("a: " + value + "\r\n").ok());
  EXPECT_TRUE(read("a: " + value).ok());
  expect_failure(read("a: " + value + "x\n"), StatusCode::kCorruptData, path_, 1, "4096");
  expect_failure(read("a: " + value + "x\r\n"), StatusCode::kCorruptData, path_, 1, "4096");
  // Much longer than the reader's buffer, and without an end.
  expect_failure(read("b: 1\na: " + std::string(300000, 'x')), StatusCode::kCorruptData, path_, 2,
                 "4096");
}

TEST_F(FlatYaml, LinesAreWholeAcrossTheReadersBuffer) {
  std::string text;
  for (int i = 0; i < 20000; ++i) {
    text += "key" + std::to_string(i) + ": value" + std::to_string(i) + "\n";
  }
  ASSERT_TRUE(read(text).ok());
  ASSERT_EQ(entries_.size(), 20000U);
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    ASSERT_EQ(entries_[i].key, "key" + std::to_string(i));
    ASSERT_EQ(entries_[i].value, "value" + std::to_string(i));
    ASSERT_EQ(entries_[i].line, i + 1);
  }
}

TEST_F(FlatYaml, TellsMissingFilesAndFoldersApart) {
  expect_failure(read_flat_yaml(folder_ / "absent.yaml", &entries_), StatusCode::kNotFound,
                 folder_ / "absent.yaml", 0, "does not exist");
  expect_failure(read_flat_yaml(folder_.path(), &entries_), StatusCode::kCorruptData,
                 folder_.path(), 0, "is a folder");
  expect_failure(read_flat_yaml("", &entries_), StatusCode::kInvalidArgument, "", 0,
                 "not a file name");
}

TEST_F(FlatYaml, AcceptsUnicodeAndRefusesWhatIsNotUnicode) {
  EXPECT_TRUE(read("a: Grün 深度 \xF0\x9F\x98\x80\n").ok());
  // Overlong, surrogate, beyond U+10FFFF, cut short, stray continuation.
  for (const std::string bad : {"\xC0\xAF", "\xE0\x80\xAF", "\xED\xA0\x80", "\xF4\x90\x80\x80",
                                "\xF0\x80\x80\x80", "\xE6\xB7", "\x80", "\xF8\x88\x80\x80\x80"}) {
    expect_failure(read("# " + bad + "\n"), StatusCode::kCorruptData, path_, 1, "UTF-8");
  }
}

TEST(FlatYamlValues, ParseWholeTextsOnly) {
  double number = 7.0;
  EXPECT_TRUE(parse_double("-2.5e-1", &number));
  EXPECT_EQ(number, -0.25);
  for (const char* text : {"", "1 ", "1x", "nan", "inf", "1e999"}) {
    EXPECT_FALSE(parse_double(text, &number)) << text;
  }
  EXPECT_EQ(number, -0.25);

  int integer = 7;
  EXPECT_TRUE(parse_int("+12", &integer));
  EXPECT_EQ(integer, 12);
  EXPECT_TRUE(parse_int("-2147483648", &integer));
  EXPECT_EQ(integer, std::numeric_limits<int>::min());
  for (const char* text : {"", "+", "-", "+-1", "1.0", "1e3", "0x1", "2147483648", " 1", "1 "}) {
    EXPECT_FALSE(parse_int(text, &integer)) << text;
  }
  EXPECT_EQ(integer, std::numeric_limits<int>::min());

  bool flag = false;
  EXPECT_TRUE(parse_bool("true", &flag));
  EXPECT_TRUE(flag);
  for (const char* text : {"", "True", "yes", "1", "false "}) {
    EXPECT_FALSE(parse_bool(text, &flag)) << text;
  }
  EXPECT_TRUE(flag);
  EXPECT_TRUE(parse_bool("false", &flag));
  EXPECT_FALSE(flag);
}

TEST(FlatYamlValues, FailuresNameFileLineKeyAndWhatIsRight) {
  const FlatYamlEntry entry{"fps", "fast", 12};
  double number = 0.0;
  int integer = 0;
  bool flag = false;
  expect_failure(read_value("c.yaml", entry, &number), StatusCode::kInvalidArgument, "c.yaml", 12,
                 "value 'fast' of key 'fps' is not a finite decimal number such as 0.25");
  expect_failure(read_value("c.yaml", entry, &integer), StatusCode::kInvalidArgument, "c.yaml", 12,
                 "is not a whole number such as 640");
  expect_failure(read_value("c.yaml", entry, &flag), StatusCode::kInvalidArgument, "c.yaml", 12,
                 "is not `true` or `false`");
  expect_failure(unknown_key("c.yaml", entry, {"a", "b"}), StatusCode::kInvalidArgument, "c.yaml",
                 12, "unknown key 'fps'; known keys: a, b");
}

TEST(FlatYamlValues, LongTextsAreShortenedAtACharacter) {
  std::string value(59, 'x');
  value += "\xC3\xBC\xC3\xBC tail";
  double number = 0.0;
  const FileStatus status = read_value("c.yaml", {"k", value, 1}, &number);
  EXPECT_NE(status.reason.find("'" + std::string(59, 'x') + "...'"), std::string::npos)
      << status.reason;
}

}  // namespace
}  // namespace srslam
