// The files that pipeline.yaml's `shot` names. For the other files of the shot.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/io/project/shot_io.h"
#include "studio/project/snapshot.h"

namespace keypose::studio {

/// @throws UsageError  the project has none
const pipeline::ShotRule& ShotOf(Snapshot& snapshot);

/// "" where nothing is set.
std::string TextOf(const pipeline::Setting* setting);

/// Where a path of pipeline.yaml leads.
std::filesystem::path Resolved(Snapshot& snapshot, const std::string& text);
/// Links resolved.
bool IsInProject(Snapshot& snapshot, const std::filesystem::path& path);

/// The pictures of a film, without those that are links to other places.
/// @throws InputError  as FilmPictures
std::vector<FilmPicture> PicturesOf(const std::filesystem::path& film);

/// A field of a request. @throws UsageError  it is no whole number from 0
int WholeField(const nlohmann::json& object, const char* name);

}  // namespace keypose::studio
