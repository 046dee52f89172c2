#include "studio/routes/new_project_routes.h"

#include "studio/project/changes.h"
#include "studio/project/overview.h"

namespace keypose::studio {

void NewProjectRoutes::AddTo(RouteTable& table) {
  table.Post("/api/project", [this](const Question& question) {
    const nlohmann::json body = question.Json();
    if (body.contains("shots")) {
      CreatePerformance(project_.folder(), {body.at("shots"), body.value("video3d", false),
                                            body.value("surface", false)});
      // Its plan may lack a calibration yet; then its problem is told.
      return JsonAnswer({{"made", true}});
    }
    CreateProject(project_.folder(), body.at("poses"), body.at("template"),
                  body.value("few", std::vector<std::string>{}));
    return JsonAnswer(project_.With([](Snapshot& now) { return ProjectJson(now); }));
  });
}

}  // namespace keypose::studio
