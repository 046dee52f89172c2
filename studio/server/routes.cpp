#include "studio/server/routes.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "core/io/text/files.h"
#include "pipeline/commands/commands.h"
#include "pipeline/cache/project_lock.h"
#include "pipeline/disk/real_disk.h"
#include "pipeline/disk/real_process.h"
#include "studio/project/changes.h"
#include "studio/project/failure_pictures.h"
#include "studio/project/overview.h"
#include "studio/project/photographs.h"
#include "studio/project/timeline.h"
#include "studio/runs/children.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

std::vector<std::string> Steps(const json& body, const char* name) {
  if (!body.contains(name)) return {};
  const std::vector<std::string> steps = body.at(name);
  for (const std::string& step : steps)
    if (step.empty() || step[0] == '-') throw UsageError("a step's name cannot begin with '-'");
  return steps;
}

/// Editors often empty a file before they write it: what cannot be read is read again a moment
/// later.
std::unique_ptr<Snapshot> OpenSnapshot(const fs::path& folder) {
  constexpr int kTries = 3;
  for (int i = 1; i < kTries; ++i) {
    try {
      return std::make_unique<Snapshot>(folder);
    } catch (const Error&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
  return std::make_unique<Snapshot>(folder);
}

}  // namespace

Routes::Routes(fs::path folder) : folder_(std::move(folder)) {
  AddProject();
  AddRuns();
  AddPhotographs();
  AddMeshes();
  AddTextures();
  AddFrames();
  AddFilms();
  AddCameras();
  AddLandmarks();
  AddTimeline();
  AddResults();
  AddShoot();
  AddShot();
  AddArmature();
  AddTakes();
  Follow();
  FollowShoot();
  FollowArmature();
}

Routes::~Routes() {
  watch_.reset();
  shoot_.reset();
  armature_.reset();
  run_.reset();
  hub_.Close();
}

bool Routes::HasProject() const { return fs::is_regular_file(folder_ / "pipeline.yaml"); }

fs::path Routes::PictureFolder() const { return folder_ / ".keypose/studio/pictures"; }

std::string Routes::LockedBy() {
  if (run_->running()) return "";
  return pipeline::LockHolder(folder_ / ".keypose");
}

/// Follows the runs and files of the project, also of one that is made later.
void Routes::Follow() {
  RunControl::Listener listener;
  listener.line = [this](const std::string& line) {
    stale_ = true;
    hub_.Send("run", line);
  };
  listener.ended = [this](int code, const std::string& message) {
    stale_ = true;
    hub_.Send("run_ended", json{{"exit_code", code}, {"message", message}}.dump());
  };
  run_ = std::make_unique<RunControl>(folder_, listener);
  watch_ = std::make_unique<ProjectWatch>(folder_, [this] { Changed(); });
  if (HasProject()) run_->TakeUp();
}

void Routes::Changed() {
  stale_ = true;
  hub_.Send("project", "{}");
}

/// What somebody has asked to change must be seen by the next question, and by the other tabs.
void Routes::Tell(const std::string& path) {
  if (path == "/api/shot/quick") return;  // an answer that changes nothing of the project
  stale_ = true;
  // Photographs come by the hundred; the watch tells of all of them together.
  const bool of_puppet = path.starts_with("/api/armature") && path != "/api/armature/take/use";
  if (path == "/api/photos" || path.starts_with("/api/shoot") || of_puppet) return;
  if (path == "/api/run" || path == "/api/stop") return;
  watch_->Forget();
  hub_.Send("project", "{}");
}

void Routes::Add(const std::string& method, const std::string& path, Handler handler) {
  handlers_[method + " " + path] = std::move(handler);
}

Snapshot& Routes::Now() {
  if (!HasProject()) throw UsageError("there is no project in this folder yet");
  if (stale_.exchange(false)) snapshot_.reset();
  if (!snapshot_) snapshot_ = OpenSnapshot(folder_);
  return *snapshot_;
}

Answer Routes::Handle(const Question& question) {
  try {
    if (question.method == "GET" &&
        (question.path.starts_with("/results/") || question.path.starts_with("/report/")))
      return ResultFile(question);
    const auto handler = handlers_.find(question.method + " " + question.path);
    if (handler == handlers_.end()) return ErrorAnswer(404, "there is nothing at this address");
    Answer answer = handler->second(question);
    if (question.method != "GET") Tell(question.path);
    return answer;
  } catch (const ChangedMeanwhile& error) {
    return ErrorAnswer(409, error.what());
  } catch (const NotFound& error) {
    return ErrorAnswer(404, error.what());
  } catch (const LockedError& error) {
    return ErrorAnswer(409, error.what());
  } catch (const DiskError& error) {
    return ErrorAnswer(500, error.what());
  } catch (const Error& error) {
    return ErrorAnswer(400, error.what());
  } catch (const json::exception& error) {
    return ErrorAnswer(400, "the request is incomplete: " + JsonFault(error));
  } catch (const std::exception& error) {
    return ErrorAnswer(500, fmt::format("a bug in the studio: {}", error.what()));
  }
}

void Routes::AddProject() {
  Add("GET", "/api/project", [this](const Question&) {
    if (!HasProject()) return JsonAnswer(EmptyProjectJson(folder_));
    try {
      return JsonAnswer(With([](Snapshot& now) { return ProjectJson(now); }));
    } catch (const Error& error) {
      return JsonAnswer(BrokenProjectJson(folder_, error.what()));
    }
  });
  Add("POST", "/api/project", [this](const Question& question) {
    const json body = question.Json();
    CreateProject(folder_, body.at("poses"), body.at("template"),
                  body.value("few", std::vector<std::string>{}));
    return JsonAnswer(With([](Snapshot& now) { return ProjectJson(now); }));
  });
  Add("GET", "/api/steps", [this](const Question&) {
    const bool running = run_->running();
    const std::string locked = LockedBy();
    if (!HasProject()) return JsonAnswer(NoStepsJson(false, ""));
    try {
      return JsonAnswer(With([&](Snapshot& now) { return StepsJson(now, running, locked); }));
    } catch (const Error&) {
      return JsonAnswer(NoStepsJson(running, locked));  // /api/project says what is wrong
    }
  });
  Add("POST", "/api/options", [this](const Question& question) {
    const json body = question.Json();
    OptionChange change{body.at("step"), body.at("option"), body.at("pose"),
                        body.at("value").is_null(), ""};
    if (!change.to_default) change.value = body.at("value");
    return JsonAnswer(With([&](Snapshot& now) {
      return json{{"revision", SetOption(now, change, body.at("revision"))}};
    }));
  });
  Add("GET", "/api/stages", [this](const Question&) { return Stages(); });
}

Answer Routes::Stages() {
  std::vector<fs::path> programs;
  With([&](Snapshot& now) {
    for (const pipeline::Step& step : now.graph().steps)
      if (std::find(programs.begin(), programs.end(), step.program) == programs.end())
        programs.push_back(step.program);
    return 0;
  });
  // A program says the same until it is replaced; asking all of them takes seconds.
  const std::lock_guard<std::mutex> lock(described_mutex_);
  std::vector<std::vector<std::string>> commands;
  std::vector<std::string> keys, asked;
  for (const fs::path& program : programs) {
    const auto stat = pipeline::RealDisk().Stat(program);
    keys.push_back(fmt::format("{} {} {}", program.string(), stat ? stat->mtime_ns : 0,
                               stat ? stat->size : 0));
    if (described_.contains(keys.back())) continue;
    asked.push_back(keys.back());
    commands.push_back({program.string(), "--describe"});
  }
  const auto answers = pipeline::RealProcessRunner().Ask(commands);
  for (std::size_t i = 0; i < answers.size(); ++i)
    if (answers[i].exit_code == 0) described_[asked[i]] = StageJson(answers[i].output);
  // Not what programs said that were replaced since, or are used no more.
  json stages = json::array();
  for (const std::string& key : keys)
    if (const auto stage = described_.find(key); stage != described_.end())
      stages.push_back(stage->second);
  return JsonAnswer(stages);
}

void Routes::AddRuns() {
  Add("GET", "/api/explain", [this](const Question& question) {
    const std::string step = question.Need("step");
    return JsonAnswer({{"text", With([&](Snapshot& now) {
                          return pipeline::ExplanationWithCauses(now.plan(), step);
                        })}});
  });
  Add("GET", "/api/log", [this](const Question& question) {
    const std::string step = question.Need("step");
    return TextAnswer(With([&](Snapshot& now) { return LogText(now, step); }));
  });
  Add("GET", "/api/failed", [this](const Question& question) {
    const int width = WholeNumber(question.Get("width", "0"), 0, 100000);
    const fs::path file = With([&](Snapshot& now) {
      return FailurePictureFile(now, question.Need("step"), question.Need("picture"));
    });
    return PictureAnswer(PictureFile(PictureFolder(), file, width));
  });
  Add("POST", "/api/run", [this](const Question& question) {
    const json body = question.Json();
    if (const std::string holder = LockedBy(); !holder.empty())
      throw LockedError("the project is in use by " + holder);
    if (!HasProject()) throw UsageError("there is no project in this folder yet");
    run_->Start(
        {Steps(body, "from"), Steps(body, "until"), Steps(body, "only"), Steps(body, "force")});
    return JsonAnswer({{"started", true}});
  });
  Add("POST", "/api/stop", [this](const Question&) {
    run_->Stop();
    return JsonAnswer({{"stopping", true}});
  });
}

void Routes::AddTimeline() {
  Add("GET", "/api/timeline", [this](const Question&) {
    return JsonAnswer(With([](Snapshot& now) { return TimelineToPage(now); }));
  });
  Add("PUT", "/api/timeline", [this](const Question& question) {
    return JsonAnswer(With([&](Snapshot& now) {
      SaveTimeline(now, question.Json());
      stale_ = true;
      // Within the same turn, so that it is not what another tab has saved meanwhile.
      return TimelineToPage(Now());
    }));
  });
}

void Routes::AddResults() {
  Add("GET", "/api/results", [this](const Question&) {
    return JsonAnswer(With([](Snapshot& now) { return ResultsJson(now); }));
  });
  Add("POST", "/api/reveal", [this](const Question& question) {
    const std::string path = question.Json().at("path");
    if (!path.empty() && !StaysBelow(path)) throw UsageError("that is not below out/");
    const fs::path place = folder_ / "out" / path;
    if (!fs::exists(place) || pipeline::RealDisk().LeadsOutside(place, folder_ / "out"))
      throw UsageError(fmt::format("{} is not there", place.string()));
    const fs::path shown = fs::is_directory(place) ? place : place.parent_path();
    if (access("/usr/bin/xdg-open", X_OK) != 0)
      throw UsageError(
          fmt::format("this desktop cannot be asked to show it; it is {}", shown.string()));
    LetGo({"/usr/bin/xdg-open", shown.string()}, folder_);
    return JsonAnswer({{"shown", true}});
  });
}

Answer Routes::ResultFile(const Question& question) {
  const bool report = question.path.starts_with("/report/");
  const std::string below = question.path.substr(report ? 8 : 9);
  const fs::path out = folder_ / (report ? "out/report" : "out"), file = out / below;
  if (!StaysBelow(below) || !fs::is_regular_file(file) ||
      pipeline::RealDisk().LeadsOutside(file, folder_ / "out"))
    return ErrorAnswer(404, "there is nothing at this address");
  Answer answer{200, TypeOf(file), {}, file, {}};
  if (!report) answer.download = file.filename().string();
  return answer;
}

}  // namespace keypose::studio
