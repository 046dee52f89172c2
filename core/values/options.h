// Options of a stage: plain structs that name each of their fields once. Flags, YAML keys, --help
// and --describe are derived from that.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace keypose {

/// Description of one option, for people and for checks.
struct OptionDoc {
  std::string help = {};                                  ///< one sentence
  std::string unit = {};                                  ///< "px", "deg", "" for a pure number
  double min = -std::numeric_limits<double>::infinity();  ///< inclusive; for numbers
  double max = std::numeric_limits<double>::infinity();   ///< inclusive; for numbers
  std::vector<std::string> choices = {};                  ///< for strings; empty means any text
};

/// Visits the fields of an options struct:
///
///     struct MeshOptions {
///       int depth = 9;  ///< octree depth
///       void Describe(OptionVisitor& visit) {
///         visit("depth", depth, {"octree depth", "levels", 4, 13});
///       }
///       /// Faults beyond ranges and choices. The function may be left out.
///       std::vector<std::string> Problems() const;
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
