#include "core/io/text/yaml_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/io/text/yaml_text.inc"
#include "core/values/file_names.h"

namespace keypose {

using namespace yaml_text;

namespace {

/// {a: {b: value}} for the levels that are missing below `depth`.
std::string Nested(const YamlPath& path, std::size_t depth, const std::string& value) {
  std::string text = value;
  for (std::size_t i = path.size(); i-- > depth;)
    text = fmt::format("{{{}: {}}}", YamlScalar(path[i]), text);
  return text;
}

/// The entry's value replaced; a block's lines become one.
std::string WithEntry(const std::string& text, const Entry& entry, const std::string& value) {
  const bool block = (entry.value.IsMap() || entry.value.IsSequence()) && !IsFlow(entry.value);
  if (block) return Replaced(text, entry.value_span, " " + value + "\n");
  return Replaced(text, entry.value_span, entry.value.IsNull() ? " " + value : value);
}

std::string WithNewEntry(const std::string& text, const YAML::Node& map, const std::string& key,
                         const std::string& value) {
  const std::string entry = fmt::format("{}: {}", YamlScalar(key), value);
  if (IsFlow(map)) {
    const std::size_t close = BracketEnd(text, PositionOf(map)) - 1;
    const std::size_t last = text.find_last_not_of(" \n,", close - 1);
    return Replaced(text, {last + 1, close}, (map.size() == 0 ? "" : ", ") + entry);
  }
  Span last;
  std::size_t indent = 0;
  for (const auto& pair : map) {
    const Entry one = EntryOf(text, pair.first, pair.second, false);
    if (one.span.end >= last.end) last = one.span;
    indent = one.indent;
  }
  const std::string gap = last.end > 0 && text[last.end - 1] != '\n' ? "\n" : "";
  return Replaced(text, {last.end, last.end}, gap + std::string(indent, ' ') + entry + "\n");
}

std::string WithRoot(const std::string& text, const YamlPath& path, const std::string& value) {
  const std::string gap = text.empty() || text.back() == '\n' ? "" : "\n";
  return fmt::format("{}{}{}: {}\n", text, gap, YamlScalar(path[0]), Nested(path, 1, value));
}

std::string Edited(const std::string& text, const YamlPath& path, const std::string& value) {
  YAML::Node map = Parsed(text);
  if (map.IsNull()) return WithRoot(text, path, value);
  for (std::size_t depth = 0;; ++depth) {
    const std::optional<Entry> entry = FindEntry(text, map, path[depth]);
    if (!entry) return WithNewEntry(text, map, path[depth], Nested(path, depth + 1, value));
    const bool empty = entry->value.IsNull();
    if (depth + 1 == path.size() || empty)
      return WithEntry(text, *entry, Nested(path, depth + 1, value));
    if (!entry->value.IsMap())
      throw YamlEditError(fmt::format("'{}' holds a single value", path[depth]));
    map.reset(entry->value);
  }
}

/// The span to delete with an entry of a flow map: one comma goes too.
Span FlowSpan(const std::string& text, const Entry& entry) {
  Span span = entry.span;
  const std::size_t after = text.find_first_not_of(" \n", span.end);
  if (after != std::string::npos && text[after] == ',') {
    span.end = text.find_first_not_of(' ', after + 1);
  } else {
    const std::size_t before = text.find_last_not_of(" \n", span.begin - 1);
    if (text[before] == ',') span.begin = before;
  }
  return span;
}

}  // namespace

std::string YamlScalar(const std::string& value) {
  static const std::vector<std::string> kWords = {"true", "false", "yes", "no", "on",
                                                  "off",  "null",  "y",   "n",  "~"};
  const auto safe = [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '.' || c == '/' || c == '-' || c == '+' || c >= 0x80;
  };
  const std::string lower = LowerCase(value);
  const bool word = std::find(kWords.begin() + 2, kWords.end(), lower) != kWords.end();
  if (!value.empty() && std::all_of(value.begin(), value.end(), safe) && !word &&
      value.find_first_not_of("-.") != std::string::npos && value[0] != '-')
    return value;
  if (value.size() > 1 && value[0] == '-' &&
      value.find_first_not_of("0123456789.e+-") == std::string::npos)
    return value;  // a negative number
  return nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string WithValue(const std::string& text, const YamlPath& path, const std::string& value) {
  RequireEditable(text);
  const YAML::Node node = Parsed(value);
  return Checked(Edited(text, path, value), Wanted(text, path, &node));
}

std::string WithoutValue(const std::string& text, const YamlPath& path) {
  RequireEditable(text);
  YAML::Node map = Parsed(text);
  std::optional<Entry> doomed;
  for (const std::string& key : path) {
    const std::optional<Entry> entry = FindEntry(text, map, key);
    if (!entry) return text;
    // The outermost map that holds nothing else goes as a whole.
    if (!doomed || map.size() > 1) doomed = entry;
    map.reset(entry->value);
  }
  const Span span = doomed->in_flow ? FlowSpan(text, *doomed) : doomed->span;
  return Checked(Replaced(text, span, ""), Wanted(text, path, nullptr));
}

}  // namespace keypose
