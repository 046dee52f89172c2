#include "studio/routes/landmarks_routes.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>

#include "core/values/errors.h"
#include "pipeline/run/opened_project.h"
#include "studio/project/page_timeline.h"
#include "studio/project/photo_picks.h"
#include "studio/project/picks.h"
#include "studio/runs/children.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kSuggestSeconds = 300;

/// A file of one question, which is gone when that is answered: two tabs may ask at once.
class OwnFile {
 public:
  explicit OwnFile(const fs::path& folder) {
    fs::create_directories(folder);
    std::string name = (folder / "suggested_XXXXXX.json").string();
    const int file = mkstemps(name.data(), 5);
    if (file < 0) throw DiskError("cannot write a file in " + folder.string());
    close(file);
    path = name;
  }
  ~OwnFile() {
    std::error_code ignored;
    fs::remove(path, ignored);
  }
  OwnFile(const OwnFile&) = delete;
  OwnFile& operator=(const OwnFile&) = delete;

  fs::path path;
};

}  // namespace

void LandmarksRoutes::AddTo(RouteTable& table) {
  AddPicks(table);
  AddFits(table);
  AddPaint(table);
}

void LandmarksRoutes::AddPicks(RouteTable& table) {
  const auto picks = [](Snapshot& now, const std::string& pose) {
    return now.IsFitted(pose) ? PhotoPicksJson(now, pose) : PicksJson(now, pose);
  };
  table.Get("/api/landmarks", [this, picks](const Question& question) {
    const std::string pose = question.Need("pose");
    return JsonAnswer(project_.With([&](Snapshot& now) { return picks(now, pose); }));
  });
  // The answer is what was saved, not what another tab has saved meanwhile.
  table.Put("/api/landmarks", [this, picks](const Question& question) {
    const std::string pose = question.Need("pose");
    return JsonAnswer(project_.With([&](Snapshot& now) {
      (now.IsFitted(pose) ? SavePhotoPicks : SavePicks)(now, pose, question.Json());
      return picks(now, pose);
    }));
  });
  table.Post("/api/landmarks/import", [this, picks](const Question& question) {
    const std::string pose = question.Need("pose");
    const json body = question.Json();
    return JsonAnswer(project_.With([&](Snapshot& now) {
      ImportPicks(now, pose, body.at("name"), body.at("text"));
      return picks(now, pose);
    }));
  });
  table.Get("/api/landmarks/export", [this](const Question& question) {
    const std::string pose = question.Need("pose"), format = question.Need("format");
    Answer answer =
        TextAnswer(project_.With([&](Snapshot& now) { return ExportPicks(now, pose, format); }));
    const char* ending = format == "wrap" ? "_wrap.json" : ".json";
    answer.download = pose + (format == "pp" ? ".pp" : ending);
    return answer;
  });
}

void LandmarksRoutes::AddFits(RouteTable& table) {
  table.Get("/api/landmarks/advice", [this](const Question& question) {
    return JsonAnswer(
        project_.With([&](Snapshot& now) { return AdviceJson(now, question.Need("pose")); }));
  });
  table.Get("/api/landmarks/fit", [this](const Question& question) {
    return JsonAnswer(
        project_.With([&](Snapshot& now) { return PairFitJson(now, question.Need("pose")); }));
  });
  table.Get("/api/landmarks/photographs", [this](const Question& question) {
    return JsonAnswer(
        project_.With([&](Snapshot& now) { return PhotoFitJson(now, question.Need("pose")); }));
  });
  table.Post("/api/landmarks/suggest",
             [this](const Question& question) { return Suggest(question); });
}

void LandmarksRoutes::AddPaint(RouteTable& table) {
  table.Get("/api/stiffness", [this](const Question&) {
    return JsonAnswer(project_.With([](Snapshot& now) { return StiffnessJson(now); }));
  });
  table.Put("/api/stiffness", [this](const Question& question) {
    return JsonAnswer(project_.With([&](Snapshot& now) {
      SaveStiffness(now, question.Json());
      return StiffnessJson(now);
    }));
  });
  table.Get("/api/regions", [this](const Question&) {
    return JsonAnswer(project_.With([](Snapshot& now) { return RegionsJson(now); }));
  });
  table.Put("/api/regions", [this](const Question& question) {
    return JsonAnswer(project_.With([&](Snapshot& now) {
      const json body = question.Json();
      SaveRegions(now, body);
      FollowPaintedRegions(now, body.at("regions"));
      return RegionsJson(now);
    }));
  });
}

Answer LandmarksRoutes::Suggest(const Question& question) {
  const json body = question.Json();
  const std::string pose = body.at("pose");
  const double count = body.at("count");
  if (!(count >= 1 && count <= 100)) throw UsageError("suggest 1 to 100 landmarks");
  const OwnFile suggested(project_.folder() / ".keypose/studio");
  std::vector<std::string> words = {(pipeline::ProgramFolder() / "keypose-landmarks").string(),
                                    "suggest",
                                    "--suggested",
                                    suggested.path.string(),
                                    "--count",
                                    std::to_string(static_cast<int>(count))};
  project_.With([&](Snapshot& now) {
    const std::string whole = now.graph().template_pose;
    for (const auto& [flag, of] : {std::pair{"--source", whole}, std::pair{"--target", pose}}) {
      const auto path = now.PickedMesh(of);
      if (!path) throw UsageError(fmt::format("pose '{}' has no mesh to pick on yet", of));
      words.insert(words.end(), {flag, path->string()});
    }
    const fs::path known = ExistingPicks(now, whole), there = ExistingPicks(now, pose);
    if (!known.empty() && !there.empty())
      words.insert(words.end(), {"--landmarks", known.string(), "--landmarks", there.string()});
    return 0;
  });
  const ChildResult result = RunChild(words, project_.folder(), kSuggestSeconds);
  if (result.exit_code != 0) throw InputError(result.output);
  return JsonAnswer(
      project_.With([&](Snapshot& now) { return SuggestionsJson(now, pose, suggested.path); }));
}

}  // namespace keypose::studio
