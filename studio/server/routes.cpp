#include "studio/server/routes.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "core/errors.h"
#include "core/file_names.h"
#include "core/io/files.h"
#include "core/io/mesh_io.h"
#include "pipeline/commands.h"
#include "pipeline/project_lock.h"
#include "pipeline/real_disk.h"
#include "pipeline/real_process.h"
#include "studio/meshes/frames.h"
#include "studio/meshes/mesh_bytes.h"
#include "studio/project/changes.h"
#include "studio/project/overview.h"
#include "studio/project/photographs.h"
#include "studio/project/picks.h"
#include "studio/project/timeline.h"
#include "studio/runs/children.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kMostCloudPoints = 1'000'000;
constexpr double kSuggestSeconds = 300;

Answer JsonAnswer(const json& value) {
  // A file's name may hold bytes that are no text.
  return {
      200, "application/json", value.dump(-1, ' ', false, json::error_handler_t::replace), {}, {}};
}

Answer ErrorAnswer(int status, const std::string& words) {
  Answer answer = JsonAnswer({{"error", words}});
  answer.status = status;
  return answer;
}

Answer TextAnswer(std::string text) { return {200, "text/plain", std::move(text), {}, {}}; }
Answer BytesAnswer(std::string bytes) {
  return {200, "application/octet-stream", std::move(bytes), {}, {}};
}

std::string TypeOf(const fs::path& file) {
  static const std::map<std::string, std::string> kTypes = {
      {".png", "image/png"},  {".jpg", "image/jpeg"},        {".jpeg", "image/jpeg"},
      {".html", "text/html"}, {".json", "application/json"}, {".mp4", "video/mp4"},
      {".gif", "image/gif"},  {".glb", "model/gltf-binary"}, {".txt", "text/plain"}};
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto found = kTypes.find(extension);
  return found == kTypes.end() ? "application/octet-stream" : found->second;
}

/// A copy or an original opens as what its bytes are; names of photographs may lie.
Answer PictureAnswer(const fs::path& file) {
  const std::string head = pipeline::RealDisk().Stat(file) ? ReadFile(file).substr(0, 4) : "";
  const bool png = head.rfind("\x89PNG", 0) == 0;
  Answer answer{200, png ? "image/png" : "image/jpeg", {}, file, {}};
  return answer;
}

std::vector<std::string> Steps(const json& body, const char* name) {
  if (!body.contains(name)) return {};
  const std::vector<std::string> steps = body.at(name);
  for (const std::string& step : steps)
    if (step.empty() || step[0] == '-') throw UsageError("a step's name cannot begin with '-'");
  return steps;
}

int WholeNumber(const std::string& text, int least, int most) {
  std::size_t end = 0;
  int value = least - 1;
  try {
    value = std::stoi(text, &end);
  } catch (const std::exception&) {
    end = 0;
  }
  if (end != text.size() || value < least || value > most)
    throw UsageError(fmt::format("'{}' must be a whole number from {} to {}", text, least, most));
  return value;
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

const std::string& Question::Need(const std::string& name) const {
  const auto found = query.find(name);
  if (found == query.end()) throw UsageError(fmt::format("the request lacks '{}'", name));
  return found->second;
}

std::string Question::Get(const std::string& name, const std::string& otherwise) const {
  const auto found = query.find(name);
  return found == query.end() ? otherwise : found->second;
}

json Question::Json() const {
  if (!IsShallowJson(body)) throw UsageError("the request is nested too deep");
  const json value = json::parse(body, nullptr, false);
  if (!value.is_object()) throw UsageError("the request is not a JSON object");
  return value;
}

Routes::Routes(fs::path folder) : folder_(std::move(folder)) {
  AddProject();
  AddRuns();
  AddPhotographs();
  AddMeshes();
  AddLandmarks();
  AddTimeline();
  AddResults();
  Follow();
}

Routes::~Routes() {
  watch_.reset();
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
  stale_ = true;
  // Photographs come by the hundred; the watch tells of all of them together.
  if (path == "/api/photos") return;
  watch_->Forget();
  if (path != "/api/run" && path != "/api/stop") hub_.Send("project", "{}");
}

void Routes::Add(const std::string& method, const std::string& path, Handler handler) {
  handlers_[method + " " + path] = std::move(handler);
}

template <class Use>
auto Routes::With(const Use& use) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!HasProject()) throw UsageError("there is no project in this folder yet");
  if (stale_.exchange(false)) snapshot_.reset();
  if (!snapshot_) snapshot_ = OpenSnapshot(folder_);
  return use(*snapshot_);
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
    CreateProject(folder_, body.at("poses"), body.at("template"));
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
  std::vector<std::string> keys;
  for (const fs::path& program : programs) {
    const auto stat = pipeline::RealDisk().Stat(program);
    keys.push_back(fmt::format("{} {} {}", program.string(), stat ? stat->mtime_ns : 0,
                               stat ? stat->size : 0));
    if (described_.contains(keys.back()))
      keys.pop_back();
    else
      commands.push_back({program.string(), "--describe"});
  }
  const auto answers = pipeline::RealProcessRunner().Ask(commands);
  for (std::size_t i = 0; i < answers.size(); ++i)
    if (answers[i].exit_code == 0) described_[keys[i]] = StageJson(answers[i].output);
  json stages = json::array();
  for (const auto& [key, stage] : described_) stages.push_back(stage);
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

void Routes::AddPhotographs() {
  Add("GET", "/api/photos", [this](const Question& question) {
    const std::string pose = question.Need("pose");
    return JsonAnswer(With([&](Snapshot& now) {
      if (!now.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
      return PhotographsJson(now, pose);
    }));
  });
  Add("PUT", "/api/photos", [this](const Question& question) {
    if (run_->running()) throw LockedError("a run is at work; add photographs when it is done");
    With([&](Snapshot& now) {
      AddPhotograph(now, question.Need("pose"), question.Need("name"), question.body);
      return 0;
    });
    return JsonAnswer({{"added", true}});
  });
  Add("GET", "/api/photo", [this](const Question& question) {
    const int width = WholeNumber(question.Get("width", "0"), 0, 100000);
    const fs::path source = With([&](Snapshot& now) {
      return PhotographSource(now, question.Need("pose"), question.Need("name"));
    });
    return PictureAnswer(PictureFile(PictureFolder(), source, width));
  });
  Add("GET", "/api/mask", [this](const Question& question) {
    std::pair<int, int> size;
    const fs::path mask = With([&](Snapshot& now) {
      size = PhotographSize(now, question.Need("pose"), question.Need("name"));
      return MaskFile(now, question.Need("pose"), question.Need("name"),
                      question.Get("stage", "masks"));
    });
    return PictureAnswer(MaskPicture(PictureFolder(), mask, size.first, size.second));
  });
  Add("PUT", "/api/mask", [this](const Question& question) {
    With([&](Snapshot& now) {
      SaveMask(now, question.Need("pose"), question.Need("name"), question.body);
      return 0;
    });
    return JsonAnswer({{"saved", true}});
  });
  Add("GET", "/api/cameras", [this](const Question& question) {
    return JsonAnswer(With([&](Snapshot& now) { return CamerasJson(now, question.Need("pose")); }));
  });
}

void Routes::AddMeshes() {
  const auto mesh_path = [this](const std::string& pose, MeshKind kind) {
    const auto path = With([&](Snapshot& now) { return now.MeshPath(pose, kind); });
    if (!path) throw UsageError(fmt::format("pose '{}' has no {} yet", pose, NameOf(kind)));
    return *path;
  };
  Add("GET", "/api/mesh", [mesh_path](const Question& question) {
    const auto kind = MeshKindNamed(question.Need("what"));
    if (!kind) throw UsageError("a mesh is one of mesh, clean, refined, surface, cloud");
    const fs::path path = mesh_path(question.Need("pose"), *kind);
    if (*kind == MeshKind::kCloud)
      return BytesAnswer(CloudBytes(ReadPointCloud(path), kMostCloudPoints));
    return BytesAnswer(MeshBytes(ReadMesh(path)));
  });
  Add("GET", "/api/texture", [this](const Question& question) {
    const std::string pose = question.Need("pose");
    const auto path = With([&](Snapshot& now) { return now.TexturePath(pose); });
    if (!path) throw UsageError(fmt::format("pose '{}' has no texture yet", pose));
    return PictureAnswer(*path);
  });
  Add("GET", "/api/fit", [this, mesh_path](const Question& question) {
    const std::string pose = question.Need("pose");
    // Before the first registration there is no fit to show, which is no fault.
    if (With([&](Snapshot& now) { return !now.MeshPath(pose, MeshKind::kMesh); }))
      return BytesAnswer("");
    return BytesAnswer(FitBytes(ReadMesh(mesh_path(pose, MeshKind::kMesh)),
                                ReadMesh(mesh_path(pose, MeshKind::kClean))));
  });
  Add("GET", "/api/frames", [this](const Question&) {
    return JsonAnswer(With([](Snapshot& now) { return FramesJson(now); }));
  });
  Add("GET", "/api/frames/positions", [this](const Question&) {
    return BytesAnswer(With([](Snapshot& now) { return FramePositions(now); }));
  });
}

void Routes::AddLandmarks() {
  const auto picks = [this](const Question& question) {
    const std::string pose = question.Need("pose");
    return JsonAnswer(With([&](Snapshot& now) { return PicksJson(now, pose); }));
  };
  Add("GET", "/api/landmarks", picks);
  Add("PUT", "/api/landmarks", [this, picks](const Question& question) {
    With([&](Snapshot& now) {
      SavePicks(now, question.Need("pose"), question.Json());
      return 0;
    });
    return picks(question);
  });
  Add("POST", "/api/landmarks/import", [this, picks](const Question& question) {
    const json body = question.Json();
    With([&](Snapshot& now) {
      ImportPicks(now, question.Need("pose"), body.at("name"), body.at("text"));
      return 0;
    });
    return picks(question);
  });
  Add("GET", "/api/landmarks/export", [this](const Question& question) {
    const std::string pose = question.Need("pose"), format = question.Need("format");
    Answer answer = TextAnswer(With([&](Snapshot& now) { return ExportPicks(now, pose, format); }));
    answer.download = pose + (format == "pp" ? ".pp" : format == "wrap" ? "_wrap.json" : ".json");
    return answer;
  });
  Add("GET", "/api/landmarks/advice", [this](const Question& question) {
    return JsonAnswer(With([&](Snapshot& now) { return AdviceJson(now, question.Need("pose")); }));
  });
  Add("POST", "/api/landmarks/suggest",
      [this](const Question& question) { return Suggest(question); });
  Add("GET", "/api/stiffness", [this](const Question&) {
    return JsonAnswer(With([](Snapshot& now) { return StiffnessJson(now); }));
  });
  Add("PUT", "/api/stiffness", [this](const Question& question) {
    return JsonAnswer(With([&](Snapshot& now) {
      SaveStiffness(now, question.Json());
      return StiffnessJson(now);
    }));
  });
  Add("GET", "/api/regions", [this](const Question&) {
    return JsonAnswer(With([](Snapshot& now) { return RegionsJson(now); }));
  });
  Add("PUT", "/api/regions", [this](const Question& question) {
    return JsonAnswer(With([&](Snapshot& now) {
      SaveRegions(now, question.Json());
      return RegionsJson(now);
    }));
  });
}

Answer Routes::Suggest(const Question& question) {
  const json body = question.Json();
  const std::string pose = body.at("pose");
  const double count = body.at("count");
  if (!(count >= 1 && count <= 100)) throw UsageError("suggest 1 to 100 landmarks");
  const fs::path suggested = folder_ / ".keypose/studio/suggested.json";
  std::vector<std::string> words = {(OwnFolder() / "keypose-landmarks").string(),
                                    "suggest",
                                    "--suggested",
                                    suggested.string(),
                                    "--count",
                                    std::to_string(static_cast<int>(count))};
  With([&](Snapshot& now) {
    const std::string whole = now.graph().template_pose;
    for (const auto& [flag, of] : {std::pair{"--source", whole}, std::pair{"--target", pose}}) {
      const auto path = now.PickedMesh(of);
      if (!path) throw UsageError(fmt::format("pose '{}' has no mesh to pick on yet", of));
      words.insert(words.end(), {flag, path->string()});
    }
    const auto known = [&](const std::string& of) {
      return folder_ / "landmarks" / (of + ".json");
    };
    if (fs::exists(known(whole)) && fs::exists(known(pose)))
      words.insert(words.end(),
                   {"--landmarks", known(whole).string(), "--landmarks", known(pose).string()});
    return 0;
  });
  fs::create_directories(suggested.parent_path());
  std::error_code ignored;
  fs::remove(suggested, ignored);
  const ChildResult result = RunChild(words, folder_, kSuggestSeconds);
  if (result.exit_code != 0) throw InputError(result.output);
  return JsonAnswer(With([&](Snapshot& now) { return SuggestionsJson(now, pose, suggested); }));
}

void Routes::AddTimeline() {
  Add("GET", "/api/timeline", [this](const Question&) {
    return JsonAnswer(With([](Snapshot& now) { return TimelineToPage(now); }));
  });
  Add("PUT", "/api/timeline", [this](const Question& question) {
    With([&](Snapshot& now) {
      SaveTimeline(now, question.Json());
      return 0;
    });
    stale_ = true;
    return JsonAnswer(With([](Snapshot& now) { return TimelineToPage(now); }));
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
    RunChild({"/usr/bin/xdg-open", shown.string()}, folder_, 5);
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
