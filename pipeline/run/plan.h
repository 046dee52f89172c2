// Which steps are wanted, which are done, and which would run, with the reasons. Runs nothing.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/values/size_of.h"
#include "pipeline/cache/artifact_store.h"
#include "pipeline/cache/content_hasher.h"
#include "pipeline/cache/records.h"
#include "pipeline/graph/graph.h"

namespace keypose::pipeline {

/// The steps of a run, as STEP or STEP/POSE. All empty: all steps, none forced.
struct Selection {
  /// these and all that depend on them; earlier steps keep their last results
  std::vector<std::string> from;
  std::vector<std::string> until;  ///< these and all steps that they need
  std::vector<std::string> only;   ///< just these
  std::vector<std::string> force;  ///< run even if they are up to date
};

struct StepPlan {
  enum class State {
    kWaiting,  ///< for a step that it needs
    kReady,    ///< must run, and can run now
    kDone,     ///< its artifact is in the cache
    kMissing   ///< not wanted, and never made
  };
  State state = State::kWaiting;
  bool wanted = true, forced = false;
  bool made = false;                 ///< by this run
  Recipe recipe;                     ///< set from kReady on
  std::string fingerprint;           ///< set from kReady on
  std::optional<Artifact> artifact;  ///< kDone
  std::vector<std::string> reasons;  ///< kReady: why it must run, as text
  std::optional<StepRecord> last;
};

/// The parts of a project that plan and builder share.
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
  /// Determines the state of every step. Keeps references to `graph` and `workshop`.
  /// @throws UsageError  the selection matches no step
  /// @throws InputError  a wanted step reads a file or folder of the project that is missing; with
  /// file:line
  Plan(const Graph& graph, Workshop& workshop, const Selection& selection);

  const Graph& graph() const { return graph_; }
  const StepPlan& operator[](int i) const { return steps_[i]; }
  int size() const { return SizeOf(steps_); }

  /// Steps that can run now, in order.
  std::vector<int> Ready() const;
  /// Sets the step's artifact and updates the steps that wait for it.
  void SetDone(int i, Artifact artifact, bool made);
  /// The ids of the unfinished steps that a waiting step needs.
  std::vector<std::string> WaitsFor(int i) const;
  /// The content of $run for step `i`; see docs/pipeline.md.
  std::string RunJson(int i) const;
  /// The absolute path that a flow comes from; empty for kTimeline and kRun. @pre all needed steps
  /// are done
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
