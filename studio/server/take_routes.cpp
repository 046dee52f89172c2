// A recorded take on its page: shown as changes would make it, and kept as a new one.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "core/values/errors.h"
#include "core/io/text/files.h"
#include "pipeline/disk/real_disk.h"
#include "studio/project/take_use.h"
#include "studio/server/armature_setup.h"
#include "studio/server/routes.h"

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

void Routes::AddTakes() {
  takes_ = std::make_unique<TakeDesk>(folder_);
  Add("GET", "/api/armature/take/setup", [this](const Question& question) {
    return JsonAnswer(SetupJsonOfTake(folder_, question.Need("take")));
  });
  Add("POST", "/api/armature/take/open", [this](const Question& question) {
    const json body = question.Json();
    const ArmatureSetup setup = SetupToOpen(folder_, body);
    takes_->MakeCharacter(setup);
    if (body.contains("setup")) KeepSetupOfTake(folder_, setup);
    json answer = {{"set", !setup.set.empty()}, {"texture", !setup.texture.empty()}};
    answer["view"] = json::parse(ReadFile(takes_->CharacterFolder(setup.take) / "view.json"));
    return JsonAnswer(answer);
  });
  Add("POST", "/api/armature/take/draft", [this](const Question& question) {
    const json body = question.Json();
    const ArmatureSetup setup = SetupOfTake(folder_, TakeName(body.at("take")));
    return BytesAnswer(takes_->Draft(setup, EditsFrom(body), body.value("between", "")));
  });
  Add("POST", "/api/armature/take/save", [this](const Question& question) {
    const json body = question.Json();
    ArmatureSetup setup = SetupOfTake(folder_, TakeName(body.at("take")));
    const EditLines edits = EditsFrom(body);
    const std::string name = NewTakeName(folder_, body.at("name"));
    takes_->Save(setup, edits, name);
    setup.take = name;
    KeepSetupOfTake(folder_, setup);
    return JsonAnswer({{"take", name}});
  });
  AddTakeUses();
}

/// Its baked frames as a part of the project.
void Routes::AddTakeUses() {
  const auto use = [this](const std::string& take) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return JsonAnswer(TakeUseJson(folder_, BakedTakeOf(SetupOfTake(folder_, take))));
  };
  Add("GET", "/api/armature/take/use",
      [use](const Question& question) { return use(question.Need("take")); });
  Add("PUT", "/api/armature/take/use", [this, use](const Question& question) {
    const json body = question.Json();
    const std::string take = TakeName(body.at("take"));
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      SaveTakeUse(folder_, BakedTakeOf(SetupOfTake(folder_, take)), body.at("use"), body.at("used"),
                  body.at("revision"));
    }
    stale_ = true;
    return use(take);
  });
}

}  // namespace keypose::studio
