#include "studio/server/door.h"

#include <fmt/format.h>

#include <cstdlib>
#include <ctime>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "pipeline/disk/project_paths.h"
#include "studio/project/known_projects.h"
#include "studio/project/not_found.h"
#include "studio/project/pasted_path.h"
#include "studio/project/project_card.h"
#include "studio/runs/children.h"
#include "studio/runs/run_control.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

double Now_s() { return static_cast<double>(std::time(nullptr)); }

json ExampleJson(const ExampleState& state) {
  if (state.kind.empty()) return nullptr;
  return {{"kind", state.kind},       {"folder", state.folder.string()},
          {"at_work", state.at_work}, {"share", state.share},
          {"words", state.words},     {"error", state.error}};
}

/// The board that is put below a figure, to print.
Answer PrintedBoard(const fs::path& programs) {
  constexpr double kPatience_s = 60;
  std::string folder = (fs::temp_directory_path() / "keypose_board_XXXXXX").string();
  if (!mkdtemp(folder.data())) throw DiskError("there is no room for a file in " + folder);
  const fs::path file = fs::path(folder) / "board.pdf";
  const ChildResult printed =
      RunChild({(programs / "keypose-capture").string(), "--print-board", file.string()}, folder,
               kPatience_s);
  std::error_code ignored;
  Answer answer;
  if (fs::exists(file, ignored))
    answer = {200, "application/pdf", ReadFile(file), {}, "keypose_board.pdf"};
  fs::remove_all(folder, ignored);
  if (answer.bytes.empty()) throw DiskError(ErrorIn(printed.output, printed.exit_code));
  return answer;
}

}  // namespace

Door::Door(DoorOptions options)
    : options_(std::move(options)),
      examples_(options_.programs,
                [this](const fs::path& folder, bool runs) { TakeExample(folder, runs); }) {}

void Door::TakeExample(const fs::path& folder, bool runs) {
  {
    const std::lock_guard<std::mutex> lock(list_mutex_);
    Remember(options_.state, folder, Now_s());
  }
  // It goes on without this studio, and whoever opens the project sees it.
  if (runs) RunControl(folder, {[](const auto&) {}, [](int, const auto&) {}}).Start({});
}

void Door::Open(const fs::path& folder) {
  if (folder == Folder()) return;
  auto opened = std::make_shared<Routes>(folder);
  const std::lock_guard<std::mutex> lock(mutex_);
  // The last tab that is still answered lets the earlier one go.
  if (routes_) routes_->hub().Close();
  routes_.swap(opened);
  folder_ = folder;
  remembered_ = false;
}

std::shared_ptr<Routes> Door::Now() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return routes_;
}

fs::path Door::Folder() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return folder_;
}

std::string Door::Mark() const {
  const std::string folder = Folder().string();
  return folder.empty() ? "" : fmt::format("{:016x}", std::hash<std::string>{}(folder));
}

void Door::RememberIt() {
  const fs::path now = Folder();
  if (now.empty() || remembered_ || !IsProject(now)) return;
  remembered_ = true;
  const std::lock_guard<std::mutex> lock(list_mutex_);
  Remember(options_.state, now, Now_s());
}

Answer Door::Handle(const Question& question) {
  return Answered([&] { return HandleOrThrow(question); });
}

Answer Door::HandleOrThrow(const Question& question) {
  if (question.method == "GET") return Look(question);
  const std::string what = question.path.substr(std::string("/api/door").size());
  const auto text = [body = question.Json()](const char* name) {
    return body.at(name).get<std::string>();
  };
  if (question.method != "POST") return ErrorAnswer(404, "there is nothing at this address");
  if (what == "/address") return JsonAnswer({{"address", options_.new_address()}});
  if (what == "/open") {
    Open(FolderToOpen(pipeline::WithHome(PastedPath(text("folder")))));
  } else if (what == "/new") {
    Open(fs::canonical(NewProjectFolder(options_.home, text("name"))));
  } else if (what == "/forget") {
    const std::lock_guard<std::mutex> lock(list_mutex_);
    ForgetProject(options_.state, text("folder"));
  } else if (what == "/example") {
    const fs::path base = fs::path(pipeline::WithHome(PastedPath(text("base")))).lexically_normal();
    if (!base.is_absolute())
      throw UsageError(fmt::format("'{}' is no whole path: it begins with / or ~/", text("base")));
    examples_.Start(text("kind"), base.has_filename() ? base : base.parent_path());
  } else if (what == "/example/stop") {
    examples_.Stop();
  } else if (what == "/end") {
    options_.end();
  } else {
    return ErrorAnswer(404, "there is nothing at this address");
  }
  return JsonAnswer(StateJson());
}

/// Only of projects in the list: no other folder is looked into.
Answer Door::Look(const Question& question) {
  if (question.path == "/api/door") return JsonAnswer(StateJson());
  if (question.path == "/api/door/board") return PrintedBoard(options_.programs);
  const bool card = question.path == "/api/door/card";
  if (!card && question.path != "/api/door/picture")
    return ErrorAnswer(404, "there is nothing at this address");
  const fs::path folder = question.Need("folder");
  for (const KnownProject& one : KnownProjects(options_.state))
    if (one.folder == folder && one.there)
      return card ? JsonAnswer(ProjectCardJson(folder)) : PictureAnswer(ProjectPicture(folder));
  throw NotFound("no such project is known");
}

json Door::StateJson() const {
  json projects = json::array(), examples = json::array();
  for (const KnownProject& one : KnownProjects(options_.state))
    projects.push_back({{"folder", one.folder.string()},
                        {"name", one.folder.filename().string()},
                        {"opened", one.opened},
                        {"there", one.there}});
  for (const std::string& kind : ExampleKinds()) examples.push_back(kind);
  return {{"open", Folder().string()},
          {"home", options_.home.string()},
          {"examples", examples},
          {"example_base", (options_.home / "examples").string()},
          {"making", ExampleJson(examples_.State())},
          {"projects", projects}};
}

}  // namespace keypose::studio
