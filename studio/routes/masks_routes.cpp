#include "studio/routes/masks_routes.h"

#include <fmt/format.h>

#include "core/values/errors.h"
#include "studio/project/changes.h"
#include "studio/project/own_masks.h"
#include "studio/project/pose_photographs.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

void MasksRoutes::AddTo(RouteTable& table) {
  table.Get("/api/mask", [this](const Question& question) {
    std::pair<int, int> size;
    const fs::path mask = project_.With([&](Snapshot& now) {
      size = PhotographSize(now, question.Need("pose"), question.Need("name"));
      return MaskFile(now, question.Need("pose"), question.Need("name"),
                      question.Get("stage", "masks"));
    });
    return PictureAnswer(MaskPicture(project_.PictureFolder(), mask, size.first, size.second));
  });
  table.Put("/api/mask", [this](const Question& question) {
    const std::string pose = question.Need("pose"), name = question.Need("name");
    const std::string revision = project_.With([&](Snapshot& now) {
      const auto tag = [&, size = PhotographSize(now, pose, name)](const fs::path& mask) {
        return TagOf(MaskPicture(project_.PictureFolder(), mask, size.first, size.second));
      };
      if (!now.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
      const fs::path own = OwnMasks(now, pose).InForce(name);
      if (question.query.contains("revision") && !own.empty() &&
          tag(own) != question.Need("revision"))
        throw ChangedMeanwhile(fmt::format(
            "the mask of {} was changed elsewhere, and is not written over; open it again", name));
      return tag(SaveMask(now, pose, name, question.body, question.Get("photograph")));
    });
    return JsonAnswer({{"saved", true}, {"revision", revision}});
  });
  table.Post("/api/masks/hold", [this](const Question& question) {
    const json body = question.Json();
    project_.With([&](Snapshot& now) {
      DecideMasks(now, body.at("pose"), body.at("names"), body.at("hold"));
      return 0;
    });
    return JsonAnswer({{"done", true}});
  });
}

}  // namespace keypose::studio
