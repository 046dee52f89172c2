#include "studio/project/failure_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "core/io/text/files.h"
#include "pipeline/run/builder.h"
#include "studio/project/not_found.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::Step;

namespace {

constexpr std::string_view kEnding = ".failed.jpg";

fs::path FailureFolder(Snapshot& snapshot, const std::string& id) {
  return snapshot.opened_project().state() / "failed" / pipeline::FolderName(id);
}

/// Their names.
std::vector<std::string> FailurePicturesOf(Snapshot& snapshot, const Step& step) {
  const auto& last = snapshot.plan()[static_cast<int>(&step - snapshot.graph().steps.data())].last;
  const fs::path folder = FailureFolder(snapshot, step.id);
  if (!last || !last->failed || !fs::is_directory(folder)) return {};
  std::vector<std::string> pictures = snapshot.opened_project().disk().Children(folder);
  std::erase_if(pictures, [&](const std::string& name) {
    return !name.ends_with(kEnding) || !IsValidUtf8(name) ||
           snapshot.opened_project().disk().LeadsOutside(folder / name, folder);
  });
  std::sort(pictures.begin(), pictures.end());
  return pictures;
}

}  // namespace

json FailurePicturesJson(Snapshot& snapshot, const Step& step) {
  json pictures = json::array();
  for (const std::string& name : FailurePicturesOf(snapshot, step)) {
    const auto stat =
        snapshot.opened_project().disk().Stat(FailureFolder(snapshot, step.id) / name);
    pictures.push_back({{"step", step.id},
                        {"picture", name},
                        {"version", std::to_string(stat ? stat->mtime_ns : 0)}});
  }
  return pictures;
}

fs::path FailurePictureFile(Snapshot& snapshot, const std::string& step, const std::string& name) {
  const Step& failed = snapshot.graph().steps[snapshot.graph().Find(step).front()];
  const std::vector<std::string> pictures = FailurePicturesOf(snapshot, failed);
  if (std::find(pictures.begin(), pictures.end(), name) == pictures.end())
    throw NotFound(fmt::format("{} left no picture '{}'", failed.id, name));
  return FailureFolder(snapshot, failed.id) / name;
}

std::string WithoutPicturePaths(std::string said) {
  for (std::size_t end; (end = said.find(kEnding)) != said.npos;) {
    const std::size_t clause = said.rfind("; ", end);
    const std::size_t begin = clause == said.npos ? said.find_last_of(" \n", end) : clause;
    end += kEnding.size();
    if (begin == said.npos)
      said.erase(0, end);
    else
      said.erase(begin, end - begin);
  }
  return said;
}

}  // namespace keypose::studio
