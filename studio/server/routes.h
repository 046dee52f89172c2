// What the server answers: one function for each request of docs/studio-api.md.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "studio/project/snapshot.h"
#include "studio/runs/armature_control.h"
#include "studio/runs/run_control.h"
#include "studio/runs/shoot_control.h"
#include "studio/runs/take_desk.h"
#include "studio/runs/warm_program.h"
#include "studio/server/answers.h"
#include "studio/server/event_hub.h"
#include "studio/server/project_watch.h"

namespace keypose::studio {

class Routes {
 public:
  explicit Routes(std::filesystem::path folder);
  ~Routes();

  /// Never throws: faults are answers with {"error": words}.
  Answer Handle(const Question& question);
  EventHub& hub() { return hub_; }

 private:
  using Handler = std::function<Answer(const Question&)>;
  void AddProject();
  void AddRuns();
  void AddPhotographs();
  void AddMasks();
  void AddFigure();
  void AddFilms();
  void AddCameras();
  void AddMeshes();
  void AddTextures();
  void AddFrames();
  void AddLandmarks();
  void AddPaint();
  void AddTimeline();
  void AddResults();
  void AddShoot();
  void AddShootPictures();
  void AddShot();
  void AddArmature();
  void AddArmatureViews();
  void AddTakes();
  void AddTakeUses();
  void Add(const std::string& method, const std::string& path, Handler handler);
  /// Calls `use` with the project as it is now; one caller at a time.
  template <class Use>
  auto With(const Use& use) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return use(Now());
  }
  /// @throws UsageError  there is no project yet
  Snapshot& Now();
  Answer Stages();
  Answer Calibrate(const Question& question);
  Answer Suggest(const Question& question);
  Answer ResultFile(const Question& question);
  void Changed();
  void Tell(const std::string& path);
  void Follow();
  void FollowShoot();
  void FollowArmature();
  bool HasProject() const;
  std::string LockedBy();
  std::filesystem::path PictureFolder() const;

  const std::filesystem::path folder_;
  std::map<std::string, Handler> handlers_;  ///< by "GET /api/project"
  EventHub hub_;
  std::mutex mutex_;
  std::unique_ptr<Snapshot> snapshot_;  ///< null: read again
  std::atomic<bool> stale_ = true;
  std::mutex described_mutex_;
  std::map<std::string, nlohmann::json> described_;  ///< stages, by program and its stamp
  std::unique_ptr<RunControl> run_;
  std::unique_ptr<WarmProgram> locate_;
  std::unique_ptr<ShootControl> shoot_;
  std::unique_ptr<ArmatureControl> armature_;
  std::unique_ptr<TakeDesk> takes_;
  std::unique_ptr<ProjectWatch> watch_;
};

}  // namespace keypose::studio
