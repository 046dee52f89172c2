#include "core/io/yaml_edit.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

namespace keypose {
namespace {

YAML::Node Parsed(const std::string& text) {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw YamlEditError(fmt::format("it is not YAML: {}", error.what()));
  }
}

/// From the first byte to the one after the last.
struct Span {
  std::size_t begin = 0, end = 0;
};

std::size_t LineEnd(const std::string& text, std::size_t at) {
  return std::min(text.find('\n', at), text.size());
}
std::size_t LineBegin(const std::string& text, std::size_t at) {
  const std::size_t before = at == 0 ? std::string::npos : text.rfind('\n', at - 1);
  return before == std::string::npos ? 0 : before + 1;
}
std::size_t NextLine(const std::string& text, std::size_t at) {
  return std::min(LineEnd(text, at) + 1, text.size());
}
std::size_t IndentOf(const std::string& text, std::size_t line) {
  return text.find_first_not_of(' ', line) - line;
}
bool IsBlankOrComment(const std::string& text, std::size_t line) {
  const std::size_t first = text.find_first_not_of(" \t\r", line);
  return first == std::string::npos || text[first] == '\n' || text[first] == '#';
}

/// The end of a text in quotes that begins at `at`.
std::size_t QuotedEnd(const std::string& text, std::size_t at) {
  const char quote = text[at];
  for (++at; at < text.size(); ++at) {
    if (quote == '"' && text[at] == '\\') {
      ++at;
    } else if (text[at] == quote) {
      if (quote == '\'' && at + 1 < text.size() && text[at + 1] == quote) {
        ++at;
      } else {
        return at + 1;
      }
    }
  }
  throw YamlEditError("a quote has no end");
}

bool BeginsComment(const std::string& text, std::size_t at) {
  return text[at] == '#' && (at == 0 || text[at - 1] == ' ' || text[at - 1] == '\n');
}

/// The end of [..] or {..} that begins at `at`.
std::size_t BracketEnd(const std::string& text, std::size_t at) {
  int depth = 0;
  while (at < text.size()) {
    const char c = text[at];
    const bool word = at > 0 && std::string(" ,[{:\n").find(text[at - 1]) == std::string::npos;
    if ((c == '"' || c == '\'') && !word) {
      at = QuotedEnd(text, at);
      continue;
    }
    if (BeginsComment(text, at)) at = LineEnd(text, at);
    if (c == '[' || c == '{') ++depth;
    if ((c == ']' || c == '}') && --depth == 0) return at + 1;
    ++at;
  }
  throw YamlEditError("a bracket has no end");
}

std::size_t PlainEnd(const std::string& text, std::size_t at, bool in_flow) {
  std::size_t end = at;
  for (; at < LineEnd(text, at) && at < text.size(); ++at) {
    if (BeginsComment(text, at)) break;
    if (in_flow && std::string(",]}").find(text[at]) != std::string::npos) break;
    if (text[at] != ' ' && text[at] != '\r') end = at + 1;
  }
  return end;
}

/// One entry of a map, or one item of a list.
struct Entry {
  YAML::Node key, value;
  Span span;        ///< key and value; in block style, whole lines
  Span value_span;  ///< the value alone; empty after the colon if there is none
  std::size_t indent = 0;
  bool in_flow = false;
};

bool IsFlow(const YAML::Node& node) { return node.Style() == YAML::EmitterStyle::Flow; }
std::size_t PositionOf(const YAML::Node& node) { return static_cast<std::size_t>(node.Mark().pos); }

/// The first line after a block whose first line has this indent.
std::size_t BlockEnd(const std::string& text, std::size_t line, std::size_t indent,
                     bool dashes_belong) {
  std::size_t end = NextLine(text, line);
  for (std::size_t at = end; at < text.size(); at = NextLine(text, at)) {
    if (IsBlankOrComment(text, at)) {
      // A comment at the block's own depth belongs to it; one farther out to what follows.
      if (text[text.find_first_not_of(' ', at)] == '#' && IndentOf(text, at) > indent)
        end = NextLine(text, at);
      continue;
    }
    const std::size_t own = IndentOf(text, at);
    const bool dash = dashes_belong && own == indent && text[at + own] == '-';
    if (own <= indent && !dash) break;
    end = NextLine(text, at);
  }
  return end;
}

std::size_t ValueEnd(const std::string& text, const YAML::Node& value, bool in_flow) {
  const std::size_t at = PositionOf(value);
  if (value.IsMap() || value.IsSequence()) return BracketEnd(text, at);
  if (at < text.size() && (text[at] == '"' || text[at] == '\'')) return QuotedEnd(text, at);
  return PlainEnd(text, at, in_flow);
}

std::size_t AfterColon(const std::string& text, const YAML::Node& key) {
  const std::size_t begin = PositionOf(key);
  const std::size_t end =
      text[begin] == '"' || text[begin] == '\'' ? QuotedEnd(text, begin) : begin;
  return text.find(':', end) + 1;
}

Entry EntryOf(const std::string& text, const YAML::Node& key, const YAML::Node& value,
              bool in_flow) {
  Entry entry{key, value, {}, {}, 0, in_flow};
  const std::size_t begin = PositionOf(key);
  const std::size_t colon = AfterColon(text, key);
  const std::size_t line = LineBegin(text, begin);
  entry.indent = begin - line;
  const bool block = (value.IsMap() || value.IsSequence()) && !IsFlow(value);
  if (value.IsNull()) {
    entry.value_span = {colon, PlainEnd(text, colon, in_flow)};
    if (entry.value_span.end < colon) entry.value_span.end = colon;
  } else if (block) {
    entry.value_span = {colon, BlockEnd(text, line, entry.indent, value.IsSequence())};
  } else {
    entry.value_span = {PositionOf(value), ValueEnd(text, value, in_flow)};
  }
  entry.span = {begin, entry.value_span.end};
  if (!in_flow)
    entry.span = {line, block ? entry.value_span.end : NextLine(text, entry.value_span.end)};
  return entry;
}

std::optional<Entry> FindEntry(const std::string& text, const YAML::Node& map,
                               const std::string& name) {
  if (!map.IsMap()) return std::nullopt;
  for (const auto& pair : map)
    if (pair.first.IsScalar() && pair.first.Scalar() == name)
      return EntryOf(text, pair.first, pair.second, IsFlow(map));
  return std::nullopt;
}

/// {a: {b: value}} for the levels that are missing below `depth`.
std::string Nested(const YamlPath& path, std::size_t depth, const std::string& value) {
  std::string text = value;
  for (std::size_t i = path.size(); i-- > depth;)
    text = fmt::format("{{{}: {}}}", YamlScalar(path[i]), text);
  return text;
}

std::string Replaced(const std::string& text, const Span& span, const std::string& with) {
  return text.substr(0, span.begin) + with + text.substr(span.end);
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

/// Both as text without style, to compare meanings.
std::string Meaning(const YAML::Node& node) {
  if (!node.IsDefined() || node.IsNull()) return "~";
  if (node.IsScalar()) return nlohmann::json(node.Scalar()).dump();
  std::vector<std::string> parts;
  if (node.IsMap()) {
    for (const auto& pair : node) parts.push_back(Meaning(pair.first) + ":" + Meaning(pair.second));
    std::sort(parts.begin(), parts.end());
  } else {
    for (const auto& item : node) parts.push_back(Meaning(item));
  }
  std::string all = node.IsMap() ? "{" : "[";
  for (const std::string& part : parts) all += part + ",";
  return all + (node.IsMap() ? "}" : "]");
}

/// Changes the parsed file in the same way, to check the text against.
YAML::Node Wanted(const std::string& text, const YamlPath& path, const YAML::Node* value) {
  YAML::Node root = Parsed(text);
  if (root.IsNull()) root = YAML::Node(YAML::NodeType::Map);
  std::vector<YAML::Node> above = {root};
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    YAML::Node next = above.back()[path[i]];
    if (!next.IsDefined() || next.IsNull()) {
      if (!value) return root;
      above.back()[path[i]] = YAML::Node(YAML::NodeType::Map);
      next.reset(above.back()[path[i]]);
    }
    if (!next.IsMap()) throw YamlEditError(fmt::format("'{}' holds a single value", path[i]));
    above.push_back(next);
  }
  if (value) {
    above.back()[path.back()] = *value;
    return root;
  }
  for (std::size_t i = path.size(); i-- > 0;) {
    above[i].remove(path[i]);
    if (above[i].size() > 0) break;
  }
  return root;
}

std::string Checked(std::string edited, const YAML::Node& wanted) {
  if (Meaning(Parsed(edited)) == Meaning(wanted) || (Parsed(edited).IsNull() && wanted.size() == 0))
    return edited;
  throw YamlEditError("its form is unusual; change it in an editor");
}

/// Finds places that repeat another place's value: a change there would be a change here.
class AliasFinder final : public YAML::EventHandler {
 public:
  bool found = false;
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override { found = true; }
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t,
                const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}
};

bool HasAliases(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  AliasFinder finder;
  try {
    parser.HandleNextDocument(finder);
  } catch (const YAML::Exception&) {
    return false;  // Parsed says what is wrong
  }
  return finder.found;
}

void RequireEditable(const std::string& text) {
  if (HasAliases(text)) throw YamlEditError("it has aliases (*name)");
  for (std::size_t line = 0; line < text.size(); line = NextLine(text, line)) {
    const std::size_t end = LineEnd(text, line);
    const std::string content = text.substr(line, end - line);
    if (content.find('\t') < content.find_first_not_of(" \t"))
      throw YamlEditError("a line begins with a tab");
    if (content.rfind("---", 0) == 0 || content.rfind("...", 0) == 0)
      throw YamlEditError("it has marks of documents (--- or ...)");
  }
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

struct Item {
  std::string meaning, line;  ///< `line` with the comments above it
  Span value;                 ///< within `line`
};

/// The items of a block list whose items take a line each; none if any takes more.
std::vector<Item> LinesOf(const std::string& text, const Entry& list) {
  std::vector<Item> items;
  std::size_t begin = NextLine(text, list.span.begin);
  for (const auto& item : list.value) {
    if ((item.IsMap() || item.IsSequence()) && !IsFlow(item)) return {};
    const std::size_t at = PositionOf(item), line = LineBegin(text, at);
    const std::size_t end = NextLine(text, ValueEnd(text, item, false));
    if (line < begin || NextLine(text, line) != end) return {};
    items.push_back({Meaning(item),
                     text.substr(begin, end - begin),
                     {at - begin, ValueEnd(text, item, false) - begin}});
    begin = end;
  }
  return items;
}

}  // namespace

std::string YamlScalar(const std::string& value) {
  static const std::vector<std::string> kWords = {"true", "false", "yes", "no", "on",
                                                  "off",  "null",  "y",   "n",  "~"};
  const auto safe = [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '.' || c == '/' || c == '-' || c == '+' || c >= 0x80;
  };
  std::string lower = value;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
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

std::string WithItems(const std::string& text, const YamlPath& path,
                      const std::vector<std::string>& items) {
  RequireEditable(text);
  std::string flow;
  for (const std::string& item : items) flow += (flow.empty() ? "" : ", ") + item;
  const YAML::Node wanted = Parsed("[" + flow + "]");
  YAML::Node map = Parsed(text);
  std::optional<Entry> entry;
  for (const std::string& key : path) {
    entry = FindEntry(text, map, key);
    if (!entry) return WithValue(text, path, "[" + flow + "]");
    map.reset(entry->value);
  }
  std::vector<Item> old;
  if (entry->value.IsSequence() && !IsFlow(entry->value)) old = LinesOf(text, *entry);
  if (entry->in_flow || IsFlow(entry->value) || !entry->value.IsSequence())
    return WithValue(text, path, "[" + flow + "]");
  const std::string dash = std::string(entry->indent + 2, ' ') + "- ";
  std::string lines;
  std::size_t next = 0;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::string meaning = Meaning(wanted[i]);
    const auto same = std::find_if(old.begin() + static_cast<long>(next), old.end(),
                                   [&](const Item& item) { return item.meaning == meaning; });
    if (same != old.end()) {
      lines += same->line;
      next = static_cast<std::size_t>(same - old.begin()) + 1;
    } else if (old.size() == items.size() && next <= i) {
      lines += Replaced(old[i].line, old[i].value, items[i]);
      next = i + 1;
    } else {
      lines += dash + items[i] + "\n";
    }
  }
  const std::size_t begin = NextLine(text, entry->span.begin);
  const YAML::Node node = wanted;
  return Checked(Replaced(text, {begin, entry->span.end}, lines), Wanted(text, path, &node));
}

}  // namespace keypose
