// Where values stand in the text of a YAML file: for programs that change one and keep every other
// byte (core/io/yaml_edit.h). Positions are bytes.
#pragma once

#include <yaml-cpp/yaml.h>

#include <optional>
#include <string>

#include "core/io/yaml_edit.h"

namespace keypose::yaml_text {

/// From the first byte to the one after the last.
struct Span {
  std::size_t begin = 0, end = 0;
};

/// One entry of a map.
struct Entry {
  YAML::Node key, value;
  Span span;        ///< key and value; in block style, whole lines
  Span value_span;  ///< the value alone; empty after the colon if there is none
  std::size_t indent = 0;
  bool in_flow = false;
};

/// @throws YamlEditError  it is not YAML
YAML::Node Parsed(const std::string& text);
/// @throws YamlEditError  it is written in a way that is not changed here: aliases, tabs, documents
void RequireEditable(const std::string& text);

std::size_t LineBegin(const std::string& text, std::size_t at);
std::size_t LineEnd(const std::string& text, std::size_t at);
std::size_t NextLine(const std::string& text, std::size_t at);
std::size_t IndentOf(const std::string& text, std::size_t line);

bool IsFlow(const YAML::Node& node);
std::size_t PositionOf(const YAML::Node& node);
/// The end of [..] or {..} that begins at `at`.
std::size_t BracketEnd(const std::string& text, std::size_t at);
/// The end of a value that is no block.
std::size_t ValueEnd(const std::string& text, const YAML::Node& value, bool in_flow);
/// The first line after a block whose first line has this indent.
std::size_t BlockEnd(const std::string& text, std::size_t line, std::size_t indent,
                     bool dashes_belong);
std::size_t AfterColon(const std::string& text, const YAML::Node& key);
Entry EntryOf(const std::string& text, const YAML::Node& key, const YAML::Node& value,
              bool in_flow);
std::optional<Entry> FindEntry(const std::string& text, const YAML::Node& map,
                               const std::string& name);

std::string Replaced(const std::string& text, const Span& span, const std::string& with);
/// As text without style, to compare what two values say.
std::string Meaning(const YAML::Node& node);
/// The parsed file changed in the same way, to check the text against; null takes the value out.
YAML::Node Wanted(const std::string& text, const YamlPath& path, const YAML::Node* value);
/// @throws YamlEditError  the edited text does not say what is wanted
std::string Checked(std::string edited, const YAML::Node& wanted);

}  // namespace keypose::yaml_text
