#include "studio/routes/take_routes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "pipeline/disk/real_disk.h"
#include "studio/project/take_use.h"
#include "studio/routes/armature_setup.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::size_t kMostEdits = 10000, kLongestEdit = 300;

/// What the lines say is judged by the program; here, that they are lines.
EditLines EditsFrom(const json& body) {
  EditLines edits = body.at("edits");
  if (edits.size() > kMostEdits)
    throw UsageError(
        fmt::format("there are {} changes; {} are possible at once: save the take, and go on with "
                    "the new one",
                    edits.size(), kMostEdits));
  for (const std::string& line : edits)
    if (line.size() > kLongestEdit ||
        std::any_of(line.begin(), line.end(), [](unsigned char c) { return std::iscntrl(c); }))
      throw UsageError("a change is one line of at most 300 letters");
  return edits;
}

BakedTake BakedTakeOf(const ArmatureSetup& setup) {
  return {setup.take, setup.texture, setup.plate, setup.shot, setup.set};
}

/// With the files that the page names, or those that are known.
ArmatureSetup SetupToOpen(const fs::path& project, const json& body) {
  const std::string take = TakeName(body.at("take"));
  if (!body.contains("setup")) return SetupOfTake(project, take);
  RequireTake(project, take);
  json setup = body.at("setup");
  setup["take"] = take;
  return ArmatureSetupFrom(setup, project);
}

std::string NewTakeName(const fs::path& project, const json& wanted) {
  const std::string name = TakeName(wanted);
  const fs::path folder = project / "armature" / name;
  std::error_code error;
  if (fs::exists(fs::symlink_status(folder, error)))
    throw LockedError(
        fmt::format("there is a folder armature/{} already; choose another name", name));
  if (pipeline::RealDisk().LeadsOutside(folder, project))
    throw UsageError("the folder armature leads out of the project");
  return name;
}

}  // namespace

TakeRoutes::TakeRoutes(SharedProject& project) : PageRoutes(project), takes_(project.folder()) {}

void TakeRoutes::AddTo(RouteTable& table) {
  AddDrafts(table);
  AddUses(table);
}

void TakeRoutes::AddDrafts(RouteTable& table) {
  table.Get("/api/armature/take/setup", [this](const Question& question) {
    return JsonAnswer(SetupJsonOfTake(project_.folder(), question.Need("take")));
  });
  table.Post(
      "/api/armature/take/open",
      [this](const Question& question) {
        const json body = question.Json();
        const ArmatureSetup setup = SetupToOpen(project_.folder(), body);
        takes_.MakeCharacter(setup);
        if (body.contains("setup")) KeepSetupOfTake(project_.folder(), setup);
        json answer = {{"set", !setup.set.empty()}, {"texture", !setup.texture.empty()}};
        answer["view"] = json::parse(ReadFile(takes_.CharacterFolder(setup.take) / "view.json"));
        return JsonAnswer(answer);
      },
      Changes::kQuietly);
  table.Post(
      "/api/armature/take/draft",
      [this](const Question& question) {
        const json body = question.Json();
        const ArmatureSetup setup = SetupOfTake(project_.folder(), TakeName(body.at("take")));
        return BytesAnswer(takes_.Draft(setup, EditsFrom(body), body.value("between", "")));
      },
      Changes::kQuietly);
  table.Post(
      "/api/armature/take/save",
      [this](const Question& question) {
        const json body = question.Json();
        ArmatureSetup setup = SetupOfTake(project_.folder(), TakeName(body.at("take")));
        const EditLines edits = EditsFrom(body);
        const std::string name = NewTakeName(project_.folder(), body.at("name"));
        takes_.Save(setup, edits, name);
        setup.take = name;
        KeepSetupOfTake(project_.folder(), setup);
        return JsonAnswer({{"take", name}});
      },
      Changes::kQuietly);
}

/// Its baked frames as a part of the project.
void TakeRoutes::AddUses(RouteTable& table) {
  const auto use = [this](const std::string& take) {
    return JsonAnswer(project_.WithFolder([&](const fs::path& folder) {
      return TakeUseJson(folder, BakedTakeOf(SetupOfTake(folder, take)));
    }));
  };
  table.Get("/api/armature/take/use",
            [use](const Question& question) { return use(question.Need("take")); });
  table.Put("/api/armature/take/use", [this, use](const Question& question) {
    const json body = question.Json();
    const std::string take = TakeName(body.at("take"));
    project_.WithFolder([&](const fs::path& folder) {
      SaveTakeUse(folder, BakedTakeOf(SetupOfTake(folder, take)), body.at("use"), body.at("used"),
                  body.at("revision"));
      return 0;
    });
    project_.Forget();
    return use(take);
  });
}

}  // namespace keypose::studio
