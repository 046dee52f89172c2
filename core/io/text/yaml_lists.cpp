// Lists of a YAML file: their items, with the comments at them.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/io/text/yaml_edit.h"
#include "core/io/text/yaml_text.inc"

namespace keypose {

using namespace yaml_text;

namespace {

struct Item {
  YAML::Node node;
  std::string lines;       ///< with the comments above it
  Span value;              ///< within `lines`
  std::size_t column = 0;  ///< of the value
};

/// The items of a block list; none if two share a line.
std::vector<Item> ItemsOf(const std::string& text, const Entry& list) {
  std::vector<Item> items;
  std::size_t begin = NextLine(text, list.span.begin);
  for (const auto& node : list.value) {
    const std::size_t at = PositionOf(node), line = LineBegin(text, at);
    const bool block = (node.IsMap() || node.IsSequence()) && !IsFlow(node);
    const std::size_t value_end =
        block ? LineEnd(text, BlockEnd(text, line, IndentOf(text, line), false) - 1)
              : ValueEnd(text, node, false);
    const std::size_t end = NextLine(text, value_end);
    if (line < begin || node.IsNull()) return {};
    items.push_back(
        {node, text.substr(begin, end - begin), {at - begin, value_end - begin}, at - line});
    begin = end;
  }
  return items;
}

/// What an item says, to be compared often.
struct Saying {
  std::string whole;
  std::map<std::string, std::string> fields;  ///< of a map
};

Saying SayingOf(const YAML::Node& node) {
  Saying saying{Meaning(node), {}};
  if (node.IsMap())
    for (const auto& field : node) saying.fields[field.first.Scalar()] = Meaning(field.second);
  return saying;
}

/// How sure it is that one item of a list came from another. A word may have become a map of it:
/// rest -> {pose: rest, at: 0}.
int Likeness(const Saying& before, const Saying& after, bool same_place) {
  constexpr int kEqual = 1000, kShared = 2;
  if (before.whole == after.whole) return kEqual;
  int likeness = same_place ? 1 : 0;
  for (const auto& [name, value] : after.fields) {
    const auto old = before.fields.find(name);
    const bool shared = before.fields.empty() ? value == before.whole
                                              : old != before.fields.end() && old->second == value;
    if (shared) likeness += kShared;
  }
  return likeness;
}

/// For each new item the old one that it came from, or -1; both in order, as alike as can be.
std::vector<int> OriginsOf(const std::vector<Item>& old, const YAML::Node& wanted) {
  std::vector<Saying> before, after;
  for (const Item& item : old) before.push_back(SayingOf(item.node));
  for (const auto& node : wanted) after.push_back(SayingOf(node));
  const std::size_t rows = before.size(), columns = after.size();
  const auto like = [&](std::size_t i, std::size_t j) {
    return Likeness(before[i], after[j], rows == columns && i == j);
  };
  std::vector<std::vector<int>> best(rows + 1, std::vector<int>(columns + 1, 0));
  for (std::size_t i = rows; i-- > 0;)
    for (std::size_t j = columns; j-- > 0;)
      best[i][j] = std::max({best[i + 1][j], best[i][j + 1], best[i + 1][j + 1] + like(i, j)});
  std::vector<int> origins(columns, -1);
  for (std::size_t i = 0, j = 0; i < rows && j < columns;) {
    const int likeness = like(i, j);
    if (likeness > 0 && best[i][j] == best[i + 1][j + 1] + likeness)
      origins[j++] = static_cast<int>(i++);
    else if (best[i][j] == best[i + 1][j])
      ++i;
    else
      ++j;
  }
  return origins;
}

/// Lines of a block map without the indent that all but the first have, or with it again.
std::string Reindented(const std::string& lines, std::size_t column, bool add) {
  std::string result;
  for (std::size_t at = 0; at < lines.size(); at = NextLine(lines, at)) {
    const std::size_t has = std::min(lines.find_first_not_of(' ', at), lines.size()) - at;
    const std::string line = lines.substr(at, NextLine(lines, at) - at);
    if (at > 0 && add && line != "\n") result += std::string(column, ' ');
    result += at > 0 && !add ? line.substr(std::min(has, column)) : line;
  }
  return result;
}

/// A block map with the fields of a flow map; each keeps its line and comment.
std::string WithFields(std::string block, const std::string& flow) {
  const YAML::Node before = Parsed(block), after = Parsed(flow);
  for (const auto& field : before)
    if (!after[field.first.Scalar()]) block = WithoutValue(block, {field.first.Scalar()});
  for (const auto& field : after) {
    const std::string name = field.first.Scalar();
    if (before[name] && Meaning(before[name]) == Meaning(field.second)) continue;
    const Span value = EntryOf(flow, field.first, field.second, true).value_span;
    block = WithValue(block, {name}, flow.substr(value.begin, value.end - value.begin));
  }
  return block;
}

/// The lines of an item with another value.
std::string WithItem(const Item& item, const std::string& value) {
  const std::string old = item.lines.substr(item.value.begin, item.value.end - item.value.begin);
  std::string changed = value;
  if (item.node.IsMap() && !IsFlow(item.node) && Parsed(value).IsMap()) try {
      changed =
          Reindented(WithFields(Reindented(old, item.column, false), value), item.column, true);
      while (!changed.empty() && changed.back() == '\n') changed.pop_back();
    } catch (const YamlEditError&) {
      changed = value;
    }
  return Replaced(item.lines, item.value, changed);
}

/// What stands before each item, such as "    - ".
std::string DashOf(const std::vector<Item>& items, const Entry& list) {
  if (items.empty()) return std::string(list.indent + 2, ' ') + "- ";
  const std::size_t line = LineBegin(items[0].lines, items[0].value.begin);
  return items[0].lines.substr(line, items[0].value.begin - line);
}

}  // namespace

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
  if (entry->in_flow || IsFlow(entry->value) || !entry->value.IsSequence())
    return WithValue(text, path, "[" + flow + "]");
  const std::vector<Item> old = ItemsOf(text, *entry);
  const std::vector<int> origins = OriginsOf(old, wanted);
  const std::string dash = DashOf(old, *entry);
  std::string lines;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (origins[i] < 0) {
      lines += dash + items[i] + "\n";
      continue;
    }
    const Item& item = old[static_cast<std::size_t>(origins[i])];
    lines += Meaning(item.node) == Meaning(wanted[i]) ? item.lines : WithItem(item, items[i]);
    if (lines.back() != '\n') lines += '\n';
  }
  const std::size_t begin = NextLine(text, entry->span.begin);
  const YAML::Node node = wanted;
  return Checked(Replaced(text, {begin, entry->span.end}, lines), Wanted(text, path, &node));
}

std::string WithListUnder(const std::string& text, const YamlPath& path, const std::string& key) {
  RequireEditable(text);
  YAML::Node map = Parsed(text);
  std::optional<Entry> entry;
  for (const std::string& name : path) {
    entry = FindEntry(text, map, name);
    if (!entry || entry->in_flow)
      throw YamlEditError("its form is unusual; change it in an editor");
    map.reset(entry->value);
  }
  if (!entry->value.IsSequence()) throw YamlEditError(fmt::format("'{}' is no list", path.back()));
  YAML::Node wanted(YAML::NodeType::Map);
  wanted[key] = entry->value;
  const std::string indent(entry->indent + 2, ' '), head = indent + YamlScalar(key) + ":\n";
  const std::size_t colon = AfterColon(text, entry->key);
  std::string lines;
  std::size_t end = entry->value_span.end;
  if (IsFlow(entry->value)) {
    for (const auto& item : entry->value) {
      const std::size_t at = PositionOf(item);
      lines += indent + "  - " + text.substr(at, ValueEnd(text, item, true) - at) + "\n";
    }
    const std::string rest = text.substr(end, LineEnd(text, end) - end);
    end = NextLine(text, end);
    return Checked(Replaced(text, {colon, end}, rest + "\n" + head + lines),
                   Wanted(text, path, &wanted));
  }
  const std::size_t first = NextLine(text, colon);
  for (std::size_t at = first; at < end; at = NextLine(text, at))
    lines += (text[at] == '\n' ? "" : "  ") + text.substr(at, NextLine(text, at) - at);
  return Checked(Replaced(text, {first, end}, head + lines), Wanted(text, path, &wanted));
}

}  // namespace keypose
