// A pose's photographs, their masks and cameras.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "studio/project/not_found.h"
#include "studio/project/snapshot.h"

namespace keypose::studio {

/// All photographs of a pose: what capture and masks measured, and those that are not made yet, or
/// were shot again since. "photograph": SHA-256 of its file. "mask_of_another": a person's mask is
/// there, but was painted over another photograph of that name, and is not used. "left_out": a
/// person leaves it out, and no step reads it.
nlohmann::json PhotographsJson(Snapshot& snapshot, const std::string& pose);

/// The file of a photograph: as captured, or the original where that is new.
/// @param as_captured  the captured one even if the photograph was shot again since
/// @throws NotFound  no such photograph
std::filesystem::path PhotographSource(Snapshot& snapshot, const std::string& pose,
                                       const std::string& name, bool as_captured = false);

/// A JPEG or PNG of a photograph, upright, at most `width` pixels wide (0: full size). Made once,
/// and kept. Safe to call from many threads.
/// @param folder  where pictures are kept
std::filesystem::path PictureFile(const std::filesystem::path& folder,
                                  const std::filesystem::path& photograph, int width);

/// The mask that a person has made of this photograph, else the computed one.
/// @param stage  "capture", or "masks" for those that agree with all views
/// @throws NotFound
std::filesystem::path MaskFile(Snapshot& snapshot, const std::string& pose, const std::string& name,
                               const std::string& stage);

/// Width and height as captured [px]; 0 if it is not captured yet, or was shot again since.
std::pair<int, int> PhotographSize(Snapshot& snapshot, const std::string& pose,
                                   const std::string& name);

/// A mask as a PNG of the photograph's size, which the page lays over it.
/// @param folder  where pictures are kept
std::filesystem::path MaskPicture(const std::filesystem::path& folder,
                                  const std::filesystem::path& mask, int width, int height);

/// Where the photographs were taken.
nlohmann::json CamerasJson(Snapshot& snapshot, const std::string& pose);

}  // namespace keypose::studio
