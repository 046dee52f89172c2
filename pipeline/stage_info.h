// What a stage program says of itself with --describe, and the checking of options against it.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/disk.h"

namespace keypose::pipeline {

enum class PortKind { kFile, kFolder, kEither };

struct PortInfo {
  std::string name, kind;  ///< kind is "file", "folder", or of an input "path": either
  std::string file;        ///< outputs: the name that the runner gives it
  bool optional = false, repeatable = false;
  PortKind Kind() const {
    return kind == "folder" ? PortKind::kFolder
           : kind == "path" ? PortKind::kEither
                            : PortKind::kFile;
  }
};

struct OptionInfo {
  std::string name, type;     ///< type is "bool", "int", "double" or "string"
  std::string default_value;  ///< canonical text
  std::string unit;
  std::optional<double> min, max;
  std::vector<std::string> choices;
};

struct StageInfo {
  std::string stage, version, summary;
  std::vector<PortInfo> inputs, outputs;
  std::vector<OptionInfo> options;
  std::map<std::string, std::string> tools;  ///< external programs and the versions they report
  /// The stage's own program and its tools as they were when they were asked; those that are
  /// missing have no stat. Not part of --describe.
  std::map<std::string, std::optional<FileStat>> programs;
  int cores = 0;  ///< 0: all there are
  std::int64_t memory_bytes = 0;

  const PortInfo* FindInput(const std::string& name) const;
  const PortInfo* FindOutput(const std::string& name) const;
  const OptionInfo* FindOption(const std::string& name) const;
};

/// @param text     JSON as `PROGRAM --describe` prints it
/// @param program  named in messages
/// @throws ToolError  not the JSON of the stage contract; says which field
StageInfo ParseStageInfo(const std::string& text, const std::string& program);

/// The one text that stands for a value: 0.50, .5 and 5e-1 are all "0.5"; yes and on are "true".
/// @throws UsageError  wrong type, out of range, not among the choices; says what is allowed
std::string CanonicalOption(const OptionInfo& option, const std::string& text);

/// The option, or @throws UsageError naming the nearest one that the stage has.
const OptionInfo& OptionOf(const StageInfo& info, const std::string& name);

/// "; did you mean 'x'? (known: x, y, z)"
std::string Suggestion(const std::string& word, const std::vector<std::string>& known);

}  // namespace keypose::pipeline
