// Resolves the references at input ports in pipeline.yaml: `sfm.model`,
// `register.registered@others`, `$photos`, `./a/path`.
#pragma once

#include <optional>
#include <string>
#include <unordered_map>

#include "pipeline/graph/graph.h"

namespace keypose::pipeline {

/// The folder of a pose's photographs, as written in pipeline.yaml.
std::string PhotographsOf(const PoseRule& pose);

/// A word that a whole project has, such as `$scan`, as a path: named in the file, or where it lies
/// by itself (`marks.json`, `regions.json`, `stiffness.json`). Nothing when the project has none.
/// @param word  without the $
std::optional<Setting> ProjectPath(const PipelineFile& file, const Disk& disk,
                                   const std::filesystem::path& project, const std::string& word);
/// The folder of a shot's films, as written in pipeline.yaml.
std::string VideoOf(const PoseRule& shot);
/// Whether there is a shot of that name, and no folder `masks` beside its films.
bool IsUnmasked(const PipelineFile& file, const Disk& disk, const std::filesystem::path& project,
                const std::string& shot);

class References {
 public:
  /// @param graph  has all step instances, not yet connected; kept by reference
  References(const PipelineFile& file, const Graph& graph, std::filesystem::path project,
             const Disk& disk);

  /// Fills `inputs` and `needs` of `step`, the instance `index` of `rule`.
  /// @throws UsageError  a port, step, output or $word does not exist, a file is given where a
  /// folder is needed, or a required port is empty
  void Connect(const StepRule& rule, int index, Step* step) const;

 private:
  std::vector<Flow> FlowsOf(const InputRule& rule, const Step& step) const;
  std::vector<Flow> Resolve(const Setting& reference, const Step& step) const;
  std::vector<Flow> ResolveWord(const Setting& reference, const Step& step) const;
  std::vector<Flow> ResolveOutput(const Setting& reference, const Step& step) const;
  std::vector<std::string> SelectedPoses(const Setting& reference, const std::string& selector,
                                         const StepRule& rule, const Step& step) const;
  const std::vector<Setting>& ReferencesFor(const InputRule& rule,
                                            const std::string& pose_name) const;
  std::vector<std::string> WithStep(const std::string& step, std::vector<std::string> poses) const;
  std::string WhyNoStep(const StepRule& rule, const std::string& pose_name) const;
  std::vector<Flow> ShotWord(const Setting& reference, const PoseRule& shot) const;
  bool Exists(const Setting& reference, const Step& step) const;
  std::vector<Flow> Landmarks(const Setting& reference, const Step& step) const;
  Flow Source(const Setting& path) const;
  std::vector<std::string> LandmarkWarnings(const Step& step) const;
  std::vector<std::string> PosesOfPair(const Step& step) const;
  std::string StrayLandmarks() const;
  std::optional<Setting> LandmarkFile(const std::string& pose_name) const;
  void CheckKind(const Flow& flow, const PortFlows& port, const Step& step) const;

  const PipelineFile& file_;
  const Graph& graph_;
  std::filesystem::path project_;
  const Disk& disk_;
  std::unordered_map<std::string, int> index_;  ///< of steps, by id
};

}  // namespace keypose::pipeline
