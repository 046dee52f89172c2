// Reads the table `sources` of a pipeline file, and keys that may be words of it.
#pragma once

#include <string>
#include <vector>

#include "pipeline/graph/source_rule.h"
#include "pipeline/graph/yaml_reader.h"

namespace keypose::pipeline {

/// @throws UsageError  a word that means something else already, an unknown field, a line that does
/// not say whose the source is; with file:line
std::vector<SourceRule> ReadSources(const YamlReader& reader, const YAML::Node& node);

/// A key that the reader does not know. A value that is no path is refused later, so that a
/// misspelt key is named first.
GivenSource ReadGiven(const YamlReader& reader, const std::string& word, const YAML::Node& key,
                      const YAML::Node& value);

}  // namespace keypose::pipeline
