// Everything that determines a step's result, its fingerprint, and the differences between two
// recipes as text.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace keypose::pipeline {

/// The content of a file or folder.
struct Content {
  /// of a file: SHA-256; of a folder: SHA-256 over sorted names and hashes of `files`
  std::string hash;
  std::map<std::string, std::string> files;  ///< of a folder: relative name -> hash
  /// of the timeline, for messages: what is said -> value
  std::map<std::string, std::string> settings = {};
  bool operator==(const Content&) const = default;
};
/// @return content with a hash over `files`
Content FolderContent(std::map<std::string, std::string> files);

struct RecipeInput {
  std::string port;
  /// for messages, not part of the fingerprint: "photos/bent", "sfm/bent.model"
  std::string origin;
  Content content;
};

struct Recipe {
  std::string stage, version;
  std::map<std::string, std::string> tools;    ///< external program -> version
  std::map<std::string, std::string> options;  ///< all, canonical
  std::vector<RecipeInput> inputs;             ///< in order

  /// 64 hexadecimal digits.
  std::string Fingerprint() const;
};

nlohmann::json ToJson(const Recipe& recipe);
/// @throws nlohmann::json::exception  `json` was not written by ToJson
Recipe RecipeFromJson(const nlohmann::json& json);

/// One line per difference, e.g. "option depth: 9 -> 10", "photos/bent/IMG_0007.jpg changed".
/// Empty: same fingerprint.
std::vector<std::string> Differences(const Recipe& before, const Recipe& now);

}  // namespace keypose::pipeline
