#include "cli/modules.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace srslam::cli {
namespace {

/// A version in which all but B is built.
std::vector<Module> later_modules() {
  std::vector<Module> modules = known_modules();
  for (Module& module : modules) module.built = module.letter != 'B';
  return modules;
}

struct Parsed {
  std::string reason;
  std::string letters;
};

Parsed parse(const std::string& text, const std::vector<Module>& modules) {
  ModuleSelection selection;
  selection.letters = "untouched";
  Parsed parsed;
  parsed.reason = parse_modules(text, modules, &selection);
  parsed.letters = selection.letters;
  return parsed;
}

void expect_refused(const std::string& text, const std::vector<Module>& modules,
                    const std::string& reason_part) {
  const Parsed parsed = parse(text, modules);
  EXPECT_NE(parsed.reason.find(reason_part), std::string::npos)
      << "'" << text << "' should give '" << reason_part << "', gave '" << parsed.reason << "'";
  EXPECT_EQ(parsed.letters, "untouched") << text;
}

TEST(Modules, TableHoldsThePapersModulesInTheOrderOfTheFlow) {
  std::string letters;
  for (const Module& module : known_modules()) {
    letters += module.letter;
    EXPECT_EQ(std::string(module.requirements), module.letter == 'S' ? "" : "S");
  }
  EXPECT_EQ(letters, "SPDB");
}

TEST(Modules, NoneIsTheBaseline) {
  for (const std::vector<Module>& modules : {known_modules(), later_modules()}) {
    const Parsed parsed = parse("none", modules);
    EXPECT_EQ(parsed.reason, "");
    EXPECT_EQ(parsed.letters, "");
  }
}

TEST(Modules, DefaultIsEveryBuiltModule) {
  EXPECT_EQ(default_modules(later_modules()).letters, "SPD");
  EXPECT_EQ(default_modules(later_modules()).text(), "S,P,D");
  std::string built;
  for (const Module& module : known_modules()) {
    if (module.built) built += module.letter;
  }
  EXPECT_EQ(default_modules(known_modules()).letters, built);
}

TEST(Modules, BuiltModulesAreTakenInTableOrder) {
  for (const char* text : {"S,D", "D,S", " D , S "}) {
    const Parsed parsed = parse(text, later_modules());
    EXPECT_EQ(parsed.reason, "") << text;
    EXPECT_EQ(parsed.letters, "SD") << text;
  }
}

TEST(Modules, EveryModuleThatIsNotBuiltIsANamedError) {
  for (const Module& module : known_modules()) {
    if (module.built) continue;
    const std::string letter(1, module.letter);
    const std::string text = module.letter == 'S' ? letter : "S," + letter;
    expect_refused(text, known_modules(), "known but not built in this version");
  }
  expect_refused("S,B", later_modules(),
                 "module 'B' (back-end keyframes and weighting) is known but not built in this "
                 "version: use --modules S,P,D");
}

TEST(Modules, AModuleWithoutItsRequirementIsAnErrorThatNamesIt) {
  for (const char* letter : {"P", "D", "B"}) {
    expect_refused(letter, known_modules(), "needs module 'S'");
    expect_refused(letter, later_modules(), "needs module 'S'");
  }
}

TEST(Modules, UnknownTextIsAnErrorThatListsTheModules) {
  for (const char* text : {"X", "s", "SP", "S,,P", "S,", ",S", "", "none,S", "None"}) {
    expect_refused(text, later_modules(), "unknown module");
    expect_refused(text, later_modules(), "S (scene reliability), P (pose refinement)");
  }
}

TEST(Modules, ARepeatedModuleIsAnError) {
  expect_refused("S,P,S", later_modules(), "module 'S' is given twice");
}

}  // namespace
}  // namespace srslam::cli
