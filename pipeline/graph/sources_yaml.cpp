#include "pipeline/graph/sources_yaml.h"

#include <algorithm>
#include <map>

#include "core/values/errors.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline {
namespace {

SourceOf OwnerIn(const YamlReader& reader, const YAML::Node& node) {
  static const std::map<std::string, SourceOf> kOwners = {{"pose", SourceOf::kPose},
                                                          {"pair", SourceOf::kPair},
                                                          {"shot", SourceOf::kShot},
                                                          {"project", SourceOf::kProject}};
  return kOwners.at(reader.Choice(node, "of", {"pose", "pair", "shot", "project"}).text);
}

std::vector<Setting> PathsIn(const YamlReader& reader, const YAML::Node& node,
                             const std::string& what) {
  if (!node.IsSequence()) return {reader.PathText(node, what)};
  std::vector<Setting> paths;
  for (const YAML::Node& item : node) paths.push_back(reader.PathText(item, what));
  return paths;
}

/// Words of sources are keys beside those that mean something else.
void RequireFreeWord(const YamlReader& reader, const YAML::Node& key) {
  const std::string& word = key.Scalar();
  if (!IsName(word)) reader.Fail(key, fmt::format("the source '{}' may have {}", word, kNameRule));
  std::vector<std::string> taken = {kTimelineWord, kRunWord, kUnmaskedWord, "pose"};
  for (const auto* keys : {&kOptionWords, &kPoseKeys, &kFilmedShotKeys, &kFileKeys})
    taken.insert(taken.end(), keys->begin(), keys->end());
  if (std::find(taken.begin(), taken.end(), word) != taken.end())
    reader.Fail(key, fmt::format("'{}' cannot be a source: the word means something else in a "
                                 "pipeline file; choose another one",
                                 word));
}

void ReadField(const YamlReader& reader, const std::string& what, const YAML::Node& key,
               const YAML::Node& value, SourceRule* rule) {
  const std::string& field = key.Scalar();
  const std::string path = what + "." + field;
  if (field == "of")
    rule->of = OwnerIn(reader, value);
  else if (field == "default")
    rule->defaults = PathsIn(reader, value, path);
  else if (field == "always")
    rule->always = reader.Bool(value, path);
  else if (field == "required")
    rule->required = reader.Text(value, path).text;
  else if (field == "unpaired")
    rule->unpaired = reader.Text(value, path).text;
  else if (field == "no_fit")
    rule->no_fit = reader.Text(value, path).text;
  else if (field == "kind")
    rule->kind = reader.Choice(value, field, {"poses", "performance"}).text;
  else
    reader.Unknown(key, what,
                   {"of", "default", "always", "required", "unpaired", "no_fit", "kind"});
}

}  // namespace

std::vector<SourceRule> ReadSources(const YamlReader& reader, const YAML::Node& node) {
  std::vector<SourceRule> rules;
  const auto add = [&](const std::string& word, const YAML::Node& key, const YAML::Node& value) {
    RequireFreeWord(reader, key);
    SourceRule rule;
    rule.word = word;
    rule.where = reader.At(key);
    const std::string what = "source '" + word + "'";
    reader.Map(value, what, [&](const std::string&, const YAML::Node& field, const YAML::Node& v) {
      ReadField(reader, what, field, v, &rule);
    });
    if (!value.IsMap() || !value["of"])
      reader.Fail(key, fmt::format("{} does not say whose it is; add it, as in `{}: {{of: pose}}` "
                                   "(or pair, shot, project)",
                                   what, word));
    rules.push_back(std::move(rule));
  };
  reader.Map(node, "sources", add);
  return rules;
}

GivenSource ReadGiven(const YamlReader& reader, const std::string& word, const YAML::Node& key,
                      const YAML::Node& value) {
  GivenSource source{word, {}, reader.At(key), ""};
  try {
    source.path = reader.PathText(value, word);
  } catch (const UsageError& error) {
    source.fault = error.what();
  }
  return source;
}

}  // namespace keypose::pipeline
