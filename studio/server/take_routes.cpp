// A recorded take on its page: shown as changes would make it, and kept as a new one.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "core/errors.h"
#include "core/io/files.h"
#include "pipeline/real_disk.h"
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

}  // namespace

void Routes::AddTakes() {
  takes_ = std::make_unique<TakeDesk>(folder_);
  Add("POST", "/api/armature/take/open", [this](const Question& question) {
    const ArmatureSetup setup = SetupOfTake(folder_, TakeName(question.Json().at("take")));
    takes_->MakeCharacter(setup);
    json answer = {{"set", !setup.set.empty()}, {"texture", !setup.texture.empty()}};
    answer["view"] = json::parse(ReadFile(takes_->CharacterFolder(setup.take) / "view.json"));
    return JsonAnswer(answer);
  });
  Add("POST", "/api/armature/take/draft", [this](const Question& question) {
    const json body = question.Json();
    const ArmatureSetup setup = SetupOfTake(folder_, TakeName(body.at("take")));
    return BytesAnswer(takes_->Draft(setup, EditsFrom(body)));
  });
  Add("POST", "/api/armature/take/save", [this](const Question& question) {
    const json body = question.Json();
    ArmatureSetup setup = SetupOfTake(folder_, TakeName(body.at("take")));
    const EditLines edits = EditsFrom(body);
    const std::string name = TakeName(body.at("name"));
    const fs::path folder = folder_ / "armature" / name;
    std::error_code error;
    if (fs::exists(fs::symlink_status(folder, error)))
      throw LockedError(
          fmt::format("there is a folder armature/{} already; choose another name", name));
    if (pipeline::RealDisk().LeadsOutside(folder, folder_))
      throw UsageError("the folder armature leads out of the project");
    takes_->Save(setup, edits, name);
    setup.take = name;
    KeepSetupOfTake(folder_, setup);
    return JsonAnswer({{"take", name}});
  });
}

}  // namespace keypose::studio
