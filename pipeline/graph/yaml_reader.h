// Reads values of a YAML file. Every error message has file:line and the path of keys.
#pragma once

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "pipeline/text/setting.h"

namespace keypose::pipeline {

/// The one document of a YAML text.
/// @param file         the name of the file in messages
/// @param most_values  with those that aliases repeat
/// @throws UsageError  not UTF-8, more than one document, or aliases that stand for
/// themselves or for millions of values; with file:line
/// @throws YAML::Exception  not YAML
YAML::Node LoadYaml(const std::string& text, const std::string& file,
                    std::size_t most_values = 3'000'000);

/// Every function throws UsageError when the node is not what it reads; `what` names it in the
/// message.
class YamlReader {
 public:
  explicit YamlReader(std::string file) : file_(std::move(file)) {}

  Where At(const YAML::Node& node) const { return {file_, node.Mark().line + 1}; }
  [[noreturn]] void Fail(const YAML::Node& node, const std::string& message) const;
  /// For a key that is not among the known ones; names the nearest.
  [[noreturn]] void Unknown(const YAML::Node& key, const std::string& what,
                            const std::vector<std::string>& known) const;

  /// Calls `entry(key, key_node, value)` for each entry of a map with unique text keys.
  template <class Entry>
  void Map(const YAML::Node& node, const std::string& what, const Entry& entry) const {
    if (node.IsNull()) return;
    if (!node.IsMap()) Fail(node, fmt::format("{} must be a map of `key: value` lines", what));
    std::set<std::string> seen;
    for (const auto& pair : node) {
      if (!pair.first.IsScalar())
        Fail(pair.first, fmt::format("a key of {} must be a plain word", what));
      const std::string key = pair.first.Scalar();
      if (!seen.insert(key).second)
        Fail(pair.first, fmt::format("{} has the key '{}' twice", what, key));
      entry(key, pair.first, pair.second);
    }
  }

  Setting Text(const YAML::Node& node, const std::string& what) const;
  /// A path. `~` is replaced later, but errors in it are reported here, with file:line.
  Setting PathText(const YAML::Node& node, const std::string& what) const;
  /// One of a few words.
  Setting Choice(const YAML::Node& node, const std::string& what,
                 const std::vector<std::string>& words) const;
  double Number(const YAML::Node& node, const std::string& what) const;
  bool Bool(const YAML::Node& node, const std::string& what) const;
  /// A key that folders are named by.
  void CheckName(const YAML::Node& key, const std::string& what) const;

 private:
  std::string file_;
};

}  // namespace keypose::pipeline
