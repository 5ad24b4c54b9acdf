#include "cli/modules.hpp"

#include <algorithm>

#include "cli/text_list.hpp"

namespace srslam::cli {
namespace {

const Module* find_module(char letter, const std::vector<Module>& modules) {
  const auto found = std::find_if(modules.begin(), modules.end(), [letter](const Module& module) {
    return module.letter == letter;
  });
  return found == modules.end() ? nullptr : &*found;
}

std::string describe_modules(const std::vector<Module>& modules) {
  std::string text;
  for (const Module& module : modules) {
    if (!text.empty()) text += ", ";
    text += std::string(1, module.letter) + " (" + module.name + ")";
  }
  return text;
}

}  // namespace

const std::vector<Module>& known_modules() {
  static const std::vector<Module> modules = {
      {'S', "scene reliability", true, ""},
      {'P', "pose refinement", false, "S"},
      {'D', "dynamic culling", true, "S"},
      {'B', "back-end keyframes and weighting", false, "S"},
  };
  return modules;
}

std::string ModuleSelection::text() const {
  if (letters.empty()) return "none";
  std::string joined;
  for (const char letter : letters) {
    if (!joined.empty()) joined += ',';
    joined += letter;
  }
  return joined;
}

ModuleSelection default_modules(const std::vector<Module>& modules) {
  ModuleSelection selection;
  for (const Module& module : modules) {
    if (module.built) selection.letters += module.letter;
  }
  return selection;
}

std::string parse_modules(const std::string& text, const std::vector<Module>& modules,
                          ModuleSelection* selection) {
  const std::vector<std::string> parts = split_at_commas(text);
  if (parts.size() == 1 && parts.front() == "none") {
    selection->letters.clear();
    return {};
  }
  std::string wanted;
  for (const std::string& part : parts) {
    const Module* module = part.size() == 1 ? find_module(part.front(), modules) : nullptr;
    if (module == nullptr) {
      return "unknown module '" + part + "': give none, or letters separated by commas out of " +
             describe_modules(modules);
    }
    if (wanted.find(module->letter) != std::string::npos) {
      return "module '" + part + "' is given twice";
    }
    wanted += module->letter;
  }
  ModuleSelection result;
  for (const Module& module : modules) {
    if (wanted.find(module.letter) == std::string::npos) continue;
    for (const char* required = module.requirements; *required != '\0'; ++required) {
      if (wanted.find(*required) == std::string::npos) {
        return std::string("module '") + module.letter + "' (" + module.name + ") needs module '" +
               *required + "': give it too";
      }
    }
    result.letters += module.letter;
  }
  // Last, so that a selection that would be wrong in any version is told so first.
  for (const char letter : result.letters) {
    const Module* module = find_module(letter, modules);
    if (!module->built) {
      return std::string("module '") + letter + "' (" + module->name +
             ") is known but not built in this version: use --modules " +
             default_modules(modules).text();
    }
  }
  *selection = result;
  return {};
}

}  // namespace srslam::cli
