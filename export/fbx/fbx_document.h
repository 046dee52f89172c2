// What an FBX file says about the whole scene: axes, unit, frame rate, what it holds.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "export/fbx/fbx_records.h"

namespace keypose::exporting {

/// FBX counts time in whole ticks; all common frame rates divide this number.
constexpr double kFbxTicksPerSecond = 46186158000.0;
std::int64_t FbxTicks(double seconds);

/// Objects and how they hang together. Ids are unique; id 0 is the scene.
struct FbxObjects {
  std::vector<FbxRecord> objects;
  std::vector<FbxRecord> connections;

  /// `child` belongs to `parent`, or to one of its properties.
  void Connect(std::int64_t child, std::int64_t parent, const std::string& property = "");
};

struct FbxDocument {
  std::string title;
  std::string animation;  ///< name of the animation; empty: there is none
  double fps = 24;
  double seconds = 0;  ///< the end of the animation
};

/// A record of a property list, as in {"UpAxis", "int", "Integer", "", 1}.
FbxRecord FbxProperties(const std::vector<std::vector<FbxValue>>& properties);

/// All records of a file with +y up, +z towards the viewer and metres as unit.
std::vector<FbxRecord> FbxFile(const FbxDocument& document, FbxObjects objects);

}  // namespace keypose::exporting
