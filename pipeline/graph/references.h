// Resolves the references at input ports in pipeline.yaml: `sfm.model`,
// `register.registered@others`, `$photos`, `./a/path`.
#pragma once

#include <string>
#include <unordered_map>

#include "pipeline/graph/graph.h"
#include "pipeline/graph/sources.h"

namespace keypose::pipeline {

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
  std::vector<Flow> FlowsOfSource(const SourceRule& rule, const Setting& reference,
                                  const Step& step) const;
  const PoseRule* PoseOf(const Setting& reference, const Step& step) const;
  void AddWarnings(const StepRule& rule, Step* step) const;
  std::string WhyNone(const InputRule& rule) const;
  bool Exists(const Setting& reference, const Step& step) const;
  Flow Source(const Setting& path) const;
  void CheckKind(const Flow& flow, const PortFlows& port, const Step& step) const;

  const PipelineFile& file_;
  const Graph& graph_;
  Sources sources_;
  std::unordered_map<std::string, int> index_;  ///< of steps, by id
};

}  // namespace keypose::pipeline
