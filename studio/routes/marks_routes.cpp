#include "studio/routes/marks_routes.h"

#include "core/io/meshes/mesh_io.h"
#include "core/values/errors.h"
#include "studio/meshes/mesh_bytes.h"
#include "studio/project/marks.h"
#include "studio/project/not_found.h"
#include "studio/project/pose_photographs.h"
#include "studio/routes/armature_setup.h"
#include "studio/runs/suggesting.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// @throws NotFound  there is none by now
fs::path MarkedMeshOf(Snapshot& now, const std::string& name) {
  const auto side = MarkSideNamed(name);
  if (!side) throw UsageError("a mark is on the body and on the scan");
  const auto file = MarkedMesh(now, *side);
  if (!file) throw NotFound("there is no such mesh yet");
  return *file;
}

}  // namespace

void MarksRoutes::AddTo(RouteTable& table) {
  table.Get("/api/marks", [this](const Question&) {
    return JsonAnswer(project_.With([](Snapshot& now) { return MarksJson(now); }));
  });
  table.Put("/api/marks", [this](const Question& question) {
    return JsonAnswer(project_.With([&](Snapshot& now) {
      SaveMarks(now, question.Json());
      return MarksJson(project_.ReadAgain());
    }));
  });
  table.Get("/api/marks/mesh", [this](const Question& question) {
    const fs::path file =
        project_.With([&](Snapshot& now) { return MarkedMeshOf(now, question.Need("side")); });
    return BytesAnswer(MeshBytes(ReadMesh(file)));
  });
  table.Get("/api/marks/texture", [this](const Question&) {
    const auto file = project_.With([](Snapshot& now) { return ScanTexture(now); });
    if (!file) throw NotFound("the scan has no texture");
    return PictureAnswer(PictureFile(project_.PictureFolder(), *file, 0));
  });
  table.Post(
      "/api/marks/suggest", [this](const Question& question) { return Suggest(question); },
      Changes::kNothing);
  table.Post("/api/marks/scan", [this](const Question& question) {
    const json body = question.Json();
    return JsonAnswer(project_.With([&](Snapshot& now) {
      UseScan(now, body.at("scan"), body.value("texture", ""));
      return MarksJson(project_.ReadAgain());
    }));
  });
}

Answer MarksRoutes::Suggest(const Question& question) {
  SuggestQuestion asked;
  asked.count =
      static_cast<int>(WithinRange(question.Json().at("count"), 1, 100, "a number of marks"));
  project_.With([&](Snapshot& now) {
    asked.source = MarkedMeshOf(now, "body");
    asked.target = MarkedMeshOf(now, "scan");
    const fs::path known = MarksFile(now);
    if (fs::is_regular_file(known)) asked.known = {known};
    return 0;
  });
  const Suggested suggested(project_.folder(), asked);
  json pairs = json::array();
  if (suggested.why_none().empty())
    pairs = project_.With([&](Snapshot& now) { return SuggestedMarksJson(now, suggested.file()); });
  return JsonAnswer({{"pairs", pairs}, {"why_none", suggested.why_none()}});
}

}  // namespace keypose::studio
