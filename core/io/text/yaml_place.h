// A place in a YAML file, and what is said when it cannot be changed.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace keypose {

/// Thrown when a file is written in a way that cannot be changed safely, such as by anchors.
struct YamlEditError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A key for each level of maps: {"options", "dense", "levels"}.
using YamlPath = std::vector<std::string>;

}  // namespace keypose
