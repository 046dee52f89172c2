// Landmarks, their suggestions, and what is painted on the template.
#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>

#include "core/values/errors.h"
#include "pipeline/run/opened_project.h"
#include "studio/project/photo_picks.h"
#include "studio/project/picks.h"
#include "studio/project/timeline.h"
#include "studio/runs/children.h"
#include "studio/server/routes.h"

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

void Routes::AddLandmarks() {
  const auto picks = [](Snapshot& now, const std::string& pose) {
    return now.IsFitted(pose) ? PhotoPicksJson(now, pose) : PicksJson(now, pose);
  };
  Add("GET", "/api/landmarks", [this, picks](const Question& question) {
    const std::string pose = question.Need("pose");
    return JsonAnswer(With([&](Snapshot& now) { return picks(now, pose); }));
  });
  // The answer is what was saved, not what another tab has saved meanwhile.
  Add("PUT", "/api/landmarks", [this, picks](const Question& question) {
    const std::string pose = question.Need("pose");
    return JsonAnswer(With([&](Snapshot& now) {
      (now.IsFitted(pose) ? SavePhotoPicks : SavePicks)(now, pose, question.Json());
      return picks(now, pose);
    }));
  });
  Add("POST", "/api/landmarks/import", [this, picks](const Question& question) {
    const std::string pose = question.Need("pose");
    const json body = question.Json();
    return JsonAnswer(With([&](Snapshot& now) {
      ImportPicks(now, pose, body.at("name"), body.at("text"));
      return picks(now, pose);
    }));
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
  Add("GET", "/api/landmarks/fit", [this](const Question& question) {
    return JsonAnswer(With([&](Snapshot& now) { return PairFitJson(now, question.Need("pose")); }));
  });
  Add("GET", "/api/landmarks/photographs", [this](const Question& question) {
    return JsonAnswer(
        With([&](Snapshot& now) { return PhotoFitJson(now, question.Need("pose")); }));
  });
  Add("POST", "/api/landmarks/suggest",
      [this](const Question& question) { return Suggest(question); });
  AddPaint();
}

void Routes::AddPaint() {
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
      const json body = question.Json();
      SaveRegions(now, body);
      FollowPaintedRegions(now, body.at("regions"));
      return RegionsJson(now);
    }));
  });
}

Answer Routes::Suggest(const Question& question) {
  const json body = question.Json();
  const std::string pose = body.at("pose");
  const double count = body.at("count");
  if (!(count >= 1 && count <= 100)) throw UsageError("suggest 1 to 100 landmarks");
  const OwnFile suggested(folder_ / ".keypose/studio");
  std::vector<std::string> words = {(pipeline::ProgramFolder() / "keypose-landmarks").string(),
                                    "suggest",
                                    "--suggested",
                                    suggested.path.string(),
                                    "--count",
                                    std::to_string(static_cast<int>(count))};
  With([&](Snapshot& now) {
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
  const ChildResult result = RunChild(words, folder_, kSuggestSeconds);
  if (result.exit_code != 0) throw InputError(result.output);
  return JsonAnswer(
      With([&](Snapshot& now) { return SuggestionsJson(now, pose, suggested.path); }));
}

}  // namespace keypose::studio
