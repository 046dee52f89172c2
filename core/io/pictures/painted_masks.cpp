#include "core/io/pictures/painted_masks.h"

#include <nlohmann/json.hpp>

#include "core/io/pictures/image_kind.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose {

namespace fs = std::filesystem;
using nlohmann::json;

PaintedMasks ReadPaintedMasks(const fs::path& folder) {
  const fs::path file = folder / kPaintedNotes;
  PaintedMasks masks;
  if (!fs::is_regular_file(file)) return masks;
  const std::string text = ReadFile(file);
  RequireShallowJson(text, file.string());
  try {
    const json root = json::parse(text);
    for (const auto& [name, entry] : root.at("masks").items())
      masks[name] = {entry.at("mask"), entry.at("photograph")};
  } catch (const json::exception& error) {
    throw InputError(file.string() + " is damaged (" + JsonFault(error) +
                     "); delete it, and all masks beside it count for the photographs of their "
                     "names");
  }
  return masks;
}

void WritePaintedMasks(const fs::path& folder, const PaintedMasks& masks) {
  const fs::path file = folder / kPaintedNotes;
  if (masks.empty()) {
    fs::remove(file);
    return;
  }
  json list = json::object();
  for (const auto& [name, one] : masks)
    list[name] = {{"mask", one.mask}, {"photograph", one.photograph}};
  WriteFileAtomically(file, json{{"schema", 1}, {"masks", list}}.dump(1) + "\n");
}

bool IsOfAnother(const PaintedMasks& masks, const std::string& name, const PaintedMask& now) {
  const auto note = masks.find(name);
  return note != masks.end() && note->second.mask == now.mask &&
         note->second.photograph != now.photograph;
}

}  // namespace keypose
