#include "pipeline/cache/fingerprint.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/numbers/sha256.h"

namespace keypose::pipeline {
namespace {

using nlohmann::json;

/// The length goes first, so that different lists of fields never give the same text.
void AddField(std::string* text, const std::string& field) {
  *text += fmt::format("{}:{}\n", field.size(), field);
}

using Fields = std::map<std::string, std::string>;

void CompareFields(const std::string& what, const Fields& before, const Fields& now,
                   std::vector<std::string>* differences) {
  for (const auto& [name, value] : before) {
    const auto it = now.find(name);
    if (it == now.end())
      differences->push_back(fmt::format("{} {} is gone (was {})", what, name, value));
    else if (it->second != value)
      differences->push_back(fmt::format("{} {}: {} -> {}", what, name, value, it->second));
  }
  for (const auto& [name, value] : now) {
    if (!before.contains(name))
      differences->push_back(fmt::format("{} {} is new: {}", what, name, value));
  }
}

void CompareFolders(const RecipeInput& before, const RecipeInput& now,
                    std::vector<std::string>* differences) {
  constexpr std::size_t kShown = 5;
  std::vector<std::string> lines;
  const auto full = [&](const std::string& name) { return now.origin + "/" + name; };
  for (const auto& [name, hash] : before.content.files) {
    const auto it = now.content.files.find(name);
    if (it == now.content.files.end())
      lines.push_back(full(name) + " is gone");
    else if (it->second != hash)
      lines.push_back(full(name) + " changed");
  }
  for (const auto& [name, hash] : now.content.files) {
    if (!before.content.files.contains(name)) lines.push_back(full(name) + " is new");
  }
  for (std::size_t i = 0; i < std::min(lines.size(), kShown); ++i) differences->push_back(lines[i]);
  if (lines.size() > kShown)
    differences->push_back(
        fmt::format("and {} more files of {}", lines.size() - kShown, now.origin));
}

void CompareTimelines(const RecipeInput& before, const RecipeInput& now,
                      std::vector<std::string>* differences) {
  const std::size_t count = differences->size();
  CompareFields(now.origin + ",", before.content.settings, now.content.settings, differences);
  if (differences->size() == count)
    differences->push_back(now.origin + " says the same in another order or spelling");
}

/// What became of one thing that an input gets.
void CompareOne(const RecipeInput& before, const RecipeInput& now,
                std::vector<std::string>* differences) {
  if (before.content.hash == now.content.hash) return;
  if (!before.content.settings.empty() && !now.content.settings.empty())
    CompareTimelines(before, now, differences);
  else if (before.origin != now.origin)
    differences->push_back(
        fmt::format("input {} was {}, and is {} now", now.port, before.origin, now.origin));
  else if (before.content.files.empty() || now.content.files.empty())
    differences->push_back(fmt::format("{} changed", now.origin));
  else
    CompareFolders(before, now, differences);
}

using Inputs = std::vector<const RecipeInput*>;

/// Takes the first of that origin out of the list; null if there is none.
const RecipeInput* TakeOut(Inputs* inputs, const std::string& origin) {
  const auto found = std::find_if(inputs->begin(), inputs->end(), [&](const RecipeInput* input) {
    return input->origin == origin;
  });
  if (found == inputs->end()) return nullptr;
  const RecipeInput* input = *found;
  inputs->erase(found);
  return input;
}

/// All that one port gets. As many as before are compared in their order; else, what came and went
/// is told, and the others are compared by where they come from.
void ComparePort(const std::string& port, Inputs before, const Inputs& now,
                 std::vector<std::string>* differences) {
  if (before.size() == now.size()) {
    for (std::size_t i = 0; i < now.size(); ++i) CompareOne(*before[i], *now[i], differences);
    return;
  }
  for (const RecipeInput* input : now) {
    if (const RecipeInput* same = TakeOut(&before, input->origin))
      CompareOne(*same, *input, differences);
    else
      differences->push_back(fmt::format("input {} now also gets {}", port, input->origin));
  }
  for (const RecipeInput* input : before)
    differences->push_back(fmt::format("input {} no longer gets {}", port, input->origin));
}

void CompareInputs(const std::vector<RecipeInput>& before, const std::vector<RecipeInput>& now,
                   std::vector<std::string>* differences) {
  std::vector<std::string> ports;
  for (const auto* inputs : {&before, &now})
    for (const RecipeInput& input : *inputs)
      if (std::find(ports.begin(), ports.end(), input.port) == ports.end())
        ports.push_back(input.port);
  const auto of_port = [](const std::vector<RecipeInput>& inputs, const std::string& port) {
    Inputs of;
    for (const RecipeInput& input : inputs)
      if (input.port == port) of.push_back(&input);
    return of;
  };
  for (const std::string& port : ports)
    ComparePort(port, of_port(before, port), of_port(now, port), differences);
}

}  // namespace

Content FolderContent(std::map<std::string, std::string> files) {
  std::string text;
  for (const auto& [name, hash] : files) {
    AddField(&text, name);
    AddField(&text, hash);
  }
  return {Sha256Of(text), std::move(files)};
}

std::string Recipe::Fingerprint() const {
  std::string text = "keypose fingerprint 1\n";
  AddField(&text, stage);
  AddField(&text, version);
  for (const auto* fields : {&tools, &options}) {
    text += fmt::format("{} fields\n", fields->size());
    for (const auto& [name, value] : *fields) {
      AddField(&text, name);
      AddField(&text, value);
    }
  }
  for (const RecipeInput& input : inputs) {
    AddField(&text, input.port);
    AddField(&text, input.content.hash);
  }
  return Sha256Of(text);
}

json ToJson(const Recipe& recipe) {
  json inputs = json::array();
  for (const RecipeInput& input : recipe.inputs) {
    json entry = {{"port", input.port}, {"origin", input.origin}, {"sha256", input.content.hash}};
    if (!input.content.files.empty()) entry["files"] = input.content.files;
    if (!input.content.settings.empty()) entry["settings"] = input.content.settings;
    inputs.push_back(std::move(entry));
  }
  return {{"stage", recipe.stage},
          {"version", recipe.version},
          {"tools", recipe.tools},
          {"options", recipe.options},
          {"inputs", inputs}};
}

Recipe RecipeFromJson(const json& value) {
  Recipe recipe;
  recipe.stage = value.at("stage").get<std::string>();
  recipe.version = value.at("version").get<std::string>();
  recipe.tools = value.at("tools").get<Fields>();
  recipe.options = value.at("options").get<Fields>();
  for (const json& entry : value.at("inputs")) {
    RecipeInput input{entry.at("port").get<std::string>(),
                      entry.at("origin").get<std::string>(),
                      {entry.at("sha256").get<std::string>(), {}}};
    if (entry.contains("files")) input.content.files = entry["files"].get<Fields>();
    if (entry.contains("settings")) input.content.settings = entry["settings"].get<Fields>();
    recipe.inputs.push_back(std::move(input));
  }
  return recipe;
}

std::vector<std::string> Differences(const Recipe& before, const Recipe& now) {
  std::vector<std::string> differences;
  if (before.stage != now.stage)
    differences.push_back(fmt::format("the stage is another: {} -> {}", before.stage, now.stage));
  if (before.version != now.version)
    differences.push_back(
        fmt::format("the stage's version: {} -> {}", before.version, now.version));
  CompareFields("version of the tool", before.tools, now.tools, &differences);
  CompareFields("option", before.options, now.options, &differences);
  CompareInputs(before.inputs, now.inputs, &differences);
  return differences;
}

}  // namespace keypose::pipeline
