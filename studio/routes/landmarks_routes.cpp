#include "studio/routes/landmarks_routes.h"

#include <fmt/format.h>

#include "core/values/errors.h"
#include "pipeline/run/opened_project.h"
#include "studio/project/mirrored_picks.h"
#include "studio/project/page_timeline.h"
#include "studio/project/photo_picks.h"
#include "studio/project/picks.h"
#include "studio/routes/armature_setup.h"
#include "studio/runs/suggesting.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

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
  table.Get("/api/landmarks/mirrored", [this](const Question& question) {
    return JsonAnswer(project_.With(
        [&](Snapshot& now) { return MirroredPicksJson(now, question.Need("pose")); }));
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
  SuggestQuestion asked;
  asked.count = static_cast<int>(WithinRange(body.at("count"), 1, 100, "a number of landmarks"));
  project_.With([&](Snapshot& now) {
    const std::string whole = now.graph().template_pose;
    for (const auto& [mesh, of] :
         {std::pair{&asked.source, whole}, std::pair{&asked.target, pose}}) {
      const auto path = now.PickedMesh(of);
      if (!path) throw UsageError(fmt::format("pose '{}' has no mesh to pick on yet", of));
      *mesh = *path;
    }
    const fs::path known = ExistingPicks(now, whole), there = ExistingPicks(now, pose);
    if (!known.empty() && !there.empty()) asked.known = {known, there};
    return 0;
  });
  const Suggested suggested(project_.folder(), asked);
  json pairs = json::array();
  if (suggested.why_none().empty())
    pairs =
        project_.With([&](Snapshot& now) { return SuggestionsJson(now, pose, suggested.file()); });
  return JsonAnswer({{"pairs", pairs}, {"why_none", suggested.why_none()}});
}

}  // namespace keypose::studio
