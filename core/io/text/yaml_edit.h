// Changes single values of a YAML file and keeps every other byte: comments, order, quotes.
#pragma once

#include <string>
#include <vector>

#include "core/io/text/yaml_place.h"

namespace keypose {

/// `text` with the value at `path`. Missing maps on the way are made.
/// @param value  YAML in flow style: a scalar as YamlScalar writes it, [..] or {..}
/// @throws YamlEditError  `text` is not YAML, something on the way is no map, or the result would
/// not be as wanted
std::string WithValue(const std::string& text, const YamlPath& path, const std::string& value);

/// `text` without the value at `path`, and without the maps that are empty then. The same text if
/// there is none.
/// @throws YamlEditError  as above
std::string WithoutValue(const std::string& text, const YamlPath& path);

/// `text` with a list at `path`, an item a line. Items that stay, or of which only some fields
/// change, keep their lines and comments.
/// @param items  YAML in flow style
/// @throws YamlEditError  as above
std::string WithItems(const std::string& text, const YamlPath& path,
                      const std::vector<std::string>& items);

/// `text` with the list at `path` under `key` of a map, which takes the list's place: [a, b]
/// becomes {key: [a, b]}, an item a line. Its comments stay.
/// @throws YamlEditError  as above, or there is no list
std::string WithListUnder(const std::string& text, const YamlPath& path, const std::string& key);

/// A text as a scalar, quoted where YAML would read it as something else.
std::string YamlScalar(const std::string& value);

}  // namespace keypose
