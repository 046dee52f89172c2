#include "pipeline/graph/timeline_yaml.h"

#include <yaml-cpp/yaml.h>

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/values/timeline.h"

namespace keypose::pipeline {
namespace {

using Json = nlohmann::ordered_json;

/// The value of an unquoted YAML word: a number, true, false, or the text itself.
Json ScalarJson(const YAML::Node& node) {
  const std::string& text = node.Scalar();
  if (node.Tag() == "!") return text;  // quoted
  if (text == "true" || text == "false") return text == "true";
  long whole = 0;
  double number = 0;
  const char *begin = text.data(), *end = begin + text.size();
  if (const auto [at, error] = std::from_chars(begin, end, whole);
      error == std::errc() && at == end)
    return whole;
  if (const auto [at, error] = std::from_chars(begin, end, number);
      error == std::errc() && at == end && std::isfinite(number))
    return number;
  return text;
}

Json ToJson(const YAML::Node& node) {
  if (node.IsSequence()) {
    Json list = Json::array();
    for (const YAML::Node& item : node) list.push_back(ToJson(item));
    return list;
  }
  if (node.IsMap()) {
    Json map = Json::object();
    for (const auto& pair : node) {
      const std::string key = pair.first.Scalar();
      // Names stay text even if they look like numbers.
      const bool name =
          (key == "pose" || key == "name" || key == "region") && pair.second.IsScalar();
      map[key] = name ? Json(pair.second.Scalar()) : ToJson(pair.second);
    }
    return map;
  }
  return node.IsScalar() ? ScalarJson(node) : Json();
}

}  // namespace

std::string TimelineJson(const YAML::Node& node, double fps) {
  const YAML::Node list = node.IsMap() ? node["keys"] : node;
  bool says_more = node.IsMap() && node.size() > 1;
  Json keys = Json::array();
  for (const YAML::Node& item : list) {
    Json key = item.IsMap() ? ToJson(item) : Json::object();
    if (!item.IsMap()) key["pose"] = item.Scalar();
    if (key.contains("at")) {
      key["time"] = key["at"];
      key.erase("at");
    }
    says_more = says_more || key.size() > 1;
    keys.push_back(std::move(key));
  }
  Json timeline = node.IsMap() ? ToJson(node) : Json::object();
  timeline["schema"] = 2;
  timeline["fps"] = fps;
  timeline["keys"] = std::move(keys);
  return says_more ? timeline.dump(1, ' ', false, Json::error_handler_t::replace) : "";
}

std::string OrderJson(const std::vector<std::string>& poses, double fps) {
  if (poses.size() < 2 || fps == Timeline().fps) return "";
  Json keys = Json::array();
  for (const std::string& pose : poses) keys.push_back({{"pose", pose}});
  const Json timeline = {{"schema", 2}, {"fps", fps}, {"keys", keys}};
  return timeline.dump(1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace keypose::pipeline
