#include "core/io/pictures/other_thing_notes.h"

#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

constexpr const char* kNotesFile = "other_things.json";

}  // namespace

OtherThingNotes ReadOtherThingNotes(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / kNotesFile;
  if (!std::filesystem::exists(file)) return {};
  try {
    return nlohmann::json::parse(ReadFile(file)).get<OtherThingNotes>();
  } catch (const nlohmann::json::exception&) {
    throw InputError(file.string() +
                     " does not say by name why photographs were left out; run capture again");
  }
}

void WriteOtherThingNotes(const std::filesystem::path& folder, const OtherThingNotes& notes) {
  if (!notes.empty())
    WriteFileAtomically(folder / kNotesFile, nlohmann::json(notes).dump(1) + "\n");
}

}  // namespace keypose
