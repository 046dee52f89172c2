#include "composite/locate_clicks.h"

#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/io/text/json_pick.h"
#include "core/values/errors.h"

namespace keypose::composite {
namespace {

using nlohmann::json;

/// @return -1: not said
int FrameOf(const json& entry, const JsonPick<json>& click) {
  if (!entry.contains("frame")) return -1;
  constexpr int kMostFrame = 100'000'000;
  const json& frame = entry["frame"];
  if (!frame.is_number_integer() || frame < 0 || frame > kMostFrame)
    click.Fail("has a 'frame' that is not a number from 0");
  return frame.get<int>();
}

}  // namespace

std::vector<FrameClick> ReadClicks(const std::filesystem::path& path, const Mesh& mesh, int width,
                                   int height) {
  const json root = ReadJson<json>(path);
  const std::string name = PrintableName(path);
  if (!root.is_object() || !root.contains("clicks") || !root["clicks"].is_array())
    throw InputError(name + " has no list 'clicks'; docs/file-formats.md shows the format");
  std::vector<FrameClick> clicks;
  for (const json& entry : root["clicks"]) {
    const JsonPick<json> click(entry, name, "click", static_cast<int>(clicks.size()) + 1);
    clicks.push_back(
        {FrameOf(entry, click),
         {click.title(), click.Pixel(width, height, "the picture"), click.Point(mesh, "mesh")}});
  }
  if (clicks.empty()) throw InputError(name + " has no clicks");
  return clicks;
}

}  // namespace keypose::composite
