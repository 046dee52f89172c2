// What is wanted, what is there, and what would run, with the reason for each. Runs nothing.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/artifact_store.h"
#include "pipeline/content_hasher.h"
#include "pipeline/graph.h"
#include "pipeline/records.h"

namespace keypose::pipeline {

/// Which steps a run is about, as STEP or STEP/POSE; all empty: all steps, none forced.
struct Selection {
  std::vector<std::string> from;   ///< these and all that follows from them; what lies before is
                                   ///< taken as it was last made
  std::vector<std::string> until;  ///< these and all that they need
  std::vector<std::string> only;   ///< just these
  std::vector<std::string> force;  ///< run even if they are up to date
};

struct StepPlan {
  enum class State {
    kWaiting,  ///< for a step that it needs
    kReady,    ///< must run, and can
    kDone,     ///< its artifact is in the cache
    kMissing   ///< not wanted, and never made
  };
  State state = State::kWaiting;
  bool wanted = true, forced = false;
  bool made = false;                 ///< by this run
  Recipe recipe;                     ///< from kReady on
  std::string fingerprint;           ///< from kReady on
  std::optional<Artifact> artifact;  ///< kDone
  std::vector<std::string> reasons;  ///< kReady: why it must run, in plain words
  std::optional<StepRecord> last;
};

/// The project's parts that plan and builder share.
struct Workshop {
  Disk& disk;
  ContentHasher& hasher;
  ArtifactStore& store;
  Records& records;
  std::filesystem::path project;  ///< absolute
  std::filesystem::path state() const { return project / ".keypose"; }
};

class Plan {
 public:
  /// Looks at every step. Keeps references to both.
  /// @throws UsageError  the selection names no step
  /// @throws InputError  a file or folder of the project that a wanted step reads is missing; with
  /// file:line
  Plan(const Graph& graph, Workshop& workshop, const Selection& selection);

  const Graph& graph() const { return graph_; }
  const StepPlan& operator[](int i) const { return steps_[i]; }
  int size() const { return static_cast<int>(steps_.size()); }

  /// Steps that can run now, in order.
  std::vector<int> Ready() const;
  /// The step's artifact is there now; looks again at what waits for it.
  void SetDone(int i, Artifact artifact, bool made);
  /// Why a waiting step cannot be judged yet: the ids of unfinished steps that it needs.
  std::vector<std::string> WaitsFor(int i) const;
  /// What $run is for step `i`: see docs/pipeline.md.
  std::string RunJson(int i) const;
  /// Where the flows of a port come from, absolute. @pre all needed steps are done; kTimeline and
  /// kRun give nothing
  std::filesystem::path SourceOf(const Flow& flow) const;

 private:
  void Select(const Selection& selection);
  void CheckSources() const;
  void Advance();
  void Resolve(int i);
  bool TakeLastMade(int i);
  Recipe MakeRecipe(int i) const;
  Content ContentOf(const Flow& flow, int i) const;
  std::vector<std::string> ReasonsOf(const StepPlan& step) const;
  void CheckMissing() const;

  const Graph& graph_;
  Workshop& workshop_;
  std::vector<StepPlan> steps_;
};

}  // namespace keypose::pipeline
