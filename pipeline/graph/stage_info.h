// A stage program's description from --describe, and the check of options against it.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/disk/disk.h"

namespace keypose::pipeline {

enum class PortKind { kFile, kFolder, kEither };

struct PortInfo {
  std::string name, kind;  ///< kind is "file", "folder", or for inputs "path" (either)
  std::string file;        ///< outputs: the file name that the runner passes
  bool optional = false, repeatable = false;
  PortKind Kind() const {
    if (kind == "folder") return PortKind::kFolder;
    return kind == "path" ? PortKind::kEither : PortKind::kFile;
  }
};

struct OptionInfo {
  std::string name, type;     ///< type is "bool", "int", "double" or "string"
  std::string default_value;  ///< canonical text
  std::string unit;
  std::optional<double> min, max;
  std::vector<std::string> choices;
};

/// What a measurement of a stage's report means.
struct MeasurementInfo {
  std::string key, label;
  std::string unit;  ///< "share" and "diagonal" are shown in percent
  std::optional<double> good_min, good_max;
};

struct StageInfo {
  std::string stage, version, summary;
  std::string title;  ///< what an artist calls its work; the stage's name where it says none
  std::vector<MeasurementInfo> measurements;  ///< the most important ones, in the order to show
  std::vector<PortInfo> inputs, outputs;
  std::vector<OptionInfo> options;
  std::map<std::string, std::string> tools;  ///< external program -> the version it reports
  /// The stage's program and its tools when --describe ran; missing ones have no stat. Not part of
  /// --describe.
  std::map<std::string, std::optional<FileStat>> programs;
  int cores = 0;  ///< 0: all
  std::int64_t memory_bytes = 0;

  const PortInfo* FindInput(const std::string& name) const;
  const PortInfo* FindOutput(const std::string& name) const;
  const OptionInfo* FindOption(const std::string& name) const;
};

/// @param text     the JSON that `PROGRAM --describe` prints
/// @param program  named in messages
/// @throws ToolError  not the JSON of the stage contract; names the field
StageInfo ParseStageInfo(const std::string& text, const std::string& program);

/// The canonical text of a value: 0.50, .5 and 5e-1 all give "0.5"; yes and on give "true".
/// @throws UsageError  wrong type, out of range, or not among the choices; says what is allowed
std::string CanonicalOption(const OptionInfo& option, const std::string& text);

/// The option of that name. @throws UsageError  there is none; names the nearest one
const OptionInfo& OptionOf(const StageInfo& info, const std::string& name);

/// "; did you mean 'x'? (known: x, y, z)"
std::string Suggestion(const std::string& word, const std::vector<std::string>& known);

}  // namespace keypose::pipeline
