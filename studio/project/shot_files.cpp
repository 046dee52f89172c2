#include "studio/project/shot_files.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/disk/real_disk.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::ShotRule;

const ShotRule& ShotOf(Snapshot& snapshot) {
  if (!snapshot.file().shot) throw UsageError("the project has no filmed shot yet");
  return *snapshot.file().shot;
}

std::string TextOf(const pipeline::Setting* setting) { return setting ? setting->text : ""; }

fs::path Resolved(Snapshot& snapshot, const std::string& text) {
  return snapshot.project() /
         pipeline::OnDisk(pipeline::RealDisk(), snapshot.project(), pipeline::WithHome(text));
}

bool IsInProject(Snapshot& snapshot, const fs::path& path) {
  return IsWithin(fs::weakly_canonical(path), fs::canonical(snapshot.project()));
}

std::vector<FilmPicture> PicturesOf(const fs::path& film) {
  std::vector<FilmPicture> pictures = FilmPictures(film);
  std::erase_if(pictures, [&](const FilmPicture& picture) {
    return pipeline::RealDisk().LeadsOutside(picture.path, film);
  });
  return pictures;
}

int WholeField(const json& object, const char* name) {
  constexpr std::int64_t kMost = 1'000'000'000;
  const json value = object.value(name, json());
  if (!value.is_number_integer() || value.get<std::int64_t>() < 0 ||
      value.get<std::int64_t>() > kMost)
    throw UsageError(fmt::format("'{}' must be a whole number from 0", name));
  return value.get<int>();
}

}  // namespace keypose::studio
