// The graph of steps, with every input, option and result resolved.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pipeline/graph/pipeline_file.h"
#include "pipeline/graph/stage_info.h"

namespace keypose::pipeline {

/// One thing that flows into an input port.
struct Flow {
  enum class Kind {
    kOutput,    ///< of another step
    kSource,    ///< a file or folder of the project
    kTimeline,  ///< a file made from the timeline
    kRun        ///< a folder that describes all other steps
  };
  Kind kind = Kind::kSource;
  int step = -1;               ///< kOutput: index into Graph::steps
  std::string port;            ///< kOutput
  std::filesystem::path path;  ///< kSource: as written in the file, relative to the project
  std::string origin;          ///< for messages: "photos/bent", "sfm/bent.model", "the timeline"
  bool photographs = false;    ///< kSource: the photographs of a pose
  Where where;
};

struct PortFlows {
  std::string port;
  PortKind kind = PortKind::kFile;
  std::vector<Flow> flows;  ///< at least one
};

/// A file or folder of the cache that is published under a name below out/.
struct NamedResult {
  std::string port, inside;    ///< `inside`: one file of a folder port, or empty
  std::filesystem::path path;  ///< relative to out/
  Where where;
};

/// A file or folder among the step's results that is shown at the end of a run.
struct ShownResult {
  std::filesystem::path path;  ///< relative to out/
  std::string label;           ///< for the user: "the animation"
};

struct Step {
  std::string id;           ///< "sfm/rest", "register/bent", "report"
  std::string rule;         ///< "sfm"
  std::string pose;         ///< empty for steps of the animation and the project
  std::string source_pose;  ///< of a pair: the template
  std::filesystem::path program;
  bool is_own_program = false;      ///< of the project, not one of Keypose's stages
  const StageInfo* info = nullptr;  ///< owned by the catalog; shared, since a project of 1,000
                                    ///< poses has 13,000 steps but a dozen stages
  std::vector<PortFlows> inputs;    ///< in the stage's order of ports
  std::map<std::string, std::string> options;  ///< all of them, canonical
  std::vector<NamedResult> results;
  std::vector<ShownResult> shown;
  std::optional<Cost> cost;
  /// warnings about its inputs, each with what to do
  std::vector<std::string> warnings;
  std::vector<int> needs;  ///< indices of the steps whose outputs it reads, ascending
  Where where;
};

struct Graph {
  ProjectKind kind = ProjectKind::kPoses;  ///< kPerformance: `poses` are its shots
  std::string name;                        ///< from the file, else the folder's name
  bool name_given = false;                 ///< a name from the folder must not affect any result
  std::string template_pose;
  /// template first, then in the order of the timeline, then of the file
  std::vector<std::string> poses;
  /// poses in the order of the timeline, with repeats; `poses` without a timeline
  std::vector<std::string> keys;
  std::string timeline_json;  ///< the content of $timeline; empty if the project only gives the
                              ///< order of poses, at 24 frames a second
  std::vector<Step> steps;    ///< each after all steps that it needs

  /// Steps that match STEP or STEP/POSE, ascending.
  /// @throws UsageError  no step matches; names the nearest
  std::vector<int> Find(const std::string& text) const;
};

}  // namespace keypose::pipeline
