// A whole project in memory: two poses and six stages that are functions on text. One call runs it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pipeline/run/builder.h"
#include "pipeline/run/plan.h"
#include "pipeline/testing/fake_processes.h"
#include "pipeline/testing/memory_disk.h"

namespace keypose::pipeline {

using Names = std::vector<std::string>;
/// The steps of the project, sorted.
inline const Names kAllSteps = {"blend",      "match/bent", "shape/bent",
                                "shape/rest", "shoot/bent", "shoot/rest",
                                "solve/bent", "solve/rest", "tell"};

/// The default pipeline of the fake house: shoot (folder) -> solve -> shape -> match (pair) ->
/// blend (animation) -> tell (project). `solve` depends only on the number of photographs and their
/// first letters, so other changes do not propagate past it.
extern const char* const kFakePipeline;

class FakeHouse {
 public:
  FakeHouse();
  ~FakeHouse();

  struct Outcome {
    RunResult result;
    std::vector<std::string> ran;  ///< step ids of the processes that were started, sorted
    std::vector<std::string> notes;
    Forecast forecast;
    Ending ending;
  };
  Outcome Run(const Selection& selection = {}, const std::vector<std::string>& set = {},
              int cores = 4);
  /// The plan that `status` would show.
  struct View {
    std::unique_ptr<Graph> graph;
    std::unique_ptr<Plan> plan;
    const StepPlan& Step(const std::string& id) const { return (*plan)[graph->Find(id).front()]; }
    /// All reasons of a step in one text.
    std::string Reasons(const std::string& id) const;
  };
  View Look(const Selection& selection = {}, const std::vector<std::string>& set = {});

  /// Moves the project folder and updates `project`.
  void MoveProject(const std::filesystem::path& to);
  void WriteProject(const std::string& yaml) { disk.Write(project / "pipeline.yaml", yaml); }
  std::string Out(const std::string& name) const { return disk.Read(project / "out" / name); }

  MemoryDisk disk;
  FakeClock clock;
  FakeProcesses processes{disk, clock};
  std::filesystem::path project = "/home/ann/hero";
  std::string default_pipeline = kFakePipeline;

 private:
  struct Parts;
  std::unique_ptr<Parts> Open(const std::vector<std::string>& set);
  std::vector<std::unique_ptr<Parts>> opened_;
  int runs_ = 0;
};

}  // namespace keypose::pipeline
