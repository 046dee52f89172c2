#include "core/io/yaml_text.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

namespace keypose::yaml_text {
namespace {

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

std::size_t PlainEnd(const std::string& text, std::size_t at, bool in_flow) {
  std::size_t end = at;
  for (; at < LineEnd(text, at) && at < text.size(); ++at) {
    if (BeginsComment(text, at)) break;
    if (in_flow && std::string(",]}").find(text[at]) != std::string::npos) break;
    if (text[at] != ' ' && text[at] != '\r') end = at + 1;
  }
  return end;
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

}  // namespace

YAML::Node Parsed(const std::string& text) {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw YamlEditError(fmt::format("it is not YAML: {}", error.what()));
  }
}

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

bool IsFlow(const YAML::Node& node) { return node.Style() == YAML::EmitterStyle::Flow; }
std::size_t PositionOf(const YAML::Node& node) { return static_cast<std::size_t>(node.Mark().pos); }

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

std::string Replaced(const std::string& text, const Span& span, const std::string& with) {
  return text.substr(0, span.begin) + with + text.substr(span.end);
}

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

}  // namespace keypose::yaml_text
