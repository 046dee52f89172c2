// Options of a stage: plain structs whose fields name themselves once, for flags, YAML keys, --help
// and --describe.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace keypose {

/// What a person and a validator need to know of one option.
struct OptionDoc {
  std::string help = {};                                  ///< one sentence
  std::string unit = {};                                  ///< "px", "deg", "" for a pure number
  double min = -std::numeric_limits<double>::infinity();  ///< inclusive; for numbers
  double max = std::numeric_limits<double>::infinity();   ///< inclusive; for numbers
  std::vector<std::string> choices = {};                  ///< for strings; empty means any text
};

/// Walks over the fields of an options struct:
///
///     struct MeshOptions {
///       int depth = 9;  ///< octree depth
///       void Describe(OptionVisitor& visit) { visit("depth", depth, {"octree depth", "levels", 4,
///       13}); } std::vector<std::string> Problems() const;   // faults beyond ranges and choices;
///       may be left out
///     };
class OptionVisitor {
 public:
  virtual ~OptionVisitor() = default;
  virtual void operator()(const char* name, bool& value, const OptionDoc& doc) = 0;
  virtual void operator()(const char* name, int& value, const OptionDoc& doc) = 0;
  virtual void operator()(const char* name, double& value, const OptionDoc& doc) = 0;
  virtual void operator()(const char* name, std::string& value, const OptionDoc& doc) = 0;
};

}  // namespace keypose
