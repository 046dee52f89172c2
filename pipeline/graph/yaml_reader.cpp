#include "pipeline/graph/yaml_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "core/values/errors.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/graph/stage_info.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline {
namespace {

/// Aliases can contain themselves, and a few lines of them can stand for more values than fit in
/// memory. This check makes sure that a walk through the tree ends.
/// @param left  number of values still allowed
void RequireThatItEnds(const YamlReader& reader, const YAML::Node& node, int level,
                       std::size_t* left) {
  constexpr int kMostLevels = 50;
  if (level > kMostLevels)
    reader.Fail(node, fmt::format("lists and maps are nested more than {} levels deep; does an "
                                  "alias (`*name`) contain itself?",
                                  kMostLevels));
  if ((*left)-- == 0)
    reader.Fail(node, "aliases (`*name`) expand the file to millions of values; use fewer of them");
  if (node.IsSequence())
    for (const YAML::Node& item : node) RequireThatItEnds(reader, item, level + 1, left);
  if (node.IsMap())
    for (const auto& pair : node) {
      RequireThatItEnds(reader, pair.first, level + 1, left);
      RequireThatItEnds(reader, pair.second, level + 1, left);
    }
}

/// UTF-16, which YAML recognises by its first two bytes, is accepted too.
void RequireUtf8(const std::string& text, const std::string& file) {
  if (IsUtf8(text) || text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) return;
  std::size_t line = 1, begin = 0;
  for (std::size_t end; (end = text.find('\n', begin)) != std::string::npos &&
                        IsUtf8(text.substr(begin, end - begin));
       begin = end + 1)
    ++line;
  throw UsageError(
      fmt::format("{}:{}: a letter here is not UTF-8 text; save the file as UTF-8", file, line));
}

/// Everything after a `---` would be ignored without a message. Such a line begins a document
/// anywhere, even in quotes. (The library's reader of all documents never ends on some texts.)
void RequireOneDocument(const std::string& text, const std::string& file) {
  std::istringstream lines(text);
  bool content = false;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const bool marker =
        line.starts_with("---") && (line.size() == 3 || line[3] == ' ' || line[3] == '\r');
    if (marker && content)
      throw UsageError(fmt::format(
          "{}:{}: a second document (after `---`) is not read; write all in one", file, number));
    const std::size_t first = line.find_first_not_of(" \t\r");
    content = content || marker ||
              (first != std::string::npos && line[first] != '#' && line[first] != '%');
  }
}

}  // namespace

YAML::Node LoadYaml(const std::string& text, const std::string& file, std::size_t most_values) {
  RequireUtf8(text, file);
  RequireOneDocument(text, file);
  const YAML::Node root = YAML::Load(text);
  RequireThatItEnds(YamlReader(file), root, 0, &most_values);
  return root;
}

void YamlReader::Fail(const YAML::Node& node, const std::string& message) const {
  throw UsageError(fmt::format("{}: {}", At(node).Text(), message));
}

Setting YamlReader::Text(const YAML::Node& node, const std::string& what) const {
  if (!node.IsScalar()) Fail(node, fmt::format("{} must be a single value", what));
  return {node.Scalar(), At(node)};
}

Setting YamlReader::PathText(const YAML::Node& node, const std::string& what) const {
  Setting setting = Text(node, what);
  try {
    WithHome(setting.text);
  } catch (const UsageError& error) {
    Fail(node, error.what());
  }
  return setting;
}

Setting YamlReader::Choice(const YAML::Node& node, const std::string& what,
                           const std::vector<std::string>& words) const {
  Setting setting = Text(node, what);
  if (std::find(words.begin(), words.end(), setting.text) == words.end())
    Fail(node, fmt::format("`{}: {}` is not known{}", what, setting.text,
                           Suggestion(setting.text, words)));
  return setting;
}

void YamlReader::Unknown(const YAML::Node& key, const std::string& what,
                         const std::vector<std::string>& known) const {
  Fail(key,
       fmt::format("{} has no key '{}'{}", what, key.Scalar(), Suggestion(key.Scalar(), known)));
}

void YamlReader::CheckName(const YAML::Node& key, const std::string& what) const {
  if (IsName(key.Scalar())) return;
  Fail(key, fmt::format("{} '{}' may have {}, because folders are named by it", what, key.Scalar(),
                        kNameRule));
}

double YamlReader::Number(const YAML::Node& node, const std::string& what) const {
  const Setting setting = Text(node, what);
  double value = 0;
  const char* end_of_text = setting.text.data() + setting.text.size();
  const auto [end, error] = std::from_chars(setting.text.data(), end_of_text, value);
  if (error != std::errc() || end != end_of_text || !std::isfinite(value))
    Fail(node, fmt::format("{} is '{}', but it must be a number", what, setting.text));
  return value;
}

bool YamlReader::Bool(const YAML::Node& node, const std::string& what) const {
  const Setting setting = Text(node, what);
  if (setting.text != "true" && setting.text != "false")
    Fail(node, fmt::format("{} is '{}', but it must be true or false", what, setting.text));
  return setting.text == "true";
}

}  // namespace keypose::pipeline
