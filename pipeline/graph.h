// The graph of steps: what runs on what, with every input, option and result resolved.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pipeline/pipeline_file.h"
#include "pipeline/stage_info.h"

namespace keypose::pipeline {

/// One thing that flows into an input port.
struct Flow {
  enum class Kind {
    kOutput,    ///< of another step
    kSource,    ///< a file or folder of the project
    kTimeline,  ///< a file made from the timeline
    kRun        ///< a folder that tells of all other steps
  };
  Kind kind = Kind::kSource;
  int step = -1;               ///< kOutput: index into Graph::steps
  std::string port;            ///< kOutput
  std::filesystem::path path;  ///< kSource: as the file has it, relative to the project
  std::string origin;          ///< for people: "photos/bent", "sfm/bent.model", "the timeline"
  bool photographs = false;    ///< kSource: the photographs of a pose
  Where where;
};

struct PortFlows {
  std::string port;
  PortKind kind = PortKind::kFile;
  std::vector<Flow> flows;  ///< at least one
};

/// A file or folder of the cache that gets a name below out/.
struct NamedResult {
  std::string port, inside;    ///< `inside`: one file of a folder port, or empty
  std::filesystem::path path;  ///< relative to out/
  Where where;
};

/// What a run's end tells of: a file or folder among the step's results.
struct ShownResult {
  std::filesystem::path path;  ///< relative to out/
  std::string label;           ///< for people: "the animation"
};

struct Step {
  std::string id;           ///< "sfm/rest", "register/bent", "report"
  std::string rule;         ///< "sfm"
  std::string pose;         ///< empty for steps of the animation and the project
  std::string source_pose;  ///< of a pair: the template
  std::filesystem::path program;
  const StageInfo* info = nullptr;  ///< the catalog's: a project of a thousand poses has thirteen
                                    ///< thousand steps, and a dozen stages
  std::vector<PortFlows> inputs;    ///< in the stage's order of ports
  std::map<std::string, std::string> options;  ///< all of them, canonical
  std::vector<NamedResult> results;
  std::vector<ShownResult> shown;
  std::optional<Cost> cost;
  /// of its inputs: what a person should know before it runs, with the cure
  std::vector<std::string> warnings;
  std::vector<int> needs;  ///< indices of the steps it takes from, ascending
  Where where;
};

struct Graph {
  std::string name;         ///< the file's, else the folder's
  bool name_given = false;  ///< by the file; a folder's name decides over no result
  std::string template_pose;
  /// template first, then in the order of the timeline, then of the file
  std::vector<std::string> poses;
  /// poses as the timeline has them, repeats included; `poses` without a timeline
  std::vector<std::string> keys;
  std::string timeline_json;  ///< what $timeline holds; empty when the timeline says no more than
                              ///< the order of poses
  std::vector<Step> steps;    ///< each after all that it needs

  /// Steps that a person means by STEP or STEP/POSE, ascending.
  /// @throws UsageError  none, with the nearest
  std::vector<int> Find(const std::string& text) const;
};

}  // namespace keypose::pipeline
