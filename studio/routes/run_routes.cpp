#include "studio/routes/run_routes.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/values/errors.h"
#include "pipeline/commands/keypose_commands.h"
#include "pipeline/disk/real_disk.h"
#include "pipeline/disk/real_process.h"
#include "studio/project/changes.h"
#include "studio/project/failure_pictures.h"
#include "studio/project/overview.h"
#include "studio/project/pose_photographs.h"

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

}  // namespace

void RunRoutes::AddTo(RouteTable& table) {
  AddOptions(table);
  AddSteps(table);
  AddRun(table);
}

void RunRoutes::AddOptions(RouteTable& table) {
  table.Get("/api/stages", [this](const Question&) { return Stages(); });
  table.Post("/api/options", [this](const Question& question) {
    const json body = question.Json();
    OptionChange change{body.at("step"), body.at("option"), body.at("pose"),
                        body.at("value").is_null(), ""};
    if (!change.to_default) change.value = body.at("value");
    return JsonAnswer(project_.With([&](Snapshot& now) {
      return json{{"revision", SetOption(now, change, body.at("revision"))}};
    }));
  });
}

void RunRoutes::AddSteps(RouteTable& table) {
  table.Get("/api/explain", [this](const Question& question) {
    const std::string step = question.Need("step");
    return JsonAnswer({{"text", project_.With([&](Snapshot& now) {
                          return pipeline::ExplanationWithCauses(now.plan(), step);
                        })}});
  });
  table.Get("/api/log", [this](const Question& question) {
    const std::string step = question.Need("step");
    return TextAnswer(project_.With([&](Snapshot& now) { return LogText(now, step); }));
  });
  table.Get("/api/failed", [this](const Question& question) {
    const int width = WholeNumber(question.Get("width", "0"), 0, 100000);
    const fs::path file = project_.With([&](Snapshot& now) {
      return FailurePictureFile(now, question.Need("step"), question.Need("picture"));
    });
    return PictureAnswer(PictureFile(project_.PictureFolder(), file, width));
  });
}

void RunRoutes::AddRun(RouteTable& table) {
  table.Post(
      "/api/run",
      [this](const Question& question) {
        const json body = question.Json();
        if (const std::string holder = project_.LockedBy(); !holder.empty())
          throw LockedError("the project is in use by " + holder);
        if (!project_.Exists()) throw UsageError("there is no project in this folder yet");
        project_.run().Start(
            {Steps(body, "from"), Steps(body, "until"), Steps(body, "only"), Steps(body, "force")});
        return JsonAnswer({{"started", true}});
      },
      Changes::kQuietly);
  table.Post(
      "/api/stop",
      [this](const Question&) {
        project_.run().Stop();
        return JsonAnswer({{"stopping", true}});
      },
      Changes::kQuietly);
}

Answer RunRoutes::Stages() {
  std::vector<fs::path> programs;
  project_.With([&](Snapshot& now) {
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

}  // namespace keypose::studio
